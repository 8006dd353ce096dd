"""``intarsia paint``: colours are labels, the output is the library's, and what cannot work is refused in one line."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli import commands
from click.testing import Result
from numpy.typing import NDArray
from search.test_guide import disc, painted, regions

import intarsia as ia
from intarsia import files

RED, BLUE, GREEN = (255, 0, 0), (0, 0, 255), (0, 128, 0)
COMMON = ("-o", "out.png", "--patch", "14", "--overlap", "4")


def run(*args: object, code: int = 0) -> Result:
    return commands.run("paint", *args, code=code)


def refused(*args: object, code: int = 3) -> str:
    told = run(*args, *COMMON, code=code).stderr
    assert told.count("\n") == 1
    assert not Path("out.png").exists()
    return told


def coloured(marks: NDArray[Any], *colours: tuple[int, int, int]) -> ia.Plane:
    return ia.Plane(np.array(colours, np.uint8)[marks])


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    marks = regions(70, 60)
    files.write("e.png", painted(marks).base)
    files.write("l.png", coloured(marks, RED, BLUE))
    files.write("t.png", coloured(disc(64), RED, BLUE))


def test_paint_is_what_the_library_makes() -> None:
    told = json.loads(run("e.png", "-l", "l.png", "-t", "t.png", *COMMON, "--seed", 4, "--json").stdout)
    assert told["size"] == [64, 64]
    marks = regions(70, 60)
    # Labels are numbered by colour: blue comes before red.
    guide = ia.Guide(*(ia.Plane(1 - m, ia.Kind.LABEL) for m in (marks, disc(64))))
    out = ia.synthesize(ia.read("e.png"), None, ia.Graphcut(patch=14, overlap=4), seed=4, guide=guide)
    assert np.array_equal(files.read_plane("out.png").pixels, out.render().pixels)
    recipe = files.read_recipe("out.png")
    assert recipe is not None
    told = recipe["guide"]
    assert {k: told[k] for k in ("weight", "reach")} == {"weight": 2.0, "reach": 0}
    assert len(told["labels"]) == 1


def test_colour_gray_and_depth_do_not_matter() -> None:
    run("e.png", "-l", "l.png", "-t", "t.png", *COMMON)
    first = Path("out.png").read_bytes()
    wide = files.read_plane("t.png").pixels.astype(np.uint16) * 257
    files.write("wide.png", ia.Plane(wide))
    run("e.png", "-l", "l.png", "-t", "wide.png", *COMMON, "--force")
    assert Path("out.png").read_bytes() == first
    files.write("lg.png", ia.Plane((1 - regions(70, 60)) * np.uint8(200)))
    files.write("tg.png", ia.Plane((1 - disc(64)) * np.uint8(200)))
    before = files.read_plane("out.png").pixels
    run("e.png", "-l", "lg.png", "-t", "tg.png", *COMMON, "--force")  # 0 was blue, and comes first again
    assert np.array_equal(files.read_plane("out.png").pixels, before)


def test_several_exemplars_and_a_batch() -> None:
    files.write("moss.png", painted(np.full((50, 50), 2)).base)
    files.write("moss_l.png", coloured(np.zeros((50, 50), int), GREEN))
    target = np.repeat(disc(64), 2, axis=1) + (np.arange(128) > 90)
    files.write("t3.png", coloured(target, RED, BLUE, GREEN))
    words = "paint e.png moss.png -l l.png -l moss_l.png -t t3.png --patch 14 --seeds 1..2 -o o{seed}.png"
    told = commands.told(words)
    assert [r["size"] for r in told["results"]] == [[128, 64]] * 2
    assert Path("o1.png").read_bytes() != Path("o2.png").read_bytes()


@pytest.mark.parametrize("method", ["image-quilting", "patch-sampling"])
def test_crop_and_scale_hold_for_labels_too(method: str) -> None:
    run("e.png", "-l", "l.png", "-t", "t.png", "-o", "o.png", "--crop", "4,2,52,64", "--patch", 8, "--method", method)
    run("e.png", "-l", "l.png", "-t", "t.png", "-o", "o2.png", "--scale", "1/2", "--patch", 8, "--method", method)
    assert files.read_plane("o2.png").height == 64


def test_a_few_stray_pixels_get_the_nearest_label_and_smoothed_edges_are_refused() -> None:
    run("e.png", "-l", "l.png", "-t", "t.png", *COMMON)
    clean = files.read_plane("out.png").pixels
    stray = files.read_plane("t.png").pixels.copy()
    for k, (y, x) in enumerate([(2, 2), (60, 5), (30, 31)]):
        stray[y, x] = stray[y, x] // 2 + k
    files.write("stray.png", ia.Plane(stray))
    told = run("e.png", "-l", "l.png", "-t", "stray.png", *COMMON, "--force").stderr
    assert "stray.png: 3 px of 3 odd colours" in told
    assert np.array_equal(files.read_plane("out.png").pixels, clean)
    ys, xs = np.random.default_rng(0).integers(0, 64, (2, 200))
    stray[ys, xs] = np.random.default_rng(1).integers(0, 255, (200, 3))
    files.write("smooth.png", ia.Plane(stray))
    os.unlink("out.png")
    assert "smoothed edges" in refused("e.png", "-l", "l.png", "-t", "smooth.png")


def test_what_does_not_fit_is_refused() -> None:
    files.write("small.png", coloured(regions(70, 59), RED, BLUE))
    assert "small.png are 59x70 px, e.png is 60x70" in refused("e.png", "-l", "small.png", "-t", "t.png")
    files.write("green.png", coloured(disc(64), RED, GREEN))
    told = refused("e.png", "-l", "l.png", "-t", "green.png")
    assert "the target asks for #008000, which is in no label picture; paint with #0000ff, #ff0000" in told
    assert "--labels: 2 given for 1 exemplar;" in refused("e.png", "-l", "l.png", "-l", "l.png", "-t", "t.png", code=2)
    assert "missing.png" in refused("e.png", "-l", "missing.png", "-t", "t.png")
    thin = np.zeros((70, 60), int)
    thin[30:36] = 1
    files.write("thin.png", coloured(thin, RED, BLUE))
    told = refused("e.png", "-l", "thin.png", "-t", "t.png")
    assert "#0000ff" in told
    assert "at most 6 px" in told
    files.write("clear.png", ia.Plane(np.dstack([np.zeros((64, 64, 3), np.uint8), disc(64) * np.uint8(200)])))
    assert "transparent" in refused("e.png", "-l", "l.png", "-t", "clear.png")


def test_usage() -> None:
    run("e.png", "-l", "l.png", "-o", "out.png", code=2)
    run("e.png", "-l", "l.png", "-t", "t.png", "-o", "out.png", "--weight", "-1", code=2)
    run("e.png", "-l", "l.png", "-t", "t.png", "-o", "out.png", "--method", "repeat", code=2)
    assert "40 px" not in run("e.png", "-l", "l.png", "-t", "t.png", *COMMON, "--dry-run").stderr
    assert not Path("out.png").exists()
