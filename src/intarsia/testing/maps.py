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
from ..methods.base import make
from ..params import parameters
from ..sourcemap import Blend, SourceMap
from ..synthesis import Synthesis, synthesize


def looked_up(exemplars: Sequence[Exemplar], smap: SourceMap, plane: str | None = None) -> Array:
    """Fetch every pixel of a map from its exemplar, one exemplar after the other: law 1 in plain words."""
    planes = [e.base if plane is None else e.planes[plane] for e in exemplars]
    out = np.zeros((smap.height, smap.width, planes[0].channels), planes[0].pixels.dtype)
    which = np.zeros(out.shape[:2], np.uint8) if smap.which is None else smap.which
    for number, p in enumerate(planes):
        mine = which == number
        out[mine] = p.samples[smap.yx[mine, 0], smap.yx[mine, 1]]
    return out if planes[0].pixels.ndim == 3 else out[:, :, 0]


def same_map(a: SourceMap, b: SourceMap) -> bool:
    """Say whether two maps show the same pixels in the same poses."""
    return a.digest == b.digest


def unbroken(smap: SourceMap, axis: int) -> NDArray[np.bool_]:
    """Say where a pixel and the next along an axis (the first after the last) continue one another."""
    which = np.zeros((smap.height, smap.width), np.uint8) if smap.which is None else smap.which
    pose = np.zeros((smap.height, smap.width), np.uint8) if smap.pose is None else smap.pose
    step = np.array([(i.j[0][axis], i.j[1][axis]) for i in ISOMETRIES])[pose]
    following = (np.roll(a, -1, axis) for a in (smap.yx, which, pose))
    yx, other, turned = following
    return np.asarray((yx == smap.yx + step).all(axis=2) & (other == which) & (turned == pose))


def same_pixels(a: SourceMap, b: SourceMap, where: NDArray[np.bool_]) -> bool:
    """Say whether two maps show the same exemplar pixels, in the same poses, wherever `where` says so."""
    for name in ("which", "pose"):
        one, two = (np.zeros(where.shape, np.uint8) if getattr(m, name) is None else getattr(m, name) for m in (a, b))
        if not (one[where] == two[where]).all():
            return False
    return bool((a.yx[where] == b.yx[where]).all())


def replayed(recipe: str, exemplars: Sequence[Exemplar]) -> Synthesis:
    """Run a recipe (JSON) again on its exemplars."""
    told = json.loads(recipe)
    assert [s["sha256"] for s in told["exemplars"]] == [e.digest for e in exemplars]
    kinds = {p.name: p.kind for p in parameters(make(told["method"], {}))}
    values = {k: v[::-1] if kinds[k] == "extent" and isinstance(v, list) else v for k, v in told["parameters"].items()}
    blend = Blend(**told["blend"])
    width, height = told["size"]
    method = make(told["method"], values)
    return synthesize(exemplars, (height, width), method, seed=told["seed"], wrap=told["wrap"], blend=blend)


def _filled(plane: Plane, value: Array) -> Plane:
    return plane.like(np.broadcast_to(value, plane.samples.shape))


def _depth(start: SourceMap, wrap: Wrap) -> NDArray[np.int32]:
    """How far, along rows, columns and diagonals, every start pixel is from the nearest hole."""
    known = ~start.holes
    if known.all():
        return np.full(known.shape, 1 << 20, np.int32)
    pad = [(n if w else 0,) * 2 for n, w in zip(known.shape, (wrap.y, wrap.x), strict=True)]
    depth = distance_transform_cdt(np.pad(known, pad, mode="wrap"), metric="chessboard")
    return np.asarray(depth[pad[0][0] : pad[0][0] + known.shape[0], pad[1][0] : pad[1][0] + known.shape[1]], np.int32)


def _laid_over(below: SourceMap, start: SourceMap) -> dict[str, Array]:
    """The arrays of `start`, its holes filled from another map."""
    holes, out = start.holes, {}
    for name in ("which", "pose"):
        one, two = (np.zeros(holes.shape, np.uint8) if getattr(m, name) is None else getattr(m, name) for m in (below, start))
        out[name] = np.where(holes, one, two)
    return {**out, "yx": np.where(holes[:, :, None], below.yx, start.yx)}
