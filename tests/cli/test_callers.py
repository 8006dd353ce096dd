"""Programs that call the command line: JSON lines and nothing else, names that their users know, an end with them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli.commands import run
from click.testing import CliRunner

import intarsia as ia
from intarsia import files, kernels
from intarsia.cli import Report, callers, cli
from intarsia.plugins import CONTRACT

STEP = {"stage", "done", "total", "fraction", "remaining"}
LONG = ["grow", "layer-1.png", "-o", "out.png", "--size", "3000", "--patch", "9", "--threads", "1"]
CALLER = """
import subprocess, sys
run = subprocess.Popen([sys.executable, "-m", "intarsia", *sys.argv[1:]], stdin=subprocess.PIPE)
print(run.pid, flush=True)
run.wait()
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    pixels = np.random.default_rng(1).integers(0, 255, (40, 48, 3), np.uint8)
    files.write("layer-1.png", ia.Plane(pixels))
    files.write("layer-2.png", ia.Plane(pixels[:20].copy()))
    files.write("hole.png", ia.Plane(np.full((40, 48), 255, np.uint8)))
    return tmp_path


def lines(*words: object, code: int = 0) -> list[dict[str, Any]]:
    """What is told on stderr, every line of which must be a JSON object."""
    done = CliRunner().invoke(cli, [*map(str, words), "--progress", "json"])
    assert done.exit_code == code, done.stderr
    return [dict(json.loads(line)) for line in done.stderr.splitlines()]


def test_what_is_told_of_a_run() -> None:
    told = lines("grow", "layer-1.png", "-o", "out.png", "--size", "60", "--method", "image-quilting")
    assert {frozenset(line) for line in told} == {frozenset(STEP), frozenset({"note"}), frozenset({"result"})}
    steps = [line for line in told if "stage" in line]
    assert [s["fraction"] for s in steps] == sorted(s["fraction"] for s in steps)
    assert steps[-1]["fraction"] == 1.0
    assert all(s["remaining"] is None or s["remaining"] >= 0 for s in steps)
    assert steps[-1]["remaining"] == 0
    result = told[-1]["result"]
    assert [Path(file["path"]).name for file in result["files"]] == ["out.png"]
    printed = CliRunner().invoke(cli, ["grow", "layer-1.png", "-o", "out.png", "--size", "60", "--force", "--json", "-m", "image-quilting"])
    assert json.loads(printed.stdout) | {"timings": 0} == result | {"timings": 0}


@pytest.mark.parametrize("verb", ["score", "analyze", "maps", "export"])
def test_every_command_tells_its_result(verb: str) -> None:
    more = {"score": ["layer-1.png"], "maps": ["-o", "m/"], "export": ["-o", "e/", "--for", "godot"]}.get(verb, [])
    assert set(lines(verb, "layer-1.png", *more)[-1]) == {"result"}


@pytest.mark.parametrize(("words", "kind", "code"), [
    ("grow none.png -o out.png", "input", 3), ("grow layer-1.png -o out.png --patch 0", "parameter", 2),
    ("grow layer-1.png --unknown", "usage", 2), ("grow layer-1.png -o no/out.png", "input", 3), ("grow", "usage", 2),
    ("score layer-1.png layer-1.png --gate total=100", "quality", 4),
])  # fmt: skip
def test_the_last_line_of_a_failure_tells_its_kind_and_exit_code(words: str, kind: str, code: int) -> None:
    told = lines(*words.split(), code=code)[-1]
    assert set(told) == {"error", "kind", "exit_code"}
    assert (told["kind"], told["exit_code"]) == (kind, code)


def test_warnings_are_lines_of_their_own(capsys: pytest.CaptureFixture[str]) -> None:
    callers.begin(["grow", "--progress", "json"])
    Report().warn("it is small", "it is small")
    Report(quiet=True).warn("it is dark")
    callers.begin([])
    Report().warn("it is flat")
    assert capsys.readouterr().err == '{"warning": "it is small"}\nintarsia: warning: it is flat\n'


def test_kinds_of_errors() -> None:
    kinds = {
        ia.CancelledError("x"): "stopped", ia.MethodError("x"): "method", MemoryError(): "resource",
        OSError(28, "full"): "resource", ValueError("x"): "internal", KeyboardInterrupt(): "stopped",
    }  # fmt: skip
    assert {callers.kind_of(e) for e in kinds} == set(kinds.values())
    assert all(callers.kind_of(e) == kind for e, kind in kinds.items())


