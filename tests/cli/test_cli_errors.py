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
from intarsia.cli import Interrupted, cli
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
    files.write("a.png", ia.Plane(colour))
    files.write("deep.png", ia.Plane(colour.astype(np.uint16) * 257))
    files.write("tiny.png", ia.Plane(colour[:1, :1]))
    files.write("clear.png", ia.Plane(np.dstack([colour, colour[:, :, :1]])))
    files.write("normal.png", ia.Plane(colour[:20]))
    files.write("wide.png", ia.Plane(colour[:, :31]))
    files.write("mask.png", ia.Plane(np.full((40, 48), 255, np.uint8)))
    files.write("black.png", ia.Plane(np.zeros((40, 48), np.uint8)))
    files.write("other_mask.png", ia.Plane(np.full((40, 47), 255, np.uint8)))
    light = colour.astype(np.float32)
    light[3, 4] = np.nan
    files.write("nan.exr", ia.Plane(light, transfer=Transfer.LINEAR))
    files.write("pink.png", ia.Plane(np.full((9, 9, 3), [255, 0, 255], np.uint8)))
    made = ia.synthesize("a.png", (30, 40), ia.ImageQuilting(patch=12))
    made.map.save("m.npz")
    files.write("grown.png", made.render(), recipe=made.recipe_text)
    for name, change in (
        ("unknown", {"method": "magic"}),
        ("start", {"start": "00"}),
        ("damaged", {"size": "large"}),
        ("patch", {"parameters": {"patch": 0}}),
        ("inputs", {"inputs": {"crop": [1, 2]}}),
        ("several", {"exemplars": made.recipe["exemplars"] * 2}),
        ("none", {"exemplars": []}),
    ):
        Path(f"{name}.json").write_text(json.dumps(made.recipe | change))
    Path("list.json").write_text("[]")
    Path("m_cut.npz").write_bytes(Path("m.npz").read_bytes()[:300])
    Path("cut.png").write_bytes(Path("a.png").read_bytes()[:200])
    Path("empty.png").write_bytes(b"")
    Path("text.png").write_text("no picture")
    Path("moss_albedo.png").write_bytes(Path("a.png").read_bytes())
    Path("moss_normal.png").write_bytes(Path("a.png").read_bytes())
    Path("old.bmp.recipe.json").write_text("{}")
    Path("folder").mkdir()
    Path("alone").mkdir()
    Path("alone/grown.png").write_bytes(Path("grown.png").read_bytes())
    os.chdir(here)
    return folder


