"""Maps in plain words: looked up, compared, replayed."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt

from ..exemplar import Exemplar
from ..geometry import ISOMETRIES, Wrap
from ..image import Array
from ..sourcemap import SourceMap
from ..synthesis import Synthesis
from ..tasks.requested import replayed as made_again


def which_of(smap: SourceMap) -> NDArray[np.uint8]:
    """Return the exemplar number of every pixel, also where the map leaves it out."""
    return np.zeros((smap.height, smap.width), np.uint8) if smap.which is None else smap.which


def pose_of(smap: SourceMap) -> NDArray[np.uint8]:
    """Return the isometry of every pixel, also where the map leaves it out."""
    return np.zeros((smap.height, smap.width), np.uint8) if smap.pose is None else smap.pose


def looked_up(exemplars: Sequence[Exemplar], smap: SourceMap, plane: str | None = None) -> Array:
    """Fetch every pixel of a map from its exemplar, one exemplar after the other: law 1 in plain words."""
    planes = [e.base if plane is None else e.planes[plane] for e in exemplars]
    out = np.zeros((smap.height, smap.width, planes[0].channels), planes[0].pixels.dtype)
    for number, p in enumerate(planes):
        mine = which_of(smap) == number
        out[mine] = p.samples[smap.yx[mine, 0], smap.yx[mine, 1]]
    return out if planes[0].pixels.ndim == 3 else out[:, :, 0]


def same_map(a: SourceMap, b: SourceMap) -> bool:
    """Say whether two maps show the same pixels in the same poses."""
    return a.digest == b.digest


def same_pixels(a: SourceMap, b: SourceMap, where: NDArray[np.bool_]) -> bool:
    """Say whether two maps show the same exemplar pixels, in the same poses, wherever `where` says so."""
    pairs = ((a.yx, b.yx), (which_of(a), which_of(b)), (pose_of(a), pose_of(b)))
    return all(bool((one[where] == two[where]).all()) for one, two in pairs)


def unbroken(smap: SourceMap, axis: int) -> NDArray[np.bool_]:
    """Say where a pixel and the next along an axis (the first after the last) continue one another."""
    which, pose = which_of(smap), pose_of(smap)
    step = np.array([(i.j[0][axis], i.j[1][axis]) for i in ISOMETRIES])[pose]
    yx, other, turned = (np.roll(a, -1, axis) for a in (smap.yx, which, pose))
    return np.asarray((yx == smap.yx + step).all(axis=2) & (other == which) & (turned == pose))


def depth(start: SourceMap, wrap: Wrap) -> NDArray[np.int32]:
    """Return how far, along rows, columns and diagonals, every pixel is from the nearest hole."""
    known = ~start.holes
    if known.all():
        return np.full(known.shape, 1 << 20, np.int32)
    height, width = known.shape
    tops, lefts = (height if wrap.y else 0), (width if wrap.x else 0)
    around = np.pad(known, ((tops, tops), (lefts, lefts)), mode="wrap")
    far = distance_transform_cdt(around, metric="chessboard")
    return np.asarray(far[tops : tops + height, lefts : lefts + width], np.int32)


def laid_over(below: SourceMap, start: SourceMap) -> SourceMap:
    """Fill the holes of `start` from another map."""
    holes = start.holes
    return replace(
        start,
        yx=np.where(holes[:, :, None], below.yx, start.yx),
        which=np.where(holes, which_of(below), which_of(start)),
        pose=np.where(holes, pose_of(below), pose_of(start)),
    )


def replayed(recipe: str, exemplars: Sequence[Exemplar]) -> Synthesis:
    """Run a recipe (JSON, without a start map) again on its exemplars."""
    return made_again(json.loads(recipe), exemplars)
