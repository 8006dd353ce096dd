"""Golden hashes: the same request gives the same map on every machine, today and after every change.

A change of a hash is a change of what users get: it needs a line in CHANGELOG.md that says so. The table is
printed by ``python tests/test_golden.py``, for the named recipes or for all of them.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import intarsia as ia
from intarsia.exemplar import Exemplar
from intarsia.sourcemap import HOLE, identity
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
    method = ia.ImageQuilting(patch=20, overlap=7, seam="gradient", isometries="180", usage=0.2)
    return ia.synthesize(bricks(70, 64, 3), (90, 100), method, seed=2**63 + 5, wrap="both", run=run)


def automatic(run: ia.Run) -> ia.Synthesis:
    return ia.synthesize(bricks(80, 96, 5), 150, seed=1, run=run)


def exact(run: ia.Run) -> ia.Synthesis:
    one, two = Exemplar.of(texture(40, 36, 4, 2)), Exemplar.of(texture(30, 44, 4, 3), toroidal=True)
    method = ia.ImageQuilting(patch=13, overlap=4, search="exact", isometries="both", min_repeat_distance=9)
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
    return ia.synthesize([one, two], (70, 80), ia.Ashikhmin(jumps=2), seed=6, wrap="both", run=run)


RECIPES: dict[str, Callable[[ia.Run], ia.Synthesis]] = {
    f.__name__: f for f in (plain, wrapped, automatic, exact, started, tiled, outward, by_rows, coherent)
}

GOLDEN = {
    "plain": (
        "7ae971fcb62119e859669c0177b15c01ec5e33b47bba977a0f9d080db340b77c",
        "259233456f636ef7baea740aada12ba269c5edd3cdbbff3119992ce82359e434",
    ),
    "wrapped": (
        "7bbcf4c05f127f2fd508a8d32aa20ef684027e03767c573ad6a35a1cee300269",
        "314fc0f64233eead979a7a1f1722dfb6c44a811342ab09f988677e9c09d40f70",
    ),
    "automatic": (
        "6d1ddbb42dae2098e01694d425f09d24b347beac4baf01f83f4f2691a800b8bc",
        "fffb8e9e9d6f75e56f450f54369643d1586f9167aaded9c705b5e06a16abe626",
    ),
    "exact": (
        "d5aec42cb84ae8aedcdb9e3e77b868cd944f67374f247620a0ebce6d3aea7e29",
        "d3d3612b67b2bd3d4f27aa7afd25e655ed264ac208e05348273f1dc91799fb83",
    ),
    "started": (
        "2b349b47e1a883a9d05dc5b8949f51321a4f3a4484bbfb6364745fa733fab9a2",
        "86ff4356a456e56a4139eaf69c0debc91c6d8bb05f0aecfa7f74f061f4a54d79",
    ),
    "tiled": (
        "2e940c0baa828dbc6a5d329d0a717a6e0136bd8c94f517054656f71c9ca05203",
        "592547b6f2dae31ca324d6a9f23000f63ad4c0ecc7953cae5d8d632aa482f86d",
    ),
    "outward": (
        "bbadb095a1c5e95ab2aa37f7b2f7ffd54e22efc8c3e075cf1f81fb9edbc4c166",
        "53f9ff5206deb1cbbdcb3fd913b427025f6b794fe547bd35020a81aebf9b7592",
    ),
    "by_rows": (
        "97ee257bd28ce62437955a2ecec283f2904dfe1c4a49b9920048e8ed07ff5393",
        "cc5e2b2f463644860c2ab43e2656eb78cbb3742f14b0821523c0dc4afb8f5b3a",
    ),
    "coherent": (
        "45254d910d47a1e0a145c853c84446a69cf6ce44d2b94b2883477642795d151b",
        "52d07d6b92425320cef3388db649f62ac1df2da514371812ca90f17e1e0f1a07",
    ),
}
"""Map, and picture with a feather of 3 px, of every recipe."""


def hashes(name: str, threads: int = 1) -> tuple[str, str]:
    """Hash the map, and the picture with a feather of 3 px (not where GOLDEN_MAPS_ONLY is set)."""
    out = RECIPES[name](ia.Run(threads))
    if "GOLDEN_MAPS_ONLY" in os.environ:
        return out.map.digest, ""
    pixels = out.render(feather=3, run=ia.Run(threads)).pixels
    return out.map.digest, hashlib.sha256(pixels.tobytes()).hexdigest()


@pytest.mark.parametrize("threads", [1, 2, 4])
@pytest.mark.parametrize("name", RECIPES)
def test_maps_are_what_they_were(name: str, threads: int) -> None:
    """R-02, R-13, law 4: bytes of maps and pictures, for any number of threads."""
    assert hashes(name, threads) == GOLDEN[name]


def elsewhere(names: list[str], **environment: str) -> dict[str, tuple[str, str]]:
    """Compute hashes in another process, under another environment."""
    run = subprocess.run(
        [sys.executable, __file__, *names], capture_output=True, text=True, env={**os.environ, **environment}
    )
    assert run.returncode == 0, run.stderr
    return {k: (a, b) for k, (a, b) in json.loads(run.stdout).items()}


def newer_features() -> str:
    """The instruction sets that NumPy would choose by itself on this machine, beyond its baseline."""
    from numpy._core import _multiarray_umath as umath

    return " ".join(f for f in umath.__cpu_dispatch__ if umath.__cpu_features__.get(f))


@pytest.mark.parametrize("cores", ["Nehalem", "Haswell"])
def test_the_linear_algebra_of_another_cpu_changes_no_map(cores: str) -> None:
    """Law 4: OpenBLAS as if on an older CPU, with one thread."""
    names = ["plain", "exact", "started", "by_rows", "coherent"]
    assert elsewhere(names, OPENBLAS_CORETYPE=cores, OPENBLAS_NUM_THREADS="1") == {n: GOLDEN[n] for n in names}


def test_numpy_without_its_fast_paths_changes_no_map() -> None:
    """Law 4: NumPy with no instruction set beyond its baseline."""
    names = ["plain", "automatic", "started", "outward", "by_rows"]
    assert elsewhere(names, NPY_DISABLE_CPU_FEATURES=newer_features()) == {n: GOLDEN[n] for n in names}


def test_kernels_compiled_for_any_cpu_change_no_map(tmp_path: Path) -> None:
    """Law 4: all kernels compiled again, for the plainest CPU of this architecture; the slowest test here."""
    environment = {"NUMBA_CPU_NAME": "generic", "NUMBA_CACHE_DIR": str(tmp_path), "GOLDEN_MAPS_ONLY": "1"}
    assert elsewhere(["wrapped"], **environment)["wrapped"][0] == GOLDEN["wrapped"][0]


def test_another_order_of_hashing_changes_no_map() -> None:
    """R-02: nothing depends on the order of a set or a dict of another process."""
    assert elsewhere(["started"], PYTHONHASHSEED="12345") == {"started": GOLDEN["started"]}


if __name__ == "__main__":
    print(json.dumps({name: hashes(name) for name in sys.argv[1:] or RECIPES}, indent=4))