GROW = "grow a.png -o out.png "
BAD = {
    # what the command line itself refuses
    "frobnicate": 2,
    "--frobnicate": 2,
    "grow": 2,
    "render": 2,
    "replay": 2,
    GROW + "--frobnicate 3": 2,
    GROW + "--patch 0": 2,
    GROW + "--patch 0x5": 2,
    GROW + "--patch many": 2,
    GROW + "--patch 1x2x3": 2,
    GROW + "--method image-quilting --patch 8 --overlap 8": 2,
    GROW + "--overlap -1": 2,
    GROW + "--tolerance nan": 2,
    GROW + "--tolerance -1": 2,
    GROW + "--channel-weights 0,0,0": 2,
    GROW + "--channel-weights a": 2,
    GROW + "--isometries 9": 2,
    GROW + "--isometries most": 2,
    GROW + "--repeat-penalty -1": 2,
    GROW + "--min-repeat-distance -1": 2,
    GROW + "--search slowly": 2,
    GROW + "--seam none": 2,
    GROW + "--size 0x0": 2,
    GROW + "--size 1e9": 2,
    GROW + "--size 1000000000": 2,
    GROW + "--size 99999999999999999999": 2,
    GROW + "--size 10x": 2,
    GROW + "--size -5": 2,
    GROW + "--seed -1": 2,
    GROW + "--seed abc": 2,
    GROW + "--seed 18446744073709551616": 2,
    GROW + "--seed 1 --seeds 1..2": 2,
    GROW + "--seeds 1..2": 2,
    GROW + "--seeds 9..1": 2,
    GROW + "--seeds 1..999999": 2,
    GROW + "--seeds x": 2,
    GROW + "--wrap diagonal": 2,
    GROW + "--feather -1": 2,
    GROW + "--feather 9999": 2,
    GROW + "--mixing well": 2,
    GROW + "--threads 0": 2,
    GROW + "--method magic": 2,
    GROW + "--method repeat --patch 9": 2,
    GROW + "--method random-tiling --overlap 3": 2,
    GROW + "--avoid pink": 2,
    GROW + "--alpha sometimes": 2,
    GROW + "--crop 1,2,3": 2,
    GROW + "--crop 0,0,0,5": 2,
    GROW + "--toroidal --crop 0,0,9,9": 2,
    GROW + "--scale 2": 2,
    GROW + "--scale 0.3": 2,
    GROW + "--scale 0": 2,
    GROW + "--map normal": 2,
    GROW + "--map =n.png": 2,
    GROW + "--map a/b=a.png": 2,
    GROW + "--depth 12": 2,
    GROW + "--progress loud": 2,
    GROW + "--set --several": 2,
    GROW + "--sheet sheet.jpg": 2,
    "grow a.png -o - --json": 2,
    "grow - -o out.png --mask -": 2,
    # what the files make impossible
    GROW + "--patch 700": 2,
    GROW + "--crop 40,0,20,20": 2,
    GROW + "--crop -1,0,20,20": 2,
    GROW + "--scale 1/64": 2,
    GROW + "--method repeat --wrap both": 2,
    GROW + "--method repeat --mask mask.png --mask mask.png": 2,
    GROW + "--map normal=a.png --map normal=a.png": 2,
    GROW + "--map albedo=a.png": 2,
    GROW + "--save-map m.txt": 2,
    GROW + "--save-map out.png": 2,
    GROW + "--st-map st.png": 2,
    GROW + "--sheet a.png": 2,
    GROW + "--sheet out.png": 2,
    "grow a.png deep.png -o out.png --st-map st.exr": 2,
    "grow nan.exr -o out.exr --avoid #000000": 3,
    "grow wide.png -o out.png --toroidal --scale 1/2": 2,
    "grow a.png -o a.png": 2,
    "grow a.png -o folder": 2,
    "grow a.png -o out": 2,
    "grow a.png -o out.gif": 2,
    "grow a.png -o out.bmp --depth 16": 2,
    "grow a.png -o old.bmp": 2,
    "grow a.png -o {stem}_{colour}.png": 2,
    "grow a.png a.png --several -o {stem}_big.png": 2,
    "grow a.png -o - --map normal=a.png": 2,
    "grow deep.png -o out.jpg": 2,
    "grow clear.png -o out.jpg": 2,
    "grow a.png -o out.webp --size 20000x4": 2,
    "grow moss_albedo.png moss_normal.png --map normal=a.png -o out.png": 2,
    "grow a.png moss_albedo.png --set -o out.png": 3,
    "grow a.png -o missing/out.png": 3,
    # files that are missing, broken, or do not fit
    "grow missing.png -o out.png": 3,
    "grow cut.png -o out.png": 3,
    "grow empty.png -o out.png": 3,
    "grow text.png -o out.png": 3,
    "grow sample:marble -o out.png": 3,
    "grow folder -o out.png": 3,
    "grow nan.exr -o out.exr": 3,
    "grow tiny.png -o out.png --patch 2": 2,
    "grow pink.png -o out.png --avoid #ff00ff": 3,
    "grow a.png wide.png deep.png -o out.png --patch 8": 3,
    GROW + "--mask missing.png": 3,
    GROW + "--mask other_mask.png": 3,
    GROW + "--mask black.png": 3,
    GROW + "--map normal=missing.png": 3,
    GROW + "--map normal=normal.png": 3,
    GROW + "--alpha mask": 3,
    # render
    "render missing.npz -e a.png -o out.png": 3,
    "render m_cut.npz -e a.png -o out.png": 3,
    "render text.png -e a.png -o out.png": 3,
    "render m.npz -o out.png": 2,
    "render - -e a.png -o out.png": 2,
    "render m.npz -e wide.png -o out.png": 3,
    "render m.npz -e a.png -e deep.png -o out.png": 3,
    "render m.npz -e a.png -o out.png --window 30,0,20,20": 2,
    "render m.npz -e a.png -o out.png --window 0,0,0,0": 2,
    "render m.npz -e a.png -o a.png": 2,
    "render m.npz -e deep.png -o out.jpg": 2,
    "render m.npz -e a.png -o out.png --feather 2000": 2,
    # replay
    "replay missing.png -o out.png": 3,
    "replay a.png -o out.png": 3,
    "replay alone/grown.png -o out.png": 2,
    "replay grown.png -e deep.png -o out.png": 3,
    "replay grown.png -e a.png -e deep.png -o out.png": 3,
    "replay grown.png -e a.png -o grown.png": 2,
    "replay unknown.json -e a.png -o out.png": 3,
    "replay start.json -e a.png -o out.png": 2,
    "replay damaged.json -e a.png -o out.png": 3,
    "replay patch.json -e a.png -o out.png": 3,
    "replay inputs.json -e a.png -o out.png": 3,
    "replay several.json -e a.png -o out.png": 3,
    "replay none.json -e a.png -o out.png": 3,
    "replay list.json -e a.png -o out.png": 3,
    "methods magic": 2,
    "warm-up now": 2,
}


