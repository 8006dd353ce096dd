"""Conversion of user input (arrays, masked arrays, Pillow images) to pixel arrays and masks, without loss.

NumPy's own conversion would use the values under masked pixels, take palette indices for gray and amounts of ink for
amounts of light, and wrap integers around, such as 256 to 0.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import InputError, IntarsiaError, said
from . import Pair as Pair

Array = NDArray[Any]
Mask = NDArray[np.bool_]
UInt8 = NDArray[np.uint8]
Int16 = NDArray[np.int16]
Int32 = NDArray[np.int32]
Int64 = NDArray[np.int64]
Float32 = NDArray[np.float32]
Floats = NDArray[np.float64]

Laid = tuple[Int32, UInt8 | None, Array]
"""A partly filled window: exemplar pixels (H, W, 2), their poses (H, W) or None for upright, mask of filled px."""

CONVERTED = {
    "1": "L", "La": "LA", "P": "RGB", "PA": "RGBA", "RGBa": "RGBA", "RGBX": "RGB",
    "CMYK": "RGB", "HSV": "RGB", "YCbCr": "RGB", "LAB": "RGB",
}  # fmt: skip
"""Pillow modes that are converted to another one: palettes, inks, colour spaces, premultiplied opacity."""

KEPT = ("L", "LA", "RGB", "RGBA", "I;16", "I;16L", "I;16B", "I;16N", "I", "F")
"""Pillow modes whose pixels are taken as they are."""

CLEAR = {"1": "LA", "L": "LA", "RGB": "RGBA", "P": "RGBA"}  # modes that may declare colours transparent -> with opacity
DEEPEST = 65535  # largest value of a 16-bit pixel


def pixels_of(given: Any, labels: bool = False) -> Array:
    """Return pixels as an array: Pillow images as displayed, at their depth; palette indices if they are `labels`.

    Raises
    ------
    InputError
        for masked pixels, which only an exemplar can leave out; for unknown Pillow modes, and for what is no array.
    """
    if is_picture(given):
        return _as_pillow_shows(given, labels)
    if isinstance(given, np.ma.MaskedArray):
        if np.ma.getmaskarray(given).any():
            raise InputError("some pixels are masked, which means nothing here; fill them, or make an Exemplar of it.")
        return np.ma.getdata(given)
    try:
        return np.asarray(given)
    except (IntarsiaError, MemoryError):
        raise
    except Exception as e:  # rows of unequal length, or whatever an object's own conversion may do
        raise InputError(f"{type(given).__name__} is no array of pixels ({said(e)}); give (height, width).") from None


def masked_pixels(given: Any) -> Mask | None:
    """Return which pixels of an array (H, W[, C]) are masked, in any channel: bool (H, W); None where none are."""
    if not isinstance(given, np.ma.MaskedArray):
        return None
    every = np.ma.getmaskarray(given)
    masked = np.asarray(every.any(axis=2) if every.ndim == 3 else every, bool)
    return masked if masked.any() else None


def marks(given: Any, what: str) -> Mask:
    """Return a mask as bool (H, W): True for pixels that are neither black nor wholly transparent.

    `given`: an array (H, W) of truth values or numbers of any type, or a gray or RGB picture with or without opacity.
    `what`: its name in messages. Raises InputError for anything else, and for NaN.
    """
    if isinstance(given, (str, bytes)) or hasattr(type(given), "__fspath__"):
        raise InputError(f"{what} is the name of a file; give its pixels, as an array (height, width).")
    try:
        mask = pixels_of(given)
    except InputError as e:
        raise InputError(f"{what}: {e}") from None
    if mask.dtype.kind not in "buif":
        raise InputError(f"{what} is of type {mask.dtype}; give truth values, or numbers that are 0 where nothing is.")
    if mask.ndim not in (2, 3) or 0 in mask.shape or (mask.ndim == 3 and mask.shape[2] > 4):
        raise InputError(f"{what} has the shape {mask.shape}; give (height, width), or a gray or RGB picture.")
    if mask.dtype.kind == "f" and np.isnan(mask).any():
        raise InputError(f"{what} holds NaN, which neither marks a pixel nor leaves it; give numbers.")
    if mask.ndim == 2:
        return np.asarray(mask != 0)
    colours = mask.shape[2] - (mask.shape[2] in (2, 4))
    light = (mask[:, :, :colours] != 0).any(axis=2)
    return np.asarray(light if colours == mask.shape[2] else light & (mask[:, :, -1] != 0))


def is_picture(given: Any) -> bool:
    """Whether an object is a Pillow image, without importing Pillow."""
    return any((c.__module__, c.__name__) == ("PIL.Image", "Image") for c in type(given).__mro__)


def _as_pillow_shows(image: Any, labels: bool) -> Array:
    """Return the pixels of a Pillow image as Pillow displays them; of label images palette indices."""
    try:
        mode = str(image.mode)
        if labels and mode in ("1", "P"):
            return np.asarray(image)
        if mode in CLEAR and image.has_transparency_data:
            return np.asarray(image.convert(CLEAR[mode]))
        if mode not in CONVERTED and mode not in KEPT:
            raise InputError(f"a picture of Pillow's mode {mode} is not supported; convert it, to RGB say.")
        pixels = np.asarray(image if mode in KEPT else image.convert(CONVERTED[mode]))
    except (IntarsiaError, MemoryError):
        raise
    except Exception as e:  # pictures of files are read here, and their decoders fail in many ways
        raise InputError(f"the picture of Pillow cannot be read ({said(e)}); look at its file.") from None
    if mode == "I":
        low, high, most = int(pixels.min()), int(pixels.max()), 2**31 - 1 if labels else DEEPEST
        if low < 0 or high > most:
            raise InputError(f"a picture of Pillow's mode I holds {low} to {high}; give 0 to {most}, or mode F.")
        return pixels.astype(np.uint32 if labels else np.uint16)
    key = image.info.get("transparency") if pixels.dtype.itemsize == 2 else None
    if isinstance(key, int):  # one gray of 16 bit that is transparent
        return np.dstack([pixels, np.where(pixels == key, 0, DEEPEST)]).astype(np.uint16)
    return pixels
