"""Whatever is wrong is said in one line, with the right exit code, before anything is written."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

import intarsia as ia
from intarsia import files, foundation
from intarsia.cli import Interrupted, batch, cli
from intarsia.model.image import Transfer


def run(*args: object, data: bytes | None = None) -> Result:
    return CliRunner().invoke(cli, [str(a) for a in args], input=data)


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of good and bad files."""
    folder = tmp_path_factory.mktemp("corpus")
    here = os.getcwd()
    os.chdir(folder)
    colour = np.random.default_rng(1).integers(0, 255, (40, 48, 3), np.uint8)
    for name, pixels in {
        "a": colour, "deep": colour.astype(np.uint16) * 257, "tiny": colour[:1, :1], "normal": colour[:20],
        "clear": np.dstack([colour, colour[:, :, :1]]), "wide": colour[:, :31],
        "mask": np.full((40, 48), 255, np.uint8), "black": np.zeros((40, 48), np.uint8),
        "other_mask": np.full((40, 47), 255, np.uint8), "pink": np.full((9, 9, 3), [255, 0, 255], np.uint8),
        "moss_albedo": colour, "moss_normal": colour,
    }.items():  # fmt: skip
        files.write(f"{name}.png", ia.Plane(np.ascontiguousarray(pixels)))
    light = colour.astype(np.float32)
    light[3, 4] = np.nan
    files.write("nan.exr", ia.Plane(light, transfer=Transfer.LINEAR))
    made = ia.synthesize("a.png", (30, 40), ia.ImageQuilting(patch=12))
    made.map.save("m.npz")
    files.write("grown.png", made.render(), recipe=made.recipe_text)
    for name, change in {
        "unknown": {"method": "magic"}, "start": {"start": "00"}, "damaged": {"size": "large"},
        "patch": {"parameters": {"patch": 0}}, "inputs": {"inputs": {"crop": [1, 2]}},
        "several": {"exemplars": made.recipe["exemplars"] * 2}, "none": {"exemplars": []},
    }.items():  # fmt: skip
        Path(f"{name}.json").write_text(json.dumps(made.recipe | change))
    Path("list.json").write_text("[]")
    Path("m_cut.npz").write_bytes(Path("m.npz").read_bytes()[:300])
    Path("cut.png").write_bytes(Path("a.png").read_bytes()[:200])
    Path("empty.png").write_bytes(b"")
    Path("text.png").write_text("no picture")
    Path("old.bmp.recipe.json").write_text("{}")
    Path("folder").mkdir()
    Path("alone").mkdir()
    Path("alone/grown.png").write_bytes(Path("grown.png").read_bytes())
    os.chdir(here)
    return folder


