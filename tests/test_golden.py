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


RECIPES: dict[str, Callable[[ia.Run], ia.Synthesis]] = {
    f.__name__: f
    for f in (
        plain, wrapped, automatic, exact, started, tiled, outward, by_rows, coherent,
        by_segments, regular, courses, healed, sewn, shifted, corrected, chosen, tried,
        boards, plain_blocks, turned, advected, straightened, flattened,
    )
}

GOLDEN = {
    "plain": (
        "18f115048301ce71fd197a612a5ed0055758660ea98b8be95c8294ce3e608147",
        "dfcbc5d17cd4bcd0f51acd57f3b47849de3ec2a42d13150638f229b74b0cfa8b",
    ),
    "wrapped": (
        "0e82f96e9b3e82d2e88e3088b4544f3f9b4cf59e0faa0efe7219a933f6e217b7",
        "de755a8187a2676c5c1ded0f35e87dcb3add0dfb48e72184813e3c3d8b95ac14",
    ),
    "automatic": (
        "f0b309715bc01ee87594514df9ec33fd07c354f0f6f1c45267e3d3b2c17e262d",
        "69af5c5784b3cbb1911b6b210b619dc6e42c2c7f32db4cfa5ce988fd9a388748",
    ),
    "exact": (
        "9fe289b1b8dec2f6e07ae5123ec664b268d70bdb37f0dcd04a009bbb1d8b6153",
        "8129bab65ecc752a7ece406a8425597216d4956ff51890368768a96b3cb42deb",
    ),
    "started": (
        "af02db2be7a1f4d28c2415f805e81a2e0e93ad870dff197f4d0abe1c5cd759cb",
        "32b9d5a5efd22b49c564a057996229287406c920e211b663e45de68775c552fe",
    ),
    "tiled": (
        "52ef19583bcf8a820cf87cc06132385cfdcea7ba40fc61229fedd62b9b0b5eb9",
        "657c1dfcaa0c558ff1f789242a995976274f89645ffce32e9b637b487f697e3a",
    ),
    "outward": (
        "556f278d6c4931e8c94a38322217289df31a6a9c7b8444277888a185d48f2965",
        "18ba22bee0fd67c38cb3ef4a7cf29d2ca236385bece61d5cdf82daf73e82f122",
    ),
    "by_rows": (
        "33baa199ac6f0413cfff4bd6a7cabf0822b9daa01258c4c91c913a8ffa5d1c96",
        "33217768fa422832ee6f1406fcc3200ac064e5b140cb78e2a0b04819c30df23a",
    ),
    "coherent": (
        "b1a365775e5c2e1bb04472e5223981898c838719e4a057a29290e3929b2e9cb5",
        "53d6b34aebafd31357ec13120d4f1c5f28d7c2175e68f3d2c53f547c7ebe92b5",
    ),
    "by_segments": (
        "9ea94250689e24e9ce4af89817e598b3c1c8877072ce07988f9511b6cea4e4f7",
        "796739906ebbf9842bf35ad04f72512d5ebcf5bd3f825267b266691cb47c229e",
    ),
    "chosen": (
        "ab1bc8e22d5863f0e888e2d1a0bb77ccefd80b06abf66b2dfb681f7341ef0f02",
        "0f79ef9dab4dd6bdfa1fb98557f94be45db41ad3df8e9d4cc9ab3077bd29cc5d",
    ),
    "tried": (
        "b8b3d3817092d8194abed1159c6f677df37e6b6a546460371486541d683501b8",
        "7478a1125e10da1abd4daf19045c2568d888f19836dc06c02a2f6c1e08338193",
    ),
    "regular": (
        "16edebb08ea055d7456d1d86a17cdf9a5f647b6f9866df5db0c7d80e7b68a9fc",
        "f99133ec603e6dd723de7036b695525fe8e66774e643f2a2d98bc46fc4abfd1e",
    ),
    "courses": (
        "860f68ea627b7f532384c32c6bfdc847fbb9575d112936126477913707274b3a",
        "ae5c8f9ef3b5cd2b3c3155ec2a8e12e31402dd76e4887e6dfc974d20ea45a4c1",
    ),
    "healed": (
        "a1acfbe8a77cd274d4c1475c655e6567038d1f20b360169e160da6b8fb53f758",
        "a16c3a3e62a40c6ccf6a036230b9a7ae54f740305c1f36d5f5dcb9070a9e5bc4",
    ),
    "sewn": (
        "dbf1467382236d1ea057415ce0e41c0da3d7ffbe1e500aa06ad3d3d02f81deb4",
        "2392c175918f1cee1338886abba851bad5725750c429b8f7236897f05e1d2579",
    ),
    "shifted": (
        "453752ef295df9f02eb4c788793677f58ce7e077c9de84eb94d7a83518bf8ff3",
        "47c9763fb88a42698e5fbe3a483422467497565f1fce814f3b4c64417a2d8d4d",
    ),
    "corrected": (
        "d09aeebe3d2d3d3c0d1b8ae7807afa107a56f751ab03dbf21b5091f0170bb373",
        "cd44f4d92d2260f843aa2bf33b8d3bf904a1940cb03adec429592501fcc1e91c",
    ),
    "boards": (
        "cd89183106049ee0e4ea3f855604fc92d2b4428b94f1c42b7485208486e07bcb",
        "72715481e61eb72b23613e2fb45f1264bf28d12058a3e64bc57cf959fcda2103",
    ),
    "plain_blocks": (
        "b26c225ee4e715380813a730ce58ceeb8a3378bc8703fb08b9544a1d9d1f4212",
        "7fa40c4037d59a8439dceff350502c7b9a05ce04f94f2ce8c57301f080b9f94f",
    ),
    "turned": (
        "7b94a8ca2dd5bf5ff0c21421346c6b75e0ef417f13a98a126f31f55546a402f2",
        "3e13513c947844898e295706e62b7dbb9f102e460e94d33de168680812f0fb39",
    ),
    "advected": (
        "f46f5f218ed19b65a9950b095098b9a832513f937915ff6a1de414cd8d5b6e7f",
        "fefcd121b98f200e351252d9e50277771cad7439d026d6bd9910de40aac3a716",
    ),
    "straightened": (
        "5cb821c4aa1c3e85181ed449ba4c2be0232bffc5c3def9e35a62b47d91d18de3",
        "8e75bf352021146aeec81492731c2160f47770e610bb1679f134894b1db00031",
    ),
    "flattened": (
        "3f7e8db1e063d6a4843e1cf589cef4f313995c06e715d00360b8727425c01ca9",
        "6dae278ed48207eaed5442ecb5d392a444205a3f44cc27e87f313535b37c4f2c",
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
    return {k: (a, b) for k, (a, b) in json.loads(run.stdout).items()}


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
    print(json.dumps({name: hashes(name) for name in sys.argv[1:] or RECIPES}, indent=4))
