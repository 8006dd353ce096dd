"""Short words as pixels, in the font that Pillow brings along."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import legible


def lettered(text: str, size: int) -> NDArray[np.uint8]:
    """Return a line of text, letters about `size` px high, as coverage: (height, width), 255 where ink is."""
    from PIL import Image, ImageDraw, ImageFont

    font, line = ImageFont.load_default(size), legible(text).encode("latin-1", "replace").decode("latin-1")
    left, _, right, _ = (int(n) for n in font.getbbox(line))
    paper = Image.new("L", (max(right - min(left, 0), 1), size + size // 2))
    ImageDraw.Draw(paper).text((-min(left, 0), 0), line, fill=255, font=font)
    return np.array(paper)
