"""How pieces lie where no isometry of whole pixels says it: what a map may hold of frames and fractions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .geometry import ISOMETRIES

Array = NDArray[Any]

AREA = 64.0
"""A frame shows at most so many times the area of the exemplar, and at least 1 over it."""

STEP = 64.0
"""Most px of the exemplar, along each axis, that a step of one px in the output may be."""

ASIDE = 1.0
"""Most px that an entry may lie beside its exemplar pixel."""

ROWS = 16
"""Rows of a map that are checked together: what is computed of them stays in a core's cache."""

UPRIGHT = np.eye(2, dtype=np.float32)

_POSES = np.array([isometry.j for isometry in ISOMETRIES], np.float64)


def frozen(name: str, value: Any, dtype: Any, shape: tuple[int, ...] | None) -> Array | None:
    """Return an array of a map as one of this type that cannot be written to; a `shape` of None is that of ``yx``."""
    if value is None and shape is not None:
        return None
    with np.errstate(over="ignore", invalid="ignore"):  # what becomes infinite is refused as such
        try:
            array = np.ascontiguousarray(value, dtype=dtype)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{name} of a map holds no numbers; give an array.") from None
    if shape is None and (array.ndim != 3 or array.shape[2] != 2):
        raise InputError(f"{name} of shape {array.shape} is no map; it needs (height, width, 2).")
    if shape is not None and array.shape != shape:
        raise InputError(f"{name} of shape {array.shape} does not fit the map of shape {shape}.")
    array = array.view()
    array.flags.writeable = False
    return array


def check_frames(frame: Array | None, sub: Array | None, pose: Array | None, holes: Array) -> None:
    """Refuse frames and fractions that nothing can be drawn from; what stands in holes is never read.

    Raises
    ------
    InputError
        where a frame stands beside a pose, is not finite, shows more than 64 times the area or less than 1/64 of it, or
        takes steps of more than 64 px; where a fraction is not finite, or more than 1 px.
    """
    if frame is not None:
        if pose is not None:
            raise InputError("the map has both pose and frame; give one, a frame can say all that a pose can.")
        if bad := sum(_unsound(frame[k : k + ROWS], holes[k : k + ROWS]) for k in range(0, len(frame), ROWS)):
            raise InputError(
                f"frame holds {bad} matrices that are not finite, take steps of more than {STEP:.0f} px, or scale "
                f"areas by more than {AREA:.0f} or less than 1/{AREA:.0f}; give others."
            )
    if sub is not None and (bad := int((~(np.abs(sub) <= ASIDE).all(axis=2) & ~holes).sum())):
        raise InputError(
            f"sub holds {bad} fractions that are not finite or beyond {ASIDE:.0f} px; let yx name the nearest pixel."
        )


def _unsound(frame: Array, holes: Array) -> int:
    """Count frames, outside of holes, that nothing can be drawn from."""
    with np.errstate(invalid="ignore", over="ignore"):
        yy, yx, xy, xx = (np.ascontiguousarray(frame[..., m, n], np.float64) for m in (0, 1) for n in (0, 1))
        area = np.abs(yy * xx - yx * xy)
        fine = (area >= 1 / AREA) & (area <= AREA)
        for part in (yy, yx, xy, xx):
            fine &= np.abs(part) <= STEP
    return int((~fine & ~holes).sum())


def matrices(frame: Array | None, pose: Array) -> NDArray[np.float64]:
    """Return J of every pixel, (H, W, 2, 2), of frames, or of poses where there are none."""
    return frame.astype(np.float64) if frame is not None else _POSES[np.minimum(pose, 7)]


def positions(yx: Array, sub: Array | None) -> NDArray[np.float64]:
    """Return where in the exemplar every pixel lies, (H, W, 2), with its fraction."""
    return yx + (np.zeros(2) if sub is None else sub.astype(np.float64))
