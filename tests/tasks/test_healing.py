"""Healing: known pixels stay, nothing comes from the hole, and what was lost is recovered without a visible edge."""

from __future__ import annotations

import importlib
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tasks.lines import check_refused, run

import intarsia as ia
from intarsia import files
from intarsia.foundation.geometry import Wrap
from intarsia.model.image import Transfer
from intarsia.seams import energy
from intarsia.synthesis import filled
from intarsia.tasks.completion import dilated_hole, least_energy, methods_to_try, patch_for, scene_to_heal, thickness
from intarsia.testing.cases import as_depth, looked_up, noise, texture

completion = importlib.import_module("intarsia.tasks.completion")  # itself, which is patched, not its stand-in
QUILTING = ia.ImageQuilting(patch=14, overlap=5, tolerance=0)
METHODS = {"quilting": QUILTING, "sampling": ia.PatchSampling(patch=6, overlap=4), "automatic": "image-quilting"}
Mask = NDArray[np.bool_]


def hole_of(kind: str, height: int = 48, width: int = 52) -> Mask:
    y, x = np.mgrid[:height, :width]
    holes = {
        "pixel": (y == 20) & (x == 31),
        "disc": (y - 20) ** 2 + (x - 25) ** 2 < 90,
        "blob": (y - 48) ** 2 + (x - 40) ** 2 < 30**2,
        "scratch": abs(y - x // 2 - 9) < 2,
        "right edge": x > width - 9,
        "corners": (np.minimum(y, height - 1 - y) < 6) & (np.minimum(x, width - 1 - x) < 5),
        "blocks": (noise(height // 8 + 1, width // 8 + 1, 5) % np.uint64(9) == 0)[y // 8, x // 8],
        "ring": abs((y - 22) ** 2 + (x - 25) ** 2 - 160) < 50,
        "scattered": noise(height, width, 3) % np.uint64(29) == 0,
    }
    return np.asarray(holes[kind], bool)


KINDS = ["pixel", "disc", "scratch", "right edge", "corners", "blocks", "ring", "scattered"]
FITTING = [(k, n) for n in METHODS for k in KINDS if k != "scattered" or n == "automatic"]
"""Kinds of holes and methods; between scattered holes only the automatic patch is small enough to find any."""


@pytest.mark.parametrize(("kind", "name"), FITTING)
def test_known_pixels_stay_and_nothing_comes_from_the_hole(kind: str, name: str) -> None:
    """Law 7 with a rim of 0; law 1; law 4."""
    e, hole = ia.Exemplar.of(texture(48, 52, 3, 4)), hole_of(kind)
    out = ia.heal(e, hole, METHODS[name], seed=3, run=ia.Run(1))
    made = out.render().pixels
    assert (made[~hole] == e.base.pixels[~hole]).all()
    assert not out.map.holes.any()
    shown = out.map.yx[hole]
    assert not hole[shown[:, 0], shown[:, 1]].any()
    assert made.tobytes() == looked_up(out.exemplars, out.map).tobytes()
    again = ia.heal(e, hole, METHODS[name], seed=3, run=ia.Run(3))
    assert again.map.digest == out.map.digest


@pytest.mark.parametrize("grow", [0, 2])
def test_nan_in_the_hole_needs_no_further_mask(grow: int) -> None:
    """What is replaced anyway may be NaN: in an array, in a file, and on the command line, where it also replays."""
    pixels, hole = as_depth(texture(48, 52, 3, 4), "float32"), hole_of("disc")
    bad = pixels.copy()
    bad[dilated_hole(hole, grow)] = np.nan
    wanted = ia.heal(pixels, hole, QUILTING, grow=grow).render().pixels
    assert ia.heal(bad, hole, QUILTING, grow=grow).render().pixels.tobytes() == wanted.tobytes()
    files.write("bad.exr", ia.Plane(bad, transfer=Transfer.LINEAR))
    read = ia.heal("bad.exr", hole, QUILTING, grow=grow).render().pixels
    assert np.isfinite(read).all()
    run("heal", "bad.exr", "--mask", "h.png", "--grow", grow, "-o", "out.exr", "--patch", QUILTING.patch, "-q")
    run("replay", "out.exr", "-e", "bad.exr", "--mask", "h.png", "-o", "again.exr", "-q")
    assert Path("out.exr").read_bytes() == Path("again.exr").read_bytes()
    assert np.isfinite(files.read_plane("out.exr").pixels).all()
    opacity = np.where(dilated_hole(hole, grow), 0, 1).astype(np.float32)
    files.write("clear.exr", ia.Plane(np.dstack([bad, opacity]), transfer=Transfer.LINEAR))
    run("heal", "clear.exr", "--mask", "alpha", "-o", "clear_out.exr", "-q")
    assert np.isfinite(files.read_plane("clear_out.exr").pixels).all()


def test_nan_outside_the_hole_is_refused_and_the_right_option_named() -> None:
    pixels = as_depth(texture(48, 52, 3, 4), "float32")
    pixels[0, 0] = np.nan
    files.write("bad.exr", ia.Plane(pixels, transfer=Transfer.LINEAR))
    usable = np.full((48, 52), 255, np.uint8)
    usable[0, 0] = 0
    files.write("usable.png", ia.Plane(usable))
    line = ("heal", "bad.exr", "--mask", "h.png", "-o", "out.exr", "-q")
    assert "when healing, --usable" in run(*line, code=3).stderr
    run(*line, "--usable", "usable.png")


@pytest.mark.parametrize("block", [8, 16])
def test_lost_blocks_of_a_regular_texture_are_recovered_exactly(block: int) -> None:
    """Where the lost part occurs elsewhere, it comes back as it was."""
    tile = texture(24, 24, 3, 7)
    pixels, hole = np.tile(tile, (4, 4, 1)), np.zeros((96, 96), bool)
    for y, x in ((8, 16), (40, 64), (72, 8), (64, 72)):
        hole[y : y + block, x : x + block] = True
    out = ia.heal(np.where(hole[:, :, None], 0, pixels).astype(np.uint8), hole)
    assert (out.render().pixels == pixels).all()


def test_other_pictures_give_the_pixels() -> None:
    e, donor = ia.Exemplar.of(texture(48, 52, 3, 4)), ia.Exemplar.of(texture(50, 30, 3, 5))
    hole = hole_of("disc")
    out = ia.heal(e, hole, QUILTING, sources=[donor])
    assert (out.map.numbers == hole).all()
    assert (out.render().pixels[~hole] == e.base.pixels[~hole]).all()


def test_no_pixel_comes_from_a_block_with_a_marked_pixel() -> None:
    """Marked pixels keep whole blocks away, in holes as elsewhere (Multrus 2003, 5.2)."""
    usable = np.ones((60, 60), bool)
    usable[30, 45] = False
    hole = np.zeros((60, 60), bool)
    hole[10:22, 8:20] = True
    out = ia.heal(ia.Exemplar.of(texture(60, 60, 3, 4), usable=usable), hole, QUILTING)
    shown = out.map.yx[hole]
    assert not ((shown == (30, 45)).all(axis=1)).any()
    # 14 px windows without the mark and the hole leave out what lies between them and the border
    bad = np.pad(np.cumsum(np.cumsum(~usable | hole, 0), 1), ((1, 0), (1, 0)))
    free = bad[14:, 14:] - bad[:-14, 14:] - bad[14:, :-14] + bad[:-14, :-14] == 0
    covered = np.zeros((60, 60), bool)
    for y, x in np.argwhere(free):
        covered[y : y + 14, x : x + 14] = True
    assert covered[shown[:, 0], shown[:, 1]].all()


def test_a_hole_across_the_border_of_a_tileable_picture() -> None:
    tile = np.tile(texture(24, 24, 3, 7), (2, 2, 1))
    hole = np.zeros((48, 48), bool)
    hole[20:30, :4] = hole[20:30, 44:] = True
    out = ia.heal(ia.Exemplar.of(tile, toroidal=True), hole, wrap=Wrap.BOTH)
    assert (out.render().pixels == tile).all()


def test_the_patch_suits_the_hole_and_its_surroundings() -> None:
    e = ia.Exemplar.of(texture(200, 200, 1, 1))
    small, large, most = (np.zeros((200, 200), bool) for _ in range(3))
    small[60:68, 60:68] = True
    large[50:150, 50:150] = True
    most[12:, :] = True
    assert patch_for(scene_to_heal(e, small)) <= 24
    assert patch_for(scene_to_heal(e, large)) > patch_for(scene_to_heal(e, small))
    assert patch_for(scene_to_heal(e, most)) <= 12
    scene = scene_to_heal(e, large)
    assert (thickness(scene), thickness(scene_to_heal(e, small))) == (99, 7)
    assert methods_to_try(scene, QUILTING) == [QUILTING]
    assert methods_to_try(scene, ia.ImageQuilting(repeat_penalty=0.2)) == [
        ia.ImageQuilting(repeat_penalty=0.2, patch=patch_for(scene))
    ]
    assert len(methods_to_try(scene_to_heal(e, small), ia.ImageQuilting())) > 1
    assert (np.asarray(ia.heal(e, most))[:12] == e.base.pixels[:12]).all()


def test_of_several_sizes_that_is_kept_whose_seams_are_least_seen() -> None:
    small = np.zeros((80, 90), bool)
    small[30:42, 40:52] = True
    scene, run = scene_to_heal(ia.Exemplar.of(texture(80, 90, 1, 1)), small), ia.Run(1)
    tried = methods_to_try(scene, ia.ImageQuilting())
    costs = [filled(scene, one, 3, ia.Blend(0), run).energy for one in tried]
    assert len(set(costs)) > 2
    assert least_energy(scene, tried, 3, run).energy == min(costs)


@pytest.mark.parametrize(
    "method", [ia.ImageQuilting(patch=20), ia.PatchSampling(patch=(20, 16)), ia.Graphcut(patch=20)]
)
def test_what_is_filled_is_covered_anew_by_the_cut_that_prices_all_seams(
    method: ia.Method, monkeypatch: pytest.MonkeyPatch
) -> None:
    pixels, hole = texture(96, 100, 3, 8), hole_of("blob", 96, 100)
    seen: list[ia.Synthesis] = []
    settled = completion.refined

    def both(made: ia.Synthesis, run: ia.Run) -> ia.Synthesis:
        seen.extend((made, settled(made, run)))
        return seen[1]

    monkeypatch.setattr(completion, "refined", both)
    out = ia.heal(pixels, hole, method, seed=3)
    before, after = (energy(made.exemplars, made.map) for made in seen)
    assert 0 < after < before
    for made in seen:  # what must stay stays, and nothing is taken from the hole
        assert (made.render().pixels[~hole] == pixels[~hole]).all()
        assert not hole[tuple(made.map.yx[hole].T)].any()
    assert out.map is seen[1].map


def test_neither_pixels_laid_one_by_one_nor_single_patches_are_covered(monkeypatch: pytest.MonkeyPatch) -> None:
    pixels, hole = texture(40, 44, 1, 8), np.zeros((40, 44), bool)
    hole[15:20, 15:21] = True
    monkeypatch.setattr(completion, "refined", lambda made, run: pytest.fail("covered"))
    ia.heal(pixels, hole, ia.EfrosLeung(), seed=3)
    ia.heal(pixels, hole, ia.ImageQuilting(), seed=3)  # one patch covers this hole


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    pixels, hole = texture(48, 52, 3, 4), hole_of("disc")
    files.write("a.png", ia.Plane(pixels))
    files.write("b.png", ia.Plane(texture(48, 52, 3, 5)))
    files.write("h.png", ia.Plane(hole.astype(np.uint8) * 255))
    files.write("all.png", ia.Plane(np.full((48, 52), 255, np.uint8)))
    files.write("none.png", ia.Plane(np.zeros((48, 52), np.uint8)))
    files.write("small.png", ia.Plane(np.zeros((48, 51), np.uint8)))
    files.write("clear.png", ia.Plane(np.dstack([pixels, np.where(hole, 0, 255).astype(np.uint8)])))


def test_the_command_makes_what_the_library_makes() -> None:
    run("heal", "a.png", "--mask", "h.png", "-o", "out.png", "--seed", 5, "-q")
    made = ia.heal("a.png", hole_of("disc"), seed=5)
    assert files.read_plane("out.png").pixels.tobytes() == made.render().pixels.tobytes()
    run("heal", "a.png", "--mask", "h.png", "-o", "p.png", "--patch", 14, "--grow", 3, "-q")
    method = ia.ImageQuilting(patch=14, tolerance=0)
    made = ia.heal("a.png", hole_of("disc"), method, grow=3)
    assert files.read_plane("p.png").pixels.tobytes() == made.render().pixels.tobytes()


def test_transparent_pixels_are_a_hole() -> None:
    run("heal", "clear.png", "--mask", "alpha", "-o", "out.png", "--alpha", "mask", "-q")
    made = ia.heal("a.png", hole_of("disc"))
    assert files.read_plane("out.png").pixels.tobytes() == made.render().pixels.tobytes()
    run("heal", "clear.png", "--mask", "alpha", "-o", "auto.png", "-q")
    assert Path("auto.png").exists()


def test_marked_pixels_and_other_sources() -> None:
    line = "heal", "a.png", "--mask", "h.png", "-o"
    told = json.loads(run(*line, "o.png", "--from", "b.png", "--save-map", "m.npz", "--json").stdout)
    assert told["parameters"]["tolerance"] == 0
    which = ia.SourceMap.load("m.npz").which
    assert which is not None
    assert (which == hole_of("disc")).all()
    pixels = files.read_plane("a.png").pixels
    colour = "#" + bytes(pixels[40, 40]).hex()
    run(*line, "v.png", "--avoid", colour, "--save-map", "v.npz", "-q")
    shown = ia.SourceMap.load("v.npz").yx[hole_of("disc")]
    assert not (pixels[shown[:, 0], shown[:, 1]] == pixels[40, 40]).all(axis=1).any()
    run(*line, "d.png", "--dry-run", "-q")
    assert not Path("d.png").exists()


def test_the_edge_is_filled_pixel_by_pixel() -> None:
    run("heal", "a.png", "--mask", "h.png", "-o", "e.png", "--edge", 2, "-q")
    hole = hole_of("disc")
    assert (files.read_plane("e.png").pixels[~hole] == files.read_plane("a.png").pixels[~hole]).all()


def test_many_pictures_share_a_hole() -> None:
    run("heal", "a.png", "b.png", "--mask", "h.png", "-o", "{stem}_ok.png", "--patch", 14, "-q")
    assert Path("a_ok.png").exists()
    assert Path("b_ok.png").exists()


BAD = {
    "a.png -o out.png": (2, "Missing option '--mask'"),
    "a.png -o out.png --mask all.png": (3, "the hole all.png covers all of a ("),
    "a.png -o out.png --mask none.png": (3, "the hole none.png marks nothing of a ("),
    "a.png -o out.png --mask small.png": (3, "make them equal"),
    "a.png -o out.png --mask h.png --mask h.png": (2, "--mask: 2 given for 1 picture"),
    "a.png -o out.png --mask alpha": (3, "has no alpha"),
    "a.png -o out.png --mask h.png --grow 100": (3, "the hole covers all of a"),
    "a.png -o out.png --mask h.png --patch 60": (2, "patch=60 is larger than the exemplar"),
    "a.png -o out.png --mask h.png --patch 40": (1, "no 40x40 px patch of the exemplar is free of masked pixels"),
    "a.png -o out.png --mask h.png --usable none.png": (3, "the mask leaves no pixel of "),
    "a.png -o out.png --mask h.png --method repeat": (2, "Invalid value for '--method'"),
    "a.png b.png -o out.png --mask h.png": (2, "2 pictures are given for one output"),
}


@pytest.mark.parametrize("line", BAD)
def test_what_is_wrong_is_said_in_one_line(line: str) -> None:
    check_refused("heal", line, *BAD[line])
