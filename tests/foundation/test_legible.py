"""What a file holds never reaches the terminal raw, and the last line says what really is there."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import corpus
import pytest
from cli.commands import run

import intarsia as ia
from intarsia import files

HARM = "\x1b]0;own\x07\x1b[31mred\u202e\u200b\x9b1m\x7f\ud800" + "a" + "\u0301" * 200 + "\r\nintarsia: all is well"
"""Escape sequences, marks that turn a line round or hide, half a character, accents without end, a second line."""


def legible(text: str) -> bool:
    return text.isprintable() and "\u0301" * 9 not in text


@pytest.fixture(scope="module")
def recipe(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("legible")
    files.write(folder / "a.png", corpus.picture(20, 24))
    made = ia.synthesize(str(folder / "a.png"), (30, 40), ia.ImageQuilting(patch=8))
    return folder, made.recipe


@pytest.mark.parametrize("key", ["sha256", "intarsia", "method", "search", "patch", "isometries", "depth", "long"])
def test_texts_of_recipes_are_told_legibly(key: str, recipe: tuple[Path, dict[str, Any]]) -> None:
    folder, told = recipe
    change: dict[str, Any] = {key: HARM}
    if key == "sha256":
        change = {"exemplars": [told["exemplars"][0] | {"sha256": HARM, "name": HARM}]}
    if key == "long":
        change = {"method": HARM * 1000}
    if key in ("search", "patch", "isometries"):
        change = {"parameters": told["parameters"] | {key: HARM}}
    (folder / "r.json").write_text(json.dumps(told | change))
    words = ["replay", folder / "r.json", "-o", folder / "o.png", "-e", folder / "a.png"]
    if key == "intarsia":
        result = run(*words, "--force", "--json")
        assert "\x1b" not in result.stdout
        assert json.loads(result.stdout)["warnings"]
    else:
        result = run(*words, "-q", code=3)
        assert result.stderr.count("\n") == 1
        assert len(result.stderr) < 2100
    assert all(map(legible, result.stderr.splitlines()))


def test_every_error_of_the_library_is_legible() -> None:
    from intarsia import foundation

    for kind in [foundation.IntarsiaError, *foundation.IntarsiaError.__subclasses__()]:
        assert legible(str(kind(f"{HARM} is wrong")))
        assert str(kind("木目 naïve é 😀 e\u0301")) == "木目 naïve é 😀 e\u0301"


def test_names_of_files_are_printed_legibly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On stdout, too: whoever unpacks an archive does not choose the names in it."""
    monkeypatch.chdir(tmp_path)
    name = "\x1b[31mred\u202e\x07.png"
    files.write(name, corpus.picture(24, 24))
    page = run("analyze", name)
    assert all(map(legible, page.stdout.splitlines()))
    told = run("analyze", "-q", name, "--json")
    assert told.stdout.isascii()
    assert set(told.stdout) >= {"{", "\n"}
    assert all(map(str.isprintable, told.stdout.splitlines()))
    assert json.loads(told.stdout)["file"] == name
    made = run("grow", name, "-o", "\x1b[31m\x7f.png", "--size", "30", "-m", "repeat", "--json")
    assert all(map(str.isprintable, (made.stdout + made.stderr).splitlines()))
    assert json.loads(made.stdout)["files"][0]["path"] == "\x1b[31m\x7f.png"
    debug = run("grow", name, "-o", "\x1b[31m.gif", "--debug", code=2)
    assert all(map(str.isprintable, debug.stderr.splitlines()))


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_full_standard_output_does_not_deny_the_picture(tmp_path: Path) -> None:
    files.write(tmp_path / "a.png", corpus.picture(24, 24))
    grow = "grow a.png -o j.png --size 30 -m repeat -q --json"
    for words in (grow, "methods --json"):
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                [sys.executable, "-m", "intarsia", *words.split()],
                stdout=full, stderr=subprocess.PIPE, text=True, cwd=tmp_path, check=False,
            )  # fmt: skip
        lines = done.stderr.splitlines()
        assert (done.returncode, len(lines)) == (1, 1), lines
        assert "no space left" in lines[0]
        assert "not finished" not in lines[0]
        assert "all else is done" in lines[0]
    assert files.read_plane(tmp_path / "j.png").width == 30


SLEEPER = """
import sys, time
from intarsia.__main__ import main
from intarsia.cli.outputs import Staging
def sleep(*args, **more):
    with Staging(False) as staging:
        staging.place("x.png")
        print("ready", flush=True)
        time.sleep(60)
import intarsia.cli.batch
intarsia.cli.batch.Batch.carry_out = sleep
sys.argv = ["intarsia", "grow", "a.png", "-o", "x.png", "--size", "30", "-m", "repeat"]
main()
"""


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="needs SIGHUP")
@pytest.mark.parametrize("ignored", [False, True])
def test_a_closed_terminal_stops_like_a_polite_kill(ignored: bool, tmp_path: Path) -> None:
    """Exit code 130 and nothing half-written; under nohup, it goes on."""
    files.write(tmp_path / "a.png", corpus.picture(24, 24))
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN if ignored else signal.SIG_DFL)
    try:
        child = subprocess.Popen(
            [sys.executable, "-c", SLEEPER], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
    finally:
        signal.signal(signal.SIGHUP, before)
    assert child.stdout is not None
    assert child.stdout.readline() == "ready\n"
    child.send_signal(signal.SIGHUP)
    if ignored:
        time.sleep(0.3)
        assert child.poll() is None
        child.terminate()
    told = child.communicate(timeout=60)[1]
    assert child.returncode == 130
    assert told == "intarsia: stopped; the file in the making was not written.\n"
    assert sorted(os.listdir(tmp_path)) == ["a.png"]
