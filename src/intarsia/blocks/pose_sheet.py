"""An exemplar in several poses that keep its lattice, one below the other on one sheet.

Kernels then read mirrored and turned blocks like all others; a place on the sheet says which pose it is. Where the
lattice lies in a posed copy is found by correlating the copy with the exemplar.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.correlation import gncc
from ..analysis.features import Features, features, pose_array
from ..analysis.symmetry import allowed_isometries
from ..errors import ParameterError
from ..exemplar import Exemplar
from ..geometry import ISOMETRIES, ISOMETRY_SETS
from ..lattice.vectors import UNIT, Pairs, Vector, cell_of
from .grid import BlockGrid, block_places

KEPT = 0.04  # of a lattice vector: how far its mirror image may lie from a lattice point
ALIKE = 0.75  # of how the exemplar agrees with itself one period on: so well must a copy agree where auto decides
Vectors = tuple[Vector, Vector]
Places = dict[tuple[int, int], NDArray[np.int64]]


@dataclass(frozen=True, eq=False)
class Sheet:
    """The posed copies."""

    picture: NDArray[np.int16]  # (H, W, C): the copies, each in its own band of `pitch` rows
    usable: NDArray[np.bool_]  # (H, W): which may be used; what lies between the copies may not
    poses: tuple[int, ...]  # isometry of each band, the identity first
    pitch: int  # px
    size: tuple[int, int]  # rows and columns of the picture that was posed
    source: NDArray[np.int32]  # (H, W, 2): the exemplar's pixel that each pixel of that picture shows

    def to_exemplar(self, yx: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.uint8] | None]:
        """Turn px of the sheet into px of the exemplar, and their poses; None where all are upright."""
        if len(self.poses) == 1:
            return self.source[yx[..., 0], yx[..., 1]], None
        band, row = np.divmod(yx[..., 0], self.pitch)
        out, pose = np.zeros_like(yx), np.array(self.poses, np.uint8)[band]
        for p in self.poses:
            (a, b), (c, d) = ISOMETRIES[p].j
            start = ISOMETRIES[p].start(*self.size)
            here, y, x = pose == p, row, yx[..., 1]
            out[here, 0], out[here, 1] = (start[0] + a * y + b * x)[here], (start[1] + c * y + d * x)[here]
        return self.source[out[..., 0], out[..., 1]], pose


def sheet_of(
    feats: Features, usable: NDArray[np.bool_], source: NDArray[np.int32], poses: tuple[int, ...], gap: int
) -> Sheet:
    """Lay out a picture in some poses, `gap` px apart; `source`: the exemplar's pixel that each of its pixels shows."""
    size = feats.pictures[0].shape[:2]
    if len(poses) == 1:
        return Sheet(feats.pictures[0], usable, poses, size[0], (size[0], size[1]), source)
    pitch, width = max(size) + gap, max(size)
    picture = np.zeros((pitch * len(poses), width, feats.pictures[0].shape[2]), np.int16)
    valid = np.zeros(picture.shape[:2], bool)
    for k, pose in enumerate(poses):
        copy, mask = feats.posed(0, pose), pose_array(usable, pose)
        picture[k * pitch : k * pitch + copy.shape[0], : copy.shape[1]] = copy
        valid[k * pitch : k * pitch + mask.shape[0], : mask.shape[1]] = mask
    return Sheet(picture, valid, poses, pitch, (size[0], size[1]), source)


def lattice_poses(choice: str | tuple[int, ...], cell: Vectors, exemplar: Exemplar, feats: Features) -> tuple[int, ...]:
    """The isometries of a parameter that map the lattice onto itself, the identity among them.

    Of a named set those that do not are left out; ``auto`` also leaves out those that change the look, or whose
    copy agrees with the exemplar nowhere. ParameterError where one given by its number does not keep the lattice.
    """
    if choice == "auto":
        alike = allowed_isometries([exemplar])
        kept = [p for p in alike if p == 0 or (_keeps(cell, p) and _agrees(feats, p, cell))]
        return tuple(kept)
    if isinstance(choice, str):
        return tuple(p for p in ISOMETRY_SETS[choice] if _keeps(cell, p))
    for p in choice:
        if not _keeps(cell, p):
            raise ParameterError(
                f"isometries: {p} ({ISOMETRIES[p].name}) does not map the lattice to itself; leave it out."
            )
    return (0, *(p for p in choice if p))