class TestNames:
    @pytest.mark.parametrize("words", [
        "heal layer-1.png --mask hole.png -o out.png", "heal {}/layer-1.png --mask {}/hole.png -o out.png",
    ])  # fmt: skip
    def test_messages_name_files_as_they_are_called(self, words: str, here: Path) -> None:
        words = words.replace("{}", str(here))
        hole, layer = (next(w for w in words.split() if w.endswith(n)) for n in ("hole.png", "layer-1.png"))
        told = lines(*words.split(), "--call", f"{hole}=selection", "--call", f"{layer}=Bark copy", code=3)[-1]
        assert told["error"].startswith("the hole selection covers all of Bark copy")
        assert "layer-1" not in told["error"]
        assert str(here) not in told["error"]

    def test_a_person_is_told_by_the_same_names(self) -> None:
        said = run("grow layer-1.png layer-2.png --set -o o.png --call layer-2.png=Normals", code=3).stderr
        assert "Normals" in said
        assert "layer-2" not in said

    def test_names_are_forgotten_by_the_next_command(self) -> None:
        run("grow none.png -o o.png --call none.png=Nothing", code=3)
        assert "none.png does not exist" in run("grow none.png -o o.png", code=3).stderr

    def test_parts_of_words_are_no_files(self) -> None:
        callers.call([("/tmp/a.png", "Layer"), ("b2.png", "Other")])
        assert callers.named("/tmp/a.png, a.png, b2 and a: banana, a.pngx, b23, /x/a.png") == (
            "Layer, Layer, Other and a: banana, a.pngx, b23, /x/a.png"
        )
        callers.call([])

    @pytest.mark.parametrize("given", ["layer-1.png", "=x", "layer-1.png=", "layer-1.png=" + 101 * "x", "a=\n"])
    def test_what_is_no_name_is_refused(self, given: str) -> None:
        assert "FILE=NAME" in run("grow", "layer-1.png", "--call", given, code=2).stderr


class TestParent:
    def begun(self, *words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "intarsia", *words, "--progress", "json", "--with-parent"]
        work = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        assert work.stderr is not None
        assert any(0 < json.loads(line).get("fraction", 0) < 0.9 for line in work.stderr)
        return work

    def test_a_run_ends_when_its_input_is_closed(self, here: Path) -> None:
        before = sorted(os.listdir(here))
        work = self.begun(*LONG)
        assert work.stdin is not None
        work.stdin.close()
        assert work.wait(10) == 130
        assert sorted(os.listdir(here)) == before
        assert work.stderr is not None
        assert json.loads(work.stderr.read().splitlines()[-1])["kind"] == "stopped"
        work.stderr.close()

    def test_a_run_ends_when_its_parent_is_killed(self, here: Path) -> None:
        before = sorted(os.listdir(here))
        words = [sys.executable, "-c", CALLER, *LONG, "--progress", "json", "--with-parent"]
        parent = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert parent.stdout is not None
        assert parent.stderr is not None
        child = int(parent.stdout.readline())
        assert any(0 < json.loads(line).get("fraction", 0) < 0.9 for line in parent.stderr)
        parent.kill()
        until = time.monotonic() + 10
        while alive(child) and time.monotonic() < until:
            time.sleep(0.05)
        assert not alive(child)
        assert sorted(os.listdir(here)) == before
        parent.communicate()

    def test_a_run_that_does_not_listen_ends_too(self) -> None:
        deaf = "import signal, time; from intarsia.cli import callers; signal.signal(15, lambda *_: None)\n"
        deaf += "callers.end_with_parent(lambda: None, []); print(1, flush=True)\n"
        deaf += "while True: time.sleep(9)"
        work = subprocess.Popen([sys.executable, "-c", deaf], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert work.stdout is not None
        assert work.stdout.readline() == b"1\n"
        work.communicate(timeout=10)
        assert work.returncode == 130

    def test_nothing_else_can_come_from_there(self) -> None:
        said = run("grow", "-", "-o", "out.png", "--with-parent", code=2, data=b"").stderr
        assert "--with-parent reads the standard input" in said


def alive(pid: int) -> bool:
    """Whether a process runs; one that has ended, and for which nobody has waited, does not."""
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False


class TestWhere:
    def test_what_other_programs_ask_first(self) -> None:
        found = json.loads(run("where --json").stdout)
        assert set(found) == {"version", "contract", "command", "python", "cache", "warm"}
        assert (found["version"], found["contract"]) == (ia.__version__, CONTRACT)
        again = subprocess.run([*found["command"], "where", "--json"], capture_output=True, check=True, cwd="/")
        assert json.loads(again.stdout)["version"] == ia.__version__
        assert all(word in run("where").stdout for word in ("contract  1", *found["command"]))

    def test_the_cache_is_warm_once_all_was_compiled(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        monkeypatch.setattr(kernels, "cache_folder", lambda: str(tmp_path))
        assert not kernels.is_warm()
        kernels.mark_warm()
        assert kernels.is_warm()
        monkeypatch.setattr(kernels, "cache_folder", lambda: None)
        kernels.mark_warm()
        assert not kernels.is_warm()
