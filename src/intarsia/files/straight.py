"""Pillow unpacks straight into the memory of an array; what must be converted is, band by band."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..image import Array

BAND = 1 << 20
"""Pixels that are converted at a time."""

UNSEEN = 0xA5
"""What stands in the last row until something is unpacked there."""

_STORED = {"L": 1, "P": 1, "LA": 4, "RGB": 4, "RGBA": 4, "CMYK": 4, "I;16": 2}
"""Mode -> bytes that Pillow stores a pixel in."""

_DENSE = ("L", "RGBA")
"""Modes that lie in memory as they lie in an array."""


def pixels_of(image: Any, doubt: Callable[[], None] | None = None) -> Array:
    """Return the pixels of an image that is opened, but not loaded: (H, W, C) of 8 bit, or (H, W) of 16.

    Palettes become colours, with opacity where they have some, CMYK becomes RGB, and a colour that stands for
    transparency an alpha. What is returned is all that is left in memory. Pillow takes a PNG without its last rows:
    where none seems to have come, `doubt` is called, and may raise an error.
    """
    from PIL import Image

    core: Any = Image.core  # type: ignore[attr-defined]
    (width, height), mode = image.size, image.mode
    held: Array | None = None
    if mode in _STORED and image.format != "GIF":  # which fills its memory by itself
        held = np.zeros((height, width, _STORED[mode]), np.uint8)
        image.im = core.map_buffer(held, image.size, "raw", 0, (mode, width * held.shape[2], 1))
        held[-1] = UNSEEN
    image.load()
    if doubt is not None and (held is None or (held[-1] == UNSEEN).all()):
        doubt()
    wanted = _wanted(image)
    if held is not None and mode == wanted and mode in _DENSE:
        return held
    if held is not None and mode == "I;16":
        return held.view("<u2").reshape(height, width)
    channels = len(wanted)
    if held is not None and channels <= held.shape[2]:  # a band never reaches pixels that are still to come
        out = held.reshape(-1)[: height * width * channels].reshape(height, width, channels)
    else:
        out = np.empty((height, width, channels), np.uint8)
    rows = max(1, BAND // width)
    for top in range(0, height, rows):
        part = image.crop((0, top, width, min(top + rows, height)))
        part = part if part.mode == wanted else part.convert(wanted)
        out[top : top + rows] = np.frombuffer(part.tobytes(), np.uint8).reshape(-1, width, channels)
    return out


def _wanted(image: Any) -> str:
    """The mode that says all that an image does, a letter for each channel."""
    mode, clear = str(image.mode), "transparency" in image.info
    if mode in ("1", "L", "RGB"):
        return {"1": "L"}.get(mode, mode) + "A" * clear
    return mode if mode in ("LA", "RGBA", "I;16") else "RGBA" if clear else "RGB"