def resolved_poses(
    choice: str | tuple[int, ...], lattice: Pairs, exemplar: Exemplar,
    weights: tuple[float, ...] | None,
) -> str | tuple[int, ...]:  # fmt: skip
    """Decide an ``isometries`` parameter that is "auto", and refuse one that does not keep the lattice."""
    first, second = cell_of(lattice, (exemplar.height, exemplar.width))
    if second is None:  # courses are laid upright
        return choice
    poses = lattice_poses(choice, (first, second), exemplar, features([exemplar], weights))
    return poses if choice == "auto" else choice


def posed_places(sheet: Sheet, feats: Features, grid: BlockGrid, upright: Places) -> Places:
    """List where blocks may be read on the sheet, 1/256 px, by the parity of their row and column."""
    found = {kind: [places] for kind, places in upright.items()}
    for k, pose in enumerate(sheet.poses[1:], 1):
        (dy, dx), _ = offset(feats, pose)
        moved = replace(grid, phase=(grid.phase[0] - dy * UNIT, grid.phase[1] - dx * UNIT))
        shape = feats.posed(0, pose).shape
        valid = sheet.usable[k * sheet.pitch : k * sheet.pitch + shape[0], : shape[1]]
        for kind in found:
            found[kind].append(np.add(block_places(moved, valid, kind), (k * sheet.pitch * UNIT, 0)))
    return {kind: np.concatenate(places) for kind, places in found.items()}


def offset(feats: Features, pose: int) -> tuple[tuple[int, int], float]:
    """Where on the exemplar a posed copy agrees with it best, (y, x) px, and how well."""

    def agreement() -> tuple[tuple[int, int], float]:
        picture, copy = feats.pictures[0], feats.posed(0, pose)
        found = gncc(picture, copy)
        middle = copy.shape[0] - 1, copy.shape[1] - 1
        reach = [min(a, b) // 2 for a, b in zip(picture.shape[:2], copy.shape[:2], strict=True)]  # a half must overlap
        near = np.rint(1e6 * found[tuple(slice(m - r, m + r + 1) for m, r in zip(middle, reach, strict=True))])
        y, x = np.unravel_index(int(near.argmax()), near.shape)
        return (int(y) - reach[0], int(x) - reach[1]), float(near.max() / 1e6)

    return feats.memo(("offset", pose), agreement)


def _keeps(cell: Vectors, pose: int) -> bool:
    """Whether a pose maps a lattice onto itself."""
    (a, b), (c, d) = ISOMETRIES[pose].j
    vectors = np.array(cell, float)
    inverse = np.linalg.inv(vectors)
    for y, x in cell:
        posed = np.array((a * y + c * x, b * y + d * x), float)  # J^T: a step of the exemplar as the copy shows it
        times = posed @ inverse
        off = (times - np.rint(times)) @ vectors
        if math.hypot(*off) > KEPT * math.hypot(y, x) + UNIT / 2:
            return False
    return True


def _agrees(feats: Features, pose: int, cell: Vectors) -> bool:
    """Whether a posed copy agrees about as well as the exemplar does with itself, moved by a lattice vector."""
    picture = feats.pictures[0]
    own: Any = gncc(picture, picture)
    middle = picture.shape[0] - 1, picture.shape[1] - 1
    steps = [(round(v[0] / UNIT), round(v[1] / UNIT)) for v in cell]
    best = max(float(own[middle[0] + y, middle[1] + x]) for y, x in steps)
    return offset(feats, pose)[1] >= ALIKE * best
