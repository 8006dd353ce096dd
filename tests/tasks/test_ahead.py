"""Kernels compiled beside the work: the list of them, and the process that does it, which leaves nothing behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Event

import pytest
from long import but_some

import intarsia as ia
from intarsia.cli.report import Helper, Report
from intarsia.kernels import announcing
from intarsia.kernels.cache import cache_folder
from intarsia.kernels.listed import compile_line, kernel_of, line_of
from intarsia.methods.base import METHODS
from intarsia.tasks import ahead, tiny_textures, warming

ROOT = Path(__file__).parents[2]
EVERY = ahead.every_kernel()


def test_every_line_names_a_kernel_and_its_types_and_is_what_would_be_written() -> None:
    assert len(EVERY) > 100
    assert [line_of(*kernel_of(line)) for line in EVERY] == EVERY


@pytest.mark.parametrize(
    "line", ["", "1", "x", "os.system(int64)", "kernels.paths.nothing()", "kernels.paths.trace(array(int64, 2, X))",
             "kernels.paths.trace(text)", "kernels.paths.trace(array(int64))", "kernels.paths.BARRED(int64)", "x.",
             "kernels.union_find.find_root(int64)"],
)  # fmt: skip
def test_a_line_that_names_no_kernel_is_refused(line: str) -> None:
    with pytest.raises(ValueError, match="no kernel"):
        kernel_of(line)


@pytest.mark.parametrize("name", but_some([*METHODS, "grow stones", "grow tiles"], "grow stones", "repeat"))
def test_the_list_holds_what_a_command_runs(name: str) -> None:
    """Where this fails a kernel has other types than before, or is new: `make tables` writes the list anew."""
    command = [sys.executable, str(ROOT / "tools" / "list_kernels.py"), "--run", name]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    needed = set(json.loads(done.stdout.splitlines()[-1]))
    words = (name, *("auto", "auto-graphcut", "auto-near-regular") * name.startswith("grow"))
    kept = {line for word in words for line in ahead.lists().get(word, ())}
    assert not needed - kept
    if name in METHODS:
        assert not kept - needed


def test_types_that_a_kernel_cannot_take_are_refused() -> None:
    """A list may be older than a kernel; it must end nothing."""
    with pytest.raises(ValueError, match="no types of this kernel"):
        compile_line("kernels.union_find.find_root(int64, int64)")


def gone(pid: int) -> bool:
    """Whether a process has ended, or does so within ten seconds."""
    for _ in range(200):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        state = Path(f"/proc/{pid}/stat")
        if state.exists() and state.read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        time.sleep(0.05)
    return False


def test_what_was_begun_is_swept_when_the_process_is_ended() -> None:
    process = ahead.Beside()
    folder = Path(cache_folder() or pytest.skip("no folder"))
    begun = folder / f"x.kernel.{process.process:x}-0123456789abcdef"
    begun.write_bytes(b"half")
    assert process.close() is None
    assert not begun.exists()
    assert gone(process.process)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="asks for processes as of POSIX")
def test_the_process_ends_with_the_one_that_it_works_for() -> None:
    script = "import os\nfrom intarsia.tasks.ahead import Beside\nprint(Beside().process, flush=True)\nos._exit(9)"
    done = subprocess.run([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, check=False)
    assert gone(int(done.stdout))


def test_a_process_that_dies_is_told_of_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ahead, "ALONE", "raise SystemExit(3)")
    monkeypatch.setattr("intarsia.run.cores", lambda: 2)
    report = Report(quiet=True)
    helper = Helper("graphcut", None, report)
    helper.begin()
    assert helper._process is not None
    helper._process._process.wait()
    helper.turn_to("near-regular")  # into a pipe that nobody reads
    helper.close()
    assert report.warnings == ["a process that compiled beside this one ended early (3); this one did it instead."]


def test_what_compiled_nothing_starts_no_process_later(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that carries out many commands would start one for each at the first kernel that is missing."""
    started: list[str] = []
    monkeypatch.setattr(announcing, "_waiting", [])
    monkeypatch.setattr(Helper, "begin", lambda helper: started.append(helper._slug))
    report = Report(quiet=True)
    with report.compiling("graphcut", None):
        pass
    with report.compiling("near-regular", None):
        announcing.compilation_begins()
    assert started == ["near-regular"]


@pytest.mark.parametrize(("slug", "threads"), [("repeat", None), ("graphcut", 1)])
def test_no_process_is_started_for_little_or_where_one_thread_is_asked_for(slug: str, threads: int | None) -> None:
    helper = Helper(slug, threads, Report(quiet=True))
    helper.begin()
    assert helper._process is None


