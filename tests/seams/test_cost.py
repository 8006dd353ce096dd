"""What the seams of a map cost: nothing where it goes on, else the differences on both sides, and steps of tone."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from analysis.naive_masking import visibility

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.foundation.geometry import ISOMETRIES, Wrap
from intarsia.model import Exemplar
from intarsia.model.sourcemap import SourceMap, identity
from intarsia.seams import energy
from intarsia.testing import noise, texture


def frames_of(smap: SourceMap) -> np.ndarray:
    """How the exemplar lies around every pixel: (H, W, 2, 2)."""
    if smap.frame is not None:
        return smap.frame.astype(float)
    pose = np.zeros((smap.height, smap.width), int) if smap.pose is None else smap.pose
    return np.array([i.j for i in ISOMETRIES], float)[pose]


def turned(vectors: np.ndarray, pose: int) -> np.ndarray:
    """A normal (x right, y up) of a piece that is laid down in a pose."""
    j = np.array(ISOMETRIES[pose].j)
    down, right = j.T @ (-vectors[1], vectors[0])
    return np.array([right, -down, vectors[2]])


def slow_energy(exemplars: Sequence[Exemplar], smap: SourceMap) -> int:
    """Every pair of neighbours that are parted, one after the other; each pixel is read by itself."""
    feats, frame = features(exemplars), frames_of(smap)
    sub = np.zeros(smap.yx.shape) if smap.sub is None else smap.sub.astype(float)
    spread = []
    for p, e in zip(feats.pictures, exemplars, strict=True):
        seen = [pixel for y, x in np.ndindex(p.shape[:2]) for pixel in [p[y, x].tolist()]
                if e.usable is None or e.usable[y, x]]  # fmt: skip
        n = len(seen)
        spread.append(sum(n * sum(v * v for v in c) - sum(c) ** 2 for c in zip(*seen, strict=True)) // n**2)
    knee = max(max(math.isqrt(s) * 3 // 8, 1) for s in spread)
    visible = [visibility(p, knee, e.usable, e.toroidal) for p, e in zip(feats.pictures, exemplars, strict=True)]

    def number(y: int, x: int) -> int:
        return 0 if smap.which is None else int(smap.which[y, x])

    def pose(y: int, x: int) -> int:
        return 0 if smap.pose is None else int(smap.pose[y, x])

    def shown(at: tuple[int, int], beside: tuple[int, int] = (0, 0)) -> np.ndarray:
        """What the piece at a place shows there, or would `beside` it; its own where it ends. Last, how it is seen."""
        e, (y, x) = exemplars[number(*at)], (int(n) for n in smap.yx[at])
        v, u = y + beside[0], x + beside[1]
        if e.toroidal:
            v, u = v % e.height, u % e.width
        inside = 0 <= v < e.height and 0 <= u < e.width
        if not inside or (e.usable is not None and not e.usable[v, u]):
            v, u = y, x
        colour = feats.pictures[number(*at)][v, u].astype(int)
        for k in feats.normals:
            colour[k : k + 3] = turned(colour[k : k + 3], pose(*at))
        return np.append(colour, visible[number(*at)][v, u])

    def apart(a: np.ndarray, b: np.ndarray) -> int:
        squares = sum((int(p) - int(q)) ** 2 for p, q in zip(a[:-1], b[:-1], strict=True))
        far = math.isqrt(squares) + (math.isqrt(squares) ** 2 < squares)
        return far * int(a[-1] + b[-1]) // 256

    total = 0
    for y, x in np.ndindex(smap.height, smap.width):
        for axis, wrap in ((0, smap.wrap.y), (1, smap.wrap.x)):
            v, u = (y + 1, x) if axis == 0 else (y, x + 1)
            if (v == smap.height or u == smap.width) and not wrap:
                continue
            v, u = v % smap.height, u % smap.width
            on, back = frame[y, x, :, axis], frame[v, u, :, axis]
            moved = smap.yx[v, u] + sub[v, u] - smap.yx[y, x] - sub[y, x]
            missed = np.abs(moved - (on + back) / 2).max()
            if (number(y, x), pose(y, x)) == (number(v, u), pose(v, u)) and missed <= (0 if smap.exact else 1):
                continue
            forth, before = (tuple(int(n) for n in np.rint(step)) for step in (on, -back))
            cost = apart(shown((y, x)), shown((v, u), before)) + apart(shown((y, x), forth), shown((v, u)))
            total += 4 * cost if cost >= 4 * knee else cost * cost // knee
    return 1_000_000 * total // (knee * smap.height * smap.width)


def crazy(exemplars: Sequence[Exemplar], wrap: Wrap, seed: int, poses: bool = True) -> SourceMap:
    """Pieces of 5 x 4 px from anywhere, of any exemplar, in any pose."""
    drawn = (noise(60, 4, seed) >> np.uint64(40)).astype(np.int64)
    yx, which, pose = np.zeros((20, 16, 2), np.int32), np.zeros((20, 16), np.uint8), np.zeros((20, 16), np.uint8)
    for k in range(16):
        box = np.s_[k // 4 * 5 : k // 4 * 5 + 5, k % 4 * 4 : k % 4 * 4 + 4]
        own = ISOMETRIES[drawn[k, 2] % 8 if poses else 0]
        at = np.stack(np.mgrid[:5, :4], axis=2) @ np.array(own.j).T
        yx[box] = np.array([drawn[k, 0] % 7 + 5, drawn[k, 1] % 9 + 5]) + at
        which[box], pose[box] = drawn[k, 3] % len(exemplars), own.id
    sources = tuple(e.source for e in exemplars)
    return SourceMap(yx, which, pose if poses else None, sources, wrap)


@pytest.mark.parametrize("wrap", list(Wrap))
@pytest.mark.parametrize("made_of", ["one", "torus", "mask", "two", "normals"])
def test_the_energy_is_that_of_every_pair(wrap: Wrap, made_of: str) -> None:
    usable = np.ones((17, 19), bool)
    usable[:6] = False
    planes = {"albedo": texture(17, 19, 3, 2), "normal": texture(17, 19, 3, 4)} if made_of == "normals" else None
    first = Exemplar.of(planes or texture(17, 19, 3, 2), usable=usable if made_of == "mask" else None,
                        toroidal=made_of == "torus")  # fmt: skip
    exemplars = [first, Exemplar.of(texture(17, 19, 3, 5))] if made_of == "two" else [first]
    assert bool(features(exemplars).normals) == (made_of == "normals")
    for seed in range(2):
        smap = crazy(exemplars, wrap, seed)
        assert energy(exemplars, smap) == slow_energy(exemplars, smap) > 0


@pytest.mark.parametrize("wrap", [Wrap.NONE, Wrap.BOTH])
def test_the_energy_of_pieces_between_pixels(wrap: Wrap) -> None:
    """Turned and scaled a little from column to column, and cut at both halves."""
    e = Exemplar.of(texture(40, 44, 3, 7))
    rows, columns = np.mgrid[:20, :16]
    frame = np.zeros((20, 16, 2, 2), np.float32)
    frame[..., 0, 0], frame[..., 1, 1] = 1.25, 1 + columns / 64
    frame[..., 0, 1] = np.where(columns < 8, 0.25, -0.25)
    down = 8 + 1.25 * rows + np.where(columns < 8, 0.25 * columns, 0)
    at = np.stack([down, 3 + columns * (1 + columns / 128)], axis=2)
    at[10:] += np.array([1, 3])
    yx = np.rint(at).astype(np.int32)
    smap = SourceMap(yx, None, None, (e.source,), wrap, frame=frame, sub=(at - yx).astype(np.float32))
    assert energy([e], smap) == slow_energy([e], smap) > 0


def test_the_energy_of_bands_is_that_of_the_whole() -> None:
    """Maps are measured in bands of 128 rows."""
    e = Exemplar.of(texture(30, 30, 3, 7))
    made = ia.synthesize(e, (300, 20), ia.RandomTiling(patch=10), seed=1, wrap="both")
    assert made.energy == slow_energy([e], made.map) > 0
    flat = Exemplar.of(np.full((17, 19, 3), 70, np.uint8))
    assert energy([e], identity([e.source], 0)) == energy([flat], crazy([flat], Wrap.BOTH, 1)) == 0
