"""All the ways in which patches can be taken: every exemplar in every allowed pose, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..analysis.features import Features, pose_array
from ..analysis.sums import valid_windows, without_patch
from ..arrays import Array, Int16, Int32, Int64, Mask, Pair, UInt8
from ..errors import ParameterError
from ..exemplar import Exemplars
from ..geometry import ISOMETRIES, ISOMETRY_SETS
from ..kernels.windows import Grown, Posed, gather_all
from ..sourcemap import HOLE

MAX_VARIANTS = 250
STRIP = 256  # rows of a map that are turned together: nothing larger is held besides the map


@dataclass(frozen=True, eq=False)
class PosedExemplars:
    """Posed exemplars as kernels want them.

    A toroidal exemplar is followed by its own beginning, so that every window can be read straight.
    """

    flat: Int16  # all features, one variant after the other, each (rows, stride, channels)
    table: Int64  # (V, 4): where a variant begins in ``flat``, height, width, and the stride in px
    exemplar: UInt8  # (V,): which exemplar it is
    pose: UInt8  # (V,): and how it lies
    # Of every variant, the windows' first pixels at which a patch holds usable pixels only.
    valid: tuple[Mask, ...]
    channels: int
    toroidal: Mask  # (V,): whether its exemplar is

    def __len__(self) -> int:
        return len(self.table)

    @cached_property
    def posed(self) -> Posed:
        """The features and where each variant lies in them, as kernels take them."""
        return Posed(self.flat, self.table)

    def picture(self, v: int) -> Int16:
        """The features of a variant, (rows, stride, channels), a view."""
        start, _, _, stride = (int(n) for n in self.table[v])
        stop = int(self.table[v + 1, 0]) if v + 1 < len(self) else len(self.flat)
        return self.flat[start:stop].reshape(-1, stride, self.channels)

    def windows(self, grown: Grown, at: Array, patch: Sequence[int]) -> tuple[Array, Array]:
        """Read what windows of a map hold that begin at `at`: features (n, h, w, C) int16, and where there are any."""
        feats, known = np.empty((len(at), *patch, self.channels), np.int16), np.empty((len(at), *patch), np.uint8)
        gather_all(grown, self.posed, at, feats, known)
        return feats, known

    @cached_property
    def turns(self) -> Int64:
        """Where the pixel that variant v shows at (y, x) lies in variant k: (V, V, 7) of a, b, c, d, e, f, g.

        At (a y + b x + e, c y + d x + f), where g is 1; it is 0 for variants of two exemplars, and for v = k.
        """
        out = np.zeros((len(self), len(self), 7), np.int64)
        posed = [(ISOMETRIES[p], self.table[v, 1:3].tolist()) for v, p in enumerate(self.pose.tolist())]
        frames = [(np.array(iso.j), np.array(iso.start(*(size[::-1] if iso.swaps else size)))) for iso, size in posed]
        for v, (j, start) in enumerate(frames):
            for k, (other, begin) in enumerate(frames):
                if v != k and self.exemplar[v] == self.exemplar[k]:
                    out[v, k] = *(other.T @ j).ravel(), *(other.T @ (start - begin)), 1
        return out

    def to_exemplars(
        self, yx: Int32, variant: UInt8
    ) -> tuple[Int32, UInt8, UInt8]:
        """Turn variant coordinates into (yx, which, pose) of the exemplars; HOLE stays."""
        if not self.pose.any():
            which = _lookup(self.exemplar, variant)
            return yx, which, np.zeros_like(which)
        out = np.zeros_like(yx)
        for top in range(0, len(yx), STRIP):
            rows = slice(top, top + STRIP)
            for v in range(len(self)):
                mine = variant[rows] == v
                iso = ISOMETRIES[self.pose[v]]
                _, height, width, _ = self.table[v]
                size = (width, height) if iso.swaps else (height, width)
                start = np.array(iso.start(*(int(s) for s in size)), np.int32)
                out[rows][mine] = start + yx[rows][mine] @ np.array(iso.j, np.int32).T
        return out, _lookup(self.exemplar, variant), np.where(variant == HOLE, 0, _lookup(self.pose, variant))


def isometry_ids(choice: str | tuple[int, ...]) -> tuple[int, ...]:
    """Return the isometry numbers that an ``isometries`` parameter names."""
    return ISOMETRY_SETS[choice] if isinstance(choice, str) else choice


def posed_exemplars(
    exemplars: Exemplars,
    feats: Features,
    poses: tuple[int, ...],
    patch: Pair,
    shown: tuple[int, ...] = (),
) -> PosedExemplars:
    """Lay out every exemplar in every pose for patches of (rows, columns) px.

    Poses that are only `shown` (in a start map) can be read, but no patch is taken from them. ParameterError where
    there are too many variants, MethodError where no window of any exemplar is free of masked pixels.
    """
    if len(exemplars) * len(poses) > MAX_VARIANTS:
        raise ParameterError(
            f"{len(exemplars)} exemplars in {len(poses)} poses are too many; at most {MAX_VARIANTS} in all."
        )
    blocks, rows, which, pose, valid = [], [], [], [], []
    begin = 0
    for number, exemplar in enumerate(exemplars):
        for p in sorted({*poses, *shown}):
            picture = feats.posed(number, p)
            height, width = picture.shape[:2]
            if exemplar.toroidal:
                picture = np.pad(picture, ((0, patch[0] - 1), (0, patch[1] - 1), (0, 0)), mode="wrap")
            usable = None if exemplar.usable is None else pose_array(exemplar.usable, p)
            allowed = valid_windows(picture.shape, usable, exemplar.toroidal, patch)
            valid.append(allowed if p in poses else np.zeros_like(allowed))
            blocks.append(picture.ravel())
            rows.append((begin, height, width, picture.shape[1]))
            which.append(number)
            pose.append(p)
            begin += picture.size
    if not any(v.any() for v in valid):
        raise without_patch(patch)
    flat = blocks[0] if len(blocks) == 1 else np.concatenate(blocks)
    return PosedExemplars(
        flat,
        np.array(rows, np.int64),
        np.array(which, np.uint8),
        np.array(pose, np.uint8),
        tuple(valid),
        feats.pictures[0].shape[2],
        np.array([exemplars[n].toroidal for n in which], bool),
    )


def in_one_row(valid: Sequence[Mask]) -> tuple[UInt8, Int64]:
    """Lay tables of all variants out as one of uint8; (V, 3): where each begins, its rows and columns."""
    begins = np.cumsum([0] + [v.size for v in valid])
    offsets = np.array([(b, *v.shape) for b, v in zip(begins.tolist(), valid, strict=False)], np.int64)
    return np.concatenate([v.astype(np.uint8).ravel() for v in valid]), offsets


def _lookup(table: UInt8, variant: Array) -> UInt8:
    full = np.full(256, HOLE, np.uint8)
    full[: len(table)] = table
    out = np.empty(variant.shape, np.uint8)
    for top in range(0, len(variant), STRIP):  # numbers are made wide to look anything up
        out[top : top + STRIP] = full[variant[top : top + STRIP]]
    return out
