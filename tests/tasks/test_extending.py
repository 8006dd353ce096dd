"""Extending: the picture stays, in all directions alike, and the command does what the library does."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tasks.lines import check_refused, run

import intarsia as ia
from intarsia import files
from intarsia.foundation.geometry import Wrap
from intarsia.tasks.completion import Margins
from intarsia.testing.cases import looked_up, texture

QUILTING = ia.ImageQuilting(patch=14, overlap=5)
SAMPLING = ia.PatchSampling(patch=6, overlap=4)
METHODS = {"quilting": QUILTING, "sampling": SAMPLING}
SIDES = [
    Margins(left=17), Margins(right=17), Margins(top=17), Margins(bottom=17), Margins(left=1), Margins(bottom=3),
    Margins(left=20, right=9), Margins(top=30, bottom=2), Margins(right=25, bottom=25), Margins(9, 9, 9, 9),
    Margins(left=40, top=1),
]  # fmt: skip


def told(m: Margins) -> str:
    return f"{m.left},{m.right},{m.top},{m.bottom}"


@pytest.mark.parametrize("margins", SIDES, ids=told)
@pytest.mark.parametrize("name", list(METHODS))
def test_the_picture_stays_and_no_hole_remains(name: str, margins: Margins) -> None:
    """Law 7; Multrus 2003, 5.1: deeper than overlap (and feather) the old picture is the same, byte for byte."""
    e, method = ia.Exemplar.of(texture(40, 44, 3, 4)), METHODS[name]
    out = ia.extend(e, margins, method, seed=3, run=ia.Run(1))
    assert not out.map.holes.any()
    assert (out.map.height, out.map.width) == (40 + margins.top + margins.bottom, 44 + margins.left + margins.right)
    assert out.render(feather=0).pixels.tobytes() == looked_up(out.exemplars, out.map).tobytes()
    for feather in (0, out.blend.feather):
        rim = 4 + (name == "quilting") + feather
        y = slice(rim * (margins.top > 0), 40 - rim * (margins.bottom > 0))
        x = slice(rim * (margins.left > 0), 44 - rim * (margins.right > 0))
        old = out.render(feather=feather).samples[margins.top : margins.top + 40, margins.left : margins.left + 44]
        assert (old[y, x] == e.base.samples[y, x]).all()
    again = ia.extend(e, margins, method, seed=3, run=ia.Run(3))
    assert again.map.digest == out.map.digest
    assert again.render().pixels.tobytes() == out.render().pixels.tobytes()


@pytest.mark.parametrize("wrap", list(Wrap))
@pytest.mark.parametrize("name", list(METHODS))
def test_an_extended_picture_can_tile(name: str, wrap: Wrap) -> None:
    """Law 6: the gap is closed from both sides; the wrapped border is no worse than the inside."""
    e = ia.Exemplar.of(texture(40, 44, 1, 4))
    worst, border = np.zeros(2), np.zeros(2)
    for seed in range(4):
        out = ia.extend(e, Margins(right=23, bottom=19), METHODS[name], seed=seed, wrap=wrap)
        assert not out.map.holes.any()
        pixels = out.render(feather=0).samples[:, :, 0].astype(float)
        for axis, wrapped in enumerate((wrap.y, wrap.x)):
            steps = np.abs(np.roll(pixels, -1, axis) - pixels).mean(axis=1 - axis)
            if wrapped:
                border[axis] += steps[-1]
                worst[axis] += np.sort(steps[:-1])[-3]
    assert (border <= 1.3 * worst).all()


def test_other_pictures_give_the_pixels() -> None:
    e, donor = ia.Exemplar.of(texture(40, 44, 3, 4)), ia.Exemplar.of(texture(50, 30, 3, 5))
    out = ia.extend(e, Margins(left=15, bottom=15), QUILTING, sources=[donor])
    which = out.map.numbers
    assert (which[40:] == 1).all()
    assert (which[:, :15] == 1).all()
    assert (which[:35, 20:] == 0).all()
    feathered = ia.extend(e, Margins(right=20), SAMPLING, sources=[donor]).render()
    assert (feathered.samples[:, :36] == e.base.samples[:, :36]).all()


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    files.write("a.png", ia.Plane(texture(40, 48, 3, 1)))
    files.write("b.png", ia.Plane(texture(40, 48, 3, 2)))


def test_the_command_makes_what_the_library_makes_and_replay_repeats_it() -> None:
    wanted = ("--left", 5, "--bottom", 20, "--patch", 12, "--seed", 4, "--wrap", "x")
    run("extend", "a.png", "-o", "out.png", *wanted, "-q")
    made = ia.extend("a.png", Margins(left=5, bottom=20), ia.ImageQuilting(patch=12), seed=4, wrap="x")
    assert files.read_plane("out.png").pixels.tobytes() == made.render().pixels.tobytes()
    run("replay", "out.png", "-e", "a.png", "-o", "again.png", "-q")
    assert Path("again.png").read_bytes() == Path("out.png").read_bytes()


def test_many_pictures_and_other_sources() -> None:
    run("extend", "a.png", "b.png", "-o", "{stem}_wide.png", "--top", 9, "--patch", 12, "-q")
    assert Path("a_wide.png").exists()
    assert Path("b_wide.png").exists()
    run("extend", "a.png", "-o", "c.png", "--top", 9, "--patch", 12, "--from", "b.png", "--save-map", "m.npz", "-q")
    assert (ia.SourceMap.load("m.npz").which[:9] == 1).all()  # type: ignore[index]
    told = json.loads(run("extend", "a.png", "-o", "none.png", "--patch", 12, "--dry-run", "--json").stdout)
    assert told["size"] == [148, 40], "by default 100 px are added to the right"
    assert not Path("none.png").exists()


BAD = {
    "a.png -o out.png --left 0": (2, "no side is extended"),
    "a.png -o out.png --left -3": (2, "Invalid value for '--left'"),
    "a.png b.png -o out.png": (2, "2 pictures are given for one output"),
    "a.png -o out.png --method image-quilting --refinements 9": (2, "refinements: image-quilting has no"),
    "a.png -o out.png --patch 90": (2, "patch=90 is larger than the exemplar"),
    "a.png -o out.png --right 1048577": (2, "Invalid value for '--right'"),
    "a.png -o out.png --right 1048576 --bottom 1048576": (2, "size=1048624x1048616 is not allowed"),
    "a.png -o a.png": (2, "a.png exists"),
}


@pytest.mark.parametrize("line", BAD)
def test_what_is_wrong_is_said_in_one_line(line: str) -> None:
    check_refused("extend", line, *BAD[line])
