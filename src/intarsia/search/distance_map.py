"""Distance maps: the distance of every exemplar patch to one window (Multrus 2003, Figs. 3.12 and 4.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import RANGE, channel_shares, transformed
from ..foundation.arrays import Float32, Pair
from ..foundation.geometry import ISOMETRIES
from ..model import Exemplar
from ..model.image import Kind
from . import Candidates, PosedExemplars, fourier_kernels
from .fourier_kernels import FAR as FARTHEST

FAR = -1.0  # the value of distance maps where no patch may begin


def distance_maps(found: Candidates, variants: PosedExemplars, scale: float) -> list[Float32]:
    """Return for every variant the distance of the patch at each first pixel, FAR where none may begin.

    The distance is the root mean square difference over the known pixels of the window, on the scale 0..1, measured
    exactly at every position. `scale`: the square of a difference of 1 in all channels, in units of the features
    (:func:`full_scale`).
    """
    area = max(int(found.known.sum()), 1)
    out = []
    for v, valid in enumerate(variants.valid):
        at = np.argwhere(valid)
        rows = np.column_stack([np.full(len(at), FARTHEST), np.full(len(at), v), at])
        fourier_kernels.measure(found.feats, found.known, variants.posed, rows)
        rms = np.full(valid.shape, FAR, np.float32)
        rms[*at.T] = np.sqrt(rows[:, 0] / (area * scale))
        out.append(rms)
    return out


def best_of_poses(
    maps: list[Float32], variants: PosedExemplars, patch: Pair
) -> list[Float32]:
    """Return for every exemplar the distance of the patch at each first pixel in the best isometry (Fig. 4.2).

    FAR where no patch may begin. `maps`: of every variant; `patch`: rows and columns, px.
    """
    best: dict[int, Float32] = {}
    for v, one in enumerate(maps):
        pose = int(variants.pose[v])
        upright = transformed(one, {5: 7, 7: 5}.get(pose, pose))
        if variants.toroidal[v]:  # on a torus: first pixels of reversed axes become first ones of patches
            turned = [min(row) < 0 for row in ISOMETRIES[pose].j]
            upright = np.roll(upright, [-t * (side - 1) for t, side in zip(turned, patch, strict=True)], (0, 1))
        upright = np.where(upright < 0, np.float32(np.inf), upright)
        number = int(variants.exemplar[v])
        best[number] = np.minimum(best.get(number, upright), upright)
    return [np.where(np.isinf(one), np.float32(FAR), one) for one in best.values()]


def full_scale(exemplar: Exemplar, weights: tuple[float, ...] | None) -> float:
    """Return the squared length, in features, of the step from the darkest to the brightest value in all channels.

    Features are normalised to the exemplar's own range, so 0 and 1 on this scale are the ends of that range.
    """
    base = exemplar.base
    shares = [1.0] if base.kind is Kind.LABEL else channel_shares(base, weights, base.channels)
    return RANGE**2 * sum(shares)


def side_by_side(maps: list[Float32]) -> Float32:
    """Return the maps of several exemplars side by side, aligned at the top."""
    height = max(m.shape[0] for m in maps)
    padded: list[Any] = [np.pad(m, ((0, height - len(m)), (0, 0)), constant_values=FAR) for m in maps]
    return np.concatenate(padded, axis=1)


def as_16_bit(picture: Float32) -> NDArray[np.uint16]:
    """Return a distance map in 16 bits: 0 for the nearest patch, 65535 for the farthest and where none may begin."""
    there = picture[picture >= 0]
    if not there.size:
        return np.full(picture.shape, 65535, np.uint16)
    low, span = float(there.min()), max(float(there.max() - there.min()), 1e-12)
    grey = np.rint((picture.astype(np.float64) - low) / span * 65535).clip(0, 65535)
    return np.where(picture >= 0, grey, 65535).astype(np.uint16)
