"""What is made ready beforehand: a process that is warm loads and compiles nothing more, and one that is stopped is."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Event

import pytest

import intarsia as ia

WARM = """
import sys
import intarsia as ia

def ready():
    modules = [m for name, m in sys.modules.items() if name.startswith("intarsia.")]
    kernels = {id(k): k for m in modules for k in vars(m).values() if isinstance(getattr(k, "signatures", 0), list)}
    return {(k.__module__, k.__name__, *map(str, k.signatures)) for k in kernels.values() if k.signatures}

ia.warm(SLUGS)
before = ready()
ia.synthesize("sample:brick", 600, METHOD).render()
print(len(before), sorted(ready() - before))
"""


@pytest.mark.parametrize(("named", "method"), [("'repeat'", "'repeat'"), ("", "'auto'")])
def test_a_warm_process_grows_without_asking_for_a_kernel(named: str, method: str) -> None:
    program = WARM.replace("SLUGS", named).replace("METHOD", method)
    done = subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.PIPE, text=True)
    kernels, _, missing = done.stdout.strip().partition(" ")
    assert int(kernels) > 0
    assert missing == "[]"


def test_warming_refuses_what_names_no_method_and_ends_when_cancelled() -> None:
    with pytest.raises(ia.ParameterError, match="method=moss is unknown"):
        ia.warm("moss")
    with pytest.raises(ia.ParameterError, match="methods is 3"):
        ia.warm(3)  # type: ignore[arg-type]
    cancel = Event()
    cancel.set()
    with pytest.raises(ia.CancelledError):
        ia.warm("repeat", run=ia.Run(1, cancel=cancel))


def test_warming_tells_how_far_it_is_and_of_nothing_else() -> None:
    told: list[float] = []
    run = ia.Run(1, step=lambda done, total, draft: told.append(done / total))
    assert ia.warm("repeat", "random-tiling", run=run) == 2
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert any(0.5 <= far < 1 for far in told)
    assert run.notes == []


@pytest.mark.skipif(os.name != "posix", reason="signals as of POSIX")
@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_a_first_run_that_is_stopped_leaves_no_file_but_whole_kernels(stop: signal.Signals, tmp_path: Path) -> None:
    around = {**os.environ, "INTARSIA_CACHE": str(tmp_path / "c")}
    words = [sys.executable, "-m", "intarsia", "grow", "sample:tiles", "-m", "repeat", "-q"]
    work = subprocess.Popen([*words, "-o", str(tmp_path / "o.png")], env=around, stderr=subprocess.DEVNULL,
                            preexec_fn=lambda: signal.signal(stop, signal.SIG_DFL))  # fmt: skip
    while not list((tmp_path / "c").rglob("*.kernel")):
        assert work.poll() is None
        time.sleep(0.005)
    work.send_signal(stop)
    assert work.wait(60) in (130, 0)  # 0: it was done by then
    assert [p.name for p in (tmp_path / "c").rglob("*") if p.is_file() and p.suffix != ".kernel"] == []