@pytest.fixture
def three_tiny(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Have warming up grow three textures, on two cores; what is grown by this process is noted."""
    grown: list[int] = []
    monkeypatch.setattr(warming, "cores", lambda: 2)
    monkeypatch.setattr(warming, "every_kernel", list)
    monkeypatch.setattr(warming, "kinds", lambda: [{}, {}, {}])
    monkeypatch.setattr(tiny_textures, "grow_tiny", lambda number, run: grown.append(number))
    return grown


def test_warming_up_does_itself_what_a_process_left_that_died(
    monkeypatch: pytest.MonkeyPatch, three_tiny: list[int]
) -> None:
    monkeypatch.setattr(ahead, "ALONE", "import sys\nsys.stdin.readline()\nraise SystemExit(3)")
    run = ia.Run(2)
    assert warming.warm_up(run) == 3
    assert sorted(three_tiny) == [0, 1, 2]
    assert run.notes == ["a process that compiled beside this one ended early; its part was done here."]


def test_a_process_beside_takes_from_the_end(
    monkeypatch: pytest.MonkeyPatch, three_tiny: list[int], tmp_path: Path
) -> None:
    """And none of it is done twice: here this one waits at the first until the other has done the rest."""
    done = tmp_path / "done"
    answering = f"import sys\nfor line in sys.stdin:\n print(line, file=open({str(done)!r}, 'a'))\n print(flush=True)"
    monkeypatch.setattr(ahead, "ALONE", answering)

    def wait(number: int, run: ia.Run) -> None:
        three_tiny.append(number)
        until = time.monotonic() + 60
        while not (done.exists() and len(done.read_text().split("\n\n")) > 2) and time.monotonic() < until:
            time.sleep(0.01)

    monkeypatch.setattr(tiny_textures, "grow_tiny", wait)
    run = ia.Run(2)
    assert warming.warm_up(run) == 3
    assert three_tiny == [0]
    assert done.read_text().split() == ["only", "grow", "2", "only", "grow", "1"]
    assert run.notes == []


@pytest.mark.parametrize(("threads", "cores", "processes"), [(1, 4, 0), (2, 4, 1), (1000, 3, 2), (1000, 99, 7)])
def test_no_more_processes_warm_up_than_there_are_cores(
    monkeypatch: pytest.MonkeyPatch, three_tiny: list[int], threads: int, cores: int, processes: int
) -> None:
    started: list[int] = []
    monkeypatch.setattr(warming, "cores", lambda: cores)
    monkeypatch.setattr(warming, "beside", lambda: started.append(1))
    warming.warm_up(ia.Run(threads))
    assert len(started) == processes
    assert three_tiny == [0, 1, 2]


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as of Linux")
@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_a_first_run_that_is_stopped_leaves_no_process_and_no_file(stop: signal.Signals, tmp_path: Path) -> None:
    around = {**os.environ, "INTARSIA_CACHE": str(tmp_path / "c")}
    words = [sys.executable, "-m", "intarsia", "grow", "sample:stones", "-q", "--threads", "2"]
    words += ["-o", str(tmp_path / "o.png")]
    work = subprocess.Popen(words, env=around, stderr=subprocess.DEVNULL,
                            preexec_fn=lambda: signal.signal(stop, signal.SIG_DFL))  # fmt: skip
    children = Path(f"/proc/{work.pid}/task/{work.pid}/children")
    while not (beside := children.read_text().split()) or not list((tmp_path / "c").rglob("*.kernel")):
        assert work.poll() is None
        time.sleep(0.02)
    work.send_signal(stop)
    assert work.wait(60) == 130
    assert all(gone(int(pid)) for pid in beside)
    assert [p.name for p in (tmp_path / "c").rglob("*") if p.is_file() and p.suffix != ".kernel"] == []
    assert not (tmp_path / "o.png").exists()


WARM = """
import intarsia as ia
from intarsia.kernels import compiling

began = ia.warm(SLUGS)
asked = []
compiling.before_each(lambda kernel, types: asked.append(kernel))
ia.synthesize("sample:brick", 600, METHOD)
print(began, len(asked))
"""


@pytest.mark.parametrize(("named", "method"), [("'repeat'", "'repeat'"), ("", "'auto'")])
def test_a_warm_process_grows_without_asking_for_a_kernel(named: str, method: str) -> None:
    program = WARM.replace("SLUGS", named).replace("METHOD", method)
    done = subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.PIPE, text=True)
    began, asked = map(int, done.stdout.split())
    assert began == len({line for name in ahead.lists() if name == (named.strip("'") or "auto")
                         or (not named and name.startswith("auto-")) for line in ahead.lists()[name]})  # fmt: skip
    assert asked == 0


def test_warming_refuses_what_names_no_method_and_ends_when_cancelled() -> None:
    with pytest.raises(ia.ParameterError, match="method=moss is unknown"):
        ia.warm("moss")
    with pytest.raises(ia.ParameterError, match="methods is 3"):
        ia.warm(3)  # type: ignore[arg-type]
    cancel = Event()
    cancel.set()
    with pytest.raises(ia.CancelledError):
        ia.warm("repeat", run=ia.Run(1, cancel=cancel))


GIVES_WAY = """
import threading, time
from intarsia.errors import CancelledError
from intarsia.kernels.listed import compile_line
from intarsia.run import Run
from intarsia.tasks import ahead, warming

cancel, told = threading.Event(), []
take_from = ahead.Beside.take_from

def take(self, work):
    take_from(self, work)
    told.append(self.process)
    threading.Timer(0.1, lambda: [told.append(time.monotonic()), cancel.set()]).start()

ahead.Beside.take_from = take
with warming.made_beside(run := Run(1, cancel=cancel)):
    try:
        compile_line(next(line for line in ahead.every_kernel() if line.startswith("seams.recut_kernels.recut(")))
    except CancelledError:
        took = time.monotonic() - told[1]
assert warming.missing_kernels("auto") > 40
print(told[0], took)
"""


def test_a_kernel_that_is_made_beside_holds_up_nobody(tmp_path: Path) -> None:
    """To compile it takes seconds; the run that is cancelled meanwhile ends at once, and so does the process beside."""
    done = subprocess.run(
        [sys.executable, "-c", GIVES_WAY], env=os.environ | {"INTARSIA_CACHE": str(tmp_path)}, check=True,
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    process, took = done.stdout.split()
    assert float(took) < 1
    assert gone(int(process))
    assert not list(tmp_path.rglob("*.kernel*"))
