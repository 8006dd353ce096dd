"""Golden hashes: the same request gives the same map on every machine, today and after every change.

A change of a hash is a change of what users get: it needs a line in CHANGELOG.md that says so. The table, golden.txt,
is printed by ``python tests/test_golden.py``, for the named recipes or for all of them.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import intarsia as ia
from intarsia.kernels import cache_folder
from intarsia.model import Exemplar
from intarsia.model.sourcemap import HOLE, identity
from intarsia.testing import noise, texture


def bricks(height: int, width: int, seed: int) -> np.ndarray:
    """Half-offset bricks in free colours, whole numbers only: (height, width, 3) uint8."""
    y, x = np.mgrid[:height, :width]
    row = y // 9
    along = x + 9 * (row % 2)
    mortar = (y % 9 < 2) | (along % 18 < 2)
    shade = noise(64, 64, seed)[row % 64, along // 18 % 64] >> np.uint64(58)
    grain = noise(height, width, seed + 1) % np.uint64(12)
    brick = np.stack([150 + shade, 70 + shade // np.uint64(2), 50 + grain], axis=2)
    return np.where(mortar[:, :, None], 200 - grain[:, :, None], brick).astype(np.uint8)


def plain(run: ia.Run) -> ia.Synthesis:
    return ia.synthesize(texture(56, 48, 3, 1), (96, 110), ia.ImageQuilting(patch=18, overlap=6), seed=7, run=run)


def wrapped(run: ia.Run) -> ia.Synthesis:
    method = ia.ImageQuilting(patch=20, overlap=7, seam="gradient", isometries="180", repeat_penalty=0.2)
    return ia.synthesize(bricks(70, 64, 3), (90, 100), method, seed=2**63 + 5, wrap="both", run=run)


def automatic(run: ia.Run) -> ia.Synthesis:
    return ia.synthesize(bricks(80, 96, 5), 150, ia.ImageQuilting(), seed=1, run=run)


def chosen(run: ia.Run) -> ia.Synthesis:
    return ia.synthesize(bricks(80, 96, 5), 150, "auto", seed=1, run=run)


def tried(run: ia.Run) -> ia.Synthesis:
    return ia.synthesize(texture(70, 64, 3, 5), (110, 120), ia.Auto(trials=4), seed=2, wrap="x", run=run)


def exact(run: ia.Run) -> ia.Synthesis:
    one, two = Exemplar.of(texture(40, 36, 4, 2)), Exemplar.of(texture(30, 44, 4, 3), toroidal=True)
    method = ia.ImageQuilting(patch=13, overlap=4, search="exact", isometries="both")
    return ia.synthesize([one, two], (60, 70), method, seed=11, run=run)


def started(run: ia.Run) -> ia.Synthesis:
    usable = np.ones((60, 60), bool)
    usable[20:34, 22:40] = False
    e = Exemplar.of({"albedo": bricks(60, 60, 7), "height": texture(60, 60, 1, 8)[:, :, 0]}, usable=usable)
    start = replace(identity([e.source], 0), which=np.where(usable, 0, HOLE))
    return ia.synthesize(e, None, ia.ImageQuilting(patch=16, overlap=5), seed=3, start=start, run=run)


def tiled(run: ia.Run) -> ia.Synthesis:
    return ia.synthesize(texture(40, 50, 3, 4), (70, 64), ia.RandomTiling(patch=14, isometries="90"), seed=4, run=run)


def outward(run: ia.Run) -> ia.Synthesis:
    usable = np.ones((40, 36), bool)
    usable[7, 9] = False
    one = Exemplar.of(texture(40, 36, 3, 8), usable=usable)
    return ia.synthesize(one, (44, 40), ia.EfrosLeung(window=7, isometries="180"), seed=3, wrap="x", run=run)


def by_rows(run: ia.Run) -> ia.Synthesis:
    return ia.synthesize(bricks(50, 60, 2), (64, 70), ia.WeiLevoy(window=(4, 7), levels=2), seed=5, wrap="y", run=run)


def coherent(run: ia.Run) -> ia.Synthesis:
    one, two = Exemplar.of(texture(40, 36, 3, 9)), Exemplar.of(texture(30, 44, 3, 4), toroidal=True)
    return ia.synthesize([one, two], (70, 80), ia.Ashikhmin(), seed=6, wrap="both", run=run)


def by_segments(run: ia.Run) -> ia.Synthesis:
    return ia.synthesize(bricks(90, 96, 6), (120, 110), ia.SegmentBased(), seed=8, wrap="x", run=run)


def regular(run: ia.Run) -> ia.Synthesis:
    method = ia.NearRegular(lattice=((17.98, 0.03), (9.01, 9.02)), block=30)
    return ia.synthesize(bricks(120, 130, 4), (150, 160), method, seed=9, run=run)


def courses(run: ia.Run) -> ia.Synthesis:
    method = ia.NearRegular(lattice=((0, 9),))
    return ia.synthesize(bricks(100, 120, 9), (108, 130), method, seed=10, wrap="both", run=run)


def healed(run: ia.Run) -> ia.Synthesis:
    hole = np.zeros((90, 80), bool)
    hole[30:55, 20:50] = True
    return ia.heal(bricks(90, 80, 2), hole, seed=12, run=run)


def sewn(run: ia.Run) -> ia.Synthesis:
    usable = np.ones((50, 54), bool)
    usable[20:24, 40:] = False
    one, two = Exemplar.of(bricks(50, 54, 4), usable=usable), Exemplar.of(texture(40, 44, 3, 6), toroidal=True)
    method = ia.Graphcut(patch=18, isometries="180", seam="gradient")
    return ia.synthesize([one, two], (80, 90), method, seed=9, wrap="x", run=run)


def shifted(run: ia.Run) -> ia.Synthesis:
    return ia.synthesize(bricks(60, 64, 8), (90, 84), ia.Graphcut(patch=24), seed=10, run=run)


def corrected(run: ia.Run) -> ia.Synthesis:
    usable = np.ones((90, 70), bool)
    usable[30:36, 50:] = False
    lattice = (17.98, 0.03), (9.01, 9.02)
    method = ia.Correction2008(k=3, neighbourhood="appearance", rule="near", keep_lattice="on", lattice=lattice)
    return ia.synthesize(Exemplar.of(bricks(90, 70, 4), usable=usable), (121, 96), method, seed=13, wrap="x", run=run)


def boards(run: ia.Run) -> ia.Synthesis:
    """Courses without joints."""
    y = np.mgrid[:80, :90][0]
    grain = (noise(80, 90, 4) % np.uint64(20)).astype(int)
    planks = np.where(y % 16 < 3, 10, 100 + 30 * (y // 16 % 3) + grain).astype(np.uint8)
    return ia.synthesize(planks, (90, 120), ia.NearRegular(lattice=((0, 16),)), seed=14, run=run)


def plain_blocks(run: ia.Run) -> ia.Synthesis:
    method = ia.GapFilling(lattice=((17.98, 0.03), (9.01, 9.02)), fit="correlation")
    return ia.synthesize(bricks(100, 110, 3), (96, 90), method, seed=15, run=run)


def turned(run: ia.Run) -> ia.Synthesis:
    method = ia.ParallelControllable(angle=24, zoom=1.25)
    return ia.synthesize(texture(64, 60, 3, 7), (90, 84), method, seed=16, wrap="none", run=run)


def advected(run: ia.Run) -> ia.Synthesis:
    """Two frames of a flow in halves of a px: whole numbers of 1 / 2 are the same everywhere."""
    made = ia.synthesize(texture(44, 40, 3, 2), 64, ia.ParallelControllable(), seed=17, wrap="both", run=run)
    flow = np.stack(np.broadcast_arrays(np.arange(64)[None, :] % 9 / 2, np.arange(64)[:, None] % 7 / 2 - 1), axis=2)
    for frame in (1, 2):
        made = ia.advect(made, flow, frame=frame, run=run)
    return made


def fan(height: int, width: int) -> np.ndarray:
    """Bricks in courses that open to the right, whole numbers only: (height, width) uint8."""
    y, x = np.mgrid[:height, :width]
    down = 16 * 64 + (y - height // 2) * (850 * width + 300 * x) // (1000 * width)
    row = down // 16
    along = x + (noise(256, 1, 5)[row % 256, 0] % np.uint64(400)).astype(int)
    joint = (down % 16 < 3) | (along % 38 < 3)
    shade = (noise(256, 64, 6)[row % 256, along // 38 % 64] % np.uint64(60)).astype(int)
    grain = (noise(height, width, 7) % np.uint64(9)).astype(int)
    return np.where(joint, 30, 130 + shade + grain).astype(np.uint8)


def straightened(run: ia.Run) -> ia.Synthesis:
    made = ia.synthesize(fan(128, 136), (70, 90), ia.NearRegular(), seed=18, run=run)
    assert made.method.straighten == "on"
    return made


def flattened(run: ia.Run) -> ia.Synthesis:
    dark = np.arange(96)[None, :, None]
    lit = (bricks(80, 96, 5).astype(int) * (200 - dark) // 200).astype(np.uint8)
    return ia.synthesize(ia.flattened(Exemplar.of(lit)), (100, 90), "auto", seed=19, run=run)


GOLDEN = {
    name: (smap, picture)
    for line in Path(__file__).with_name("golden.txt").read_text("utf-8").splitlines()
    for name, smap, picture in [line.split()]
}
"""Map, and picture of every recipe, with a feather of 3 px where pieces are neither turned nor scaled."""

RECIPES: dict[str, Callable[[ia.Run], ia.Synthesis]] = {name: globals()[name] for name in GOLDEN}


def hashes(name: str, threads: int = 1) -> tuple[str, str]:
    """Hash the map, and the picture (not where GOLDEN_MAPS_ONLY is set)."""
    out = RECIPES[name](ia.Run(threads))
    if "GOLDEN_MAPS_ONLY" in os.environ:
        return out.map.digest, ""
    pixels = out.render(feather=3 if out.map.exact else 0, run=ia.Run(threads)).pixels
    return out.map.digest, hashlib.sha256(pixels.tobytes()).hexdigest()


@pytest.mark.parametrize("threads", [1, pytest.param(2, marks=pytest.mark.long), 4])
@pytest.mark.parametrize("name", RECIPES)
def test_maps_are_what_they_were(name: str, threads: int) -> None:
    """Law 4: bytes of maps and pictures, for any number of threads."""
    assert hashes(name, threads) == GOLDEN[name]


def elsewhere(names: list[str], **environment: str) -> dict[str, tuple[str, str]]:
    """Compute hashes in another process, under another environment."""
    run = subprocess.run(
        [sys.executable, __file__, *names], capture_output=True, text=True, env={**os.environ, **environment}
    )
    assert run.returncode == 0, run.stderr
    return {name: (smap, picture) for name, smap, picture in (line.split(" ") for line in run.stdout.splitlines())}


def newer_features() -> str:
    """The instruction sets that NumPy would choose by itself on this machine, beyond its baseline."""
    from numpy._core import _multiarray_umath as umath

    return " ".join(f for f in umath.__cpu_dispatch__ if umath.__cpu_features__.get(f))


SOME = ("plain", "regular", "straightened", "healed", "sewn", "corrected", "chosen", "advected")
"""Recipes of patches, blocks, courses, lattices, cuts, corrections, choosing and repeats; the long run takes all."""


def taken(thorough: bool) -> dict[str, tuple[str, str]]:
    """The golden hashes of the recipes that are grown elsewhere."""
    return GOLDEN if thorough else {name: GOLDEN[name] for name in SOME}


@pytest.mark.parametrize("cores", ["Nehalem", pytest.param("Haswell", marks=pytest.mark.long)])
def test_the_linear_algebra_of_another_cpu_changes_no_map(cores: str, thorough: bool) -> None:
    """Law 4: OpenBLAS as if on an older CPU, with one thread."""
    wanted = taken(thorough)
    assert elsewhere(list(wanted), OPENBLAS_CORETYPE=cores, OPENBLAS_NUM_THREADS="1") == wanted


def test_numpy_without_its_fast_paths_changes_no_map(thorough: bool) -> None:
    """Law 4: NumPy with no instruction set beyond its baseline."""
    wanted = taken(thorough)
    assert elsewhere(list(wanted), NPY_DISABLE_CPU_FEATURES=newer_features()) == wanted


def test_kernels_compiled_for_any_cpu_change_no_map(thorough: bool) -> None:
    """Law 4: kernels compiled again, for the plainest CPU of this architecture, once for every change of a kernel.

    Pictures are not drawn: their kernels are twice as many. Of one recipe or, in the long run, of all.
    """
    names = tuple(RECIPES) if thorough else ("regular",)
    kept = Path(cache_folder()).parent / "any-cpu"
    found = elsewhere(list(names), NUMBA_CPU_NAME="generic", INTARSIA_CACHE=str(kept), GOLDEN_MAPS_ONLY="1")
    assert {name: own for name, (own, _) in found.items()} == {name: GOLDEN[name][0] for name in names}


def test_another_order_of_hashing_changes_no_map() -> None:
    """Nothing depends on the order of a set or a dict of another process."""
    assert elsewhere(["started"], PYTHONHASHSEED="12345") == {"started": GOLDEN["started"]}


if __name__ == "__main__":
    for name in sys.argv[1:] or RECIPES:
        print(name, *hashes(name))