@pytest.fixture(autouse=True)
def _in_the_corpus(corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(corpus)


GROW = "grow a.png -o out.png "
OPTIONS = {  # of GROW
    2: """
    --frobnicate 3 | --patch 0 | --patch 0x5 | --patch many | --patch 1x2x3 | --overlap -1 | --tolerance nan
    --method image-quilting --patch 8 --overlap 8 | --tolerance -1 | --channel-weights 0,0,0 | --channel-weights a
    --isometries 9 | --isometries most | --repeat-penalty -1 | --search slowly | --seam none
    --size 0x0 | --size 1e9 | --size 1000000000 | --size 99999999999999999999 | --size 10x | --size -5
    --seed -1 | --seed abc | --seed 18446744073709551616 | --seed 1 --seeds 1..2 | --seeds 1..2 | --seeds 9..1
    --seeds 1..999999 | --seeds x | --wrap diagonal | --feather -1 | --feather 9999 | --mixing well | --threads 0
    --method magic | --method repeat --patch 9 | --method random-tiling --overlap 3 | --avoid pink | --alpha sometimes
    --crop 1,2,3 | --crop 0,0,0,5 | --toroidal --crop 0,0,9,9 | --scale 2 | --scale 0.3 | --scale 0 | --map normal
    --map =n.png | --map a/b=a.png | --depth 12 | --progress loud | --set --several | --sheet sheet.jpg | --patch 700
    --crop 40,0,20,20 | --crop -1,0,20,20 | --scale 1/64 | --method repeat --wrap both | --save-map m.txt
    --method repeat --mask mask.png --mask mask.png | --map normal=a.png --map normal=a.png | --map albedo=a.png
    --save-map out.png | --sheet a.png | --sheet out.png
    """,
    3: """
    --mask missing.png | --mask other_mask.png | --mask black.png | --map normal=missing.png | --map normal=normal.png
    --alpha mask
    """,
}
COMMANDS = {
    1: "grow a.png -o far.png -q --method near-regular",
    2: """
    frobnicate | --frobnicate | grow | render | replay | methods magic | warm-up now
    grow a.png -o - --json | grow - -o out.png --mask -
    grow wide.png -o out.png --toroidal --scale 1/2 | grow a.png -o a.png | grow a.png -o folder | grow a.png -o out
    grow a.png -o out.gif | grow a.png -o out.bmp --depth 16 | grow a.png -o old.bmp
    grow a.png -o {stem}_{colour}.png | grow a.png a.png --several -o {stem}_big.png
    grow a.png -o - --map normal=a.png | grow deep.png -o out.jpg | grow clear.png -o out.jpg
    grow a.png -o out.webp --size 20000x4 | grow moss_albedo.png moss_normal.png --map normal=a.png -o out.png
    grow tiny.png -o out.png --patch 2 | render m.npz -o out.png | render - -e a.png -o out.png
    render m.npz -e a.png -o out.png --window 30,0,20,20 | render m.npz -e a.png -o out.png --window 0,0,0,0
    render m.npz -e a.png -o a.png | render m.npz -e deep.png -o out.jpg
    render m.npz -e a.png -o out.png --feather 2000 | replay alone/grown.png -o out.png
    replay grown.png -e a.png -o grown.png | replay start.json -e a.png -o out.png
    """,
    3: """
    grow nan.exr -o out.exr --avoid #000000 | grow a.png moss_albedo.png --set -o out.png
    grow a.png -o missing/out.png | grow missing.png -o out.png | grow cut.png -o out.png | grow empty.png -o out.png
    grow text.png -o out.png | grow sample:marble -o out.png | grow folder -o out.png | grow nan.exr -o out.exr
    grow pink.png -o out.png --avoid #ff00ff | grow a.png wide.png deep.png -o out.png --patch 8
    render missing.npz -e a.png -o out.png | render m_cut.npz -e a.png -o out.png | render text.png -e a.png -o out.png
    render m.npz -e wide.png -o out.png | render m.npz -e a.png -e deep.png -o out.png
    replay missing.png -o out.png | replay a.png -o out.png | replay grown.png -e deep.png -o out.png
    replay grown.png -e a.png -e deep.png -o out.png | replay unknown.json -e a.png -o out.png
    replay damaged.json -e a.png -o out.png | replay patch.json -e a.png -o out.png
    replay inputs.json -e a.png -o out.png | replay several.json -e a.png -o out.png
    replay none.json -e a.png -o out.png | replay list.json -e a.png -o out.png
    """,
}
BAD = {
    first + words.strip(): code
    for first, table in ((GROW, OPTIONS), ("", COMMANDS))
    for code, lines in table.items()
    for words in lines.strip().replace("\n", "|").split("|")
}
"""Command line -> its exit code."""


# numpy does not close a damaged .npz itself, which pytest takes for an error of this test.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("line", list(BAD))
def test_bad_input_is_refused_in_one_line(line: str, corpus: Path) -> None:
    before = {p: p.stat().st_mtime_ns for p in corpus.rglob("*")}
    result = run(*line.split())
    # How several files are read is told before they are.
    told = [text for text in result.stderr.splitlines() if not text.startswith("exemplar ")]
    assert result.exit_code == BAD[line], told
    assert len(told) == 1
    assert told[0].startswith("intarsia: ")
    assert "internal error" not in told[0]
    assert "Traceback" not in result.output
    assert result.stdout == ""
    assert {p: p.stat().st_mtime_ns for p in corpus.rglob("*")} == before


def test_a_replay_names_both_exemplars() -> None:
    told = run("replay", "grown.png", "-e", "deep.png", "-o", "out.png").stderr
    wanted, found = (files.read(name).digest[:12] for name in ("a.png", "deep.png"))
    assert wanted in told
    assert found in told


def test_a_file_that_appears_meanwhile_is_not_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = batch.made_of

    def slow(*args: Any, **more: Any) -> Any:
        Path("late_ao.png").write_bytes(b"somebody else's")
        return kept(*args, **more)

    monkeypatch.setattr(batch, "made_of", slow)
    result = run("grow", "a.png", "-q", "--map", "ao=mask.png", "-o", "late.png")
    assert result.exit_code == 2
    assert Path("late_ao.png").read_bytes() == b"somebody else's"
    assert not Path("late.png").exists()
    Path("late_ao.png").unlink()


def _raises(error: BaseException) -> Callable[..., Any]:
    def function(*args: Any, **more: Any) -> Any:
        raise error

    return function


@pytest.mark.parametrize(
    ("error", "code", "start"),
    [
        (MemoryError("Unable to allocate"), 1, "intarsia: out of memory;"),
        (KeyError("x"), 1, "intarsia: internal error, KeyError: 'x'; please report it"),
        (ValueError("two\nlines"), 1, "intarsia: internal error, ValueError: two lines;"),
        (PermissionError(13, "Permission denied", "out.png"), 1, "intarsia: out.png: permission denied;"),
        (KeyboardInterrupt(), 130, "intarsia: stopped;"),
        (Interrupted(), 130, "intarsia: stopped;"),
        (foundation.CancelledError("cancelled; nothing was written."), 130, "intarsia: cancelled;"),
        (foundation.QualityError("too bad"), 4, "intarsia: too bad"),
        (foundation.MissingExtraError("zarr is missing"), 5, "intarsia: zarr is missing"),
        (BrokenPipeError(), 1, ""),
    ],
)
def test_every_error_has_its_code(
    error: BaseException, code: int, start: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batch, "made_of", _raises(error))
    result = run("grow", "a.png", "-o", "out.png")
    assert result.exit_code == code
    assert result.stderr.startswith(start)
    assert len(result.stderr.splitlines()) == bool(start)


def test_a_traceback_only_on_request(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "made_of", _raises(KeyError("x")))
    assert "Traceback" in run("--debug", "grow", "a.png", "-o", "out.png").stderr
    assert "Traceback" in run("grow", "a.png", "-o", "out.png", "--debug").stderr
    monkeypatch.setenv("INTARSIA_DEBUG", "1")
    assert "Traceback" in run("grow", "a.png", "-o", "out.png").stderr