# numpy does not close a damaged .npz itself, which pytest takes for an error of this test.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("line", list(BAD))
def test_bad_input_is_refused_in_one_line(line: str, corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(corpus)
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


def test_an_impossible_distance_fails_without_a_file(corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(corpus)
    before = sorted(os.listdir())
    result = run("grow", "a.png", "-o", "far.png", "-q", "--patch", 12, "--size", 400, "--min-repeat-distance", 1000)
    Path("far.png").unlink(missing_ok=True)  # should this ever succeed
    assert result.exit_code == 1
    assert result.stderr.startswith("intarsia: min_repeat_distance=1000 px")
    assert len(result.stderr.splitlines()) == 1
    assert sorted(os.listdir()) == before


def test_a_replay_names_both_exemplars(corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(corpus)
    told = run("replay", "grown.png", "-e", "deep.png", "-o", "out.png").stderr
    wanted, found = (files.read(name).digest[:12] for name in ("a.png", "deep.png"))
    assert wanted in told
    assert found in told


def test_nothing_of_a_set_is_left_when_one_file_fails(corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(corpus)
    before = sorted(os.listdir())
    kept = files.write
    calls: list[Any] = []

    def failing(*args: Any, **more: Any) -> None:
        calls.append(args)
        if len(calls) == 2:
            raise foundation.ResourceError("there is no room for out_ao.png; free some space.")
        kept(*args, **more)

    monkeypatch.setattr("intarsia.cli.batch.write", failing)
    result = run("grow", "a.png", "-q", "--map", "ao=mask.png", "-o", "out.png")
    assert result.exit_code == 1
    assert result.stderr == "intarsia: there is no room for out_ao.png; free some space.\n"
    assert sorted(os.listdir()) == before


def test_a_file_that_appears_meanwhile_is_not_replaced(corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(corpus)
    from intarsia.cli import batch

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
    error: BaseException, code: int, start: str, corpus: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(corpus)
    from intarsia.cli import batch

    monkeypatch.setattr(batch, "made_of", _raises(error))
    result = run("grow", "a.png", "-o", "out.png")
    assert result.exit_code == code
    assert result.stderr.startswith(start)
    assert len(result.stderr.splitlines()) == bool(start)


def test_a_traceback_only_on_request(corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(corpus)
    from intarsia.cli import batch

    monkeypatch.setattr(batch, "made_of", _raises(KeyError("x")))
    assert "Traceback" in run("--debug", "grow", "a.png", "-o", "out.png").stderr
    assert "Traceback" in run("grow", "a.png", "-o", "out.png", "--debug").stderr
    monkeypatch.setenv("INTARSIA_DEBUG", "1")
    assert "Traceback" in run("grow", "a.png", "-o", "out.png").stderr
