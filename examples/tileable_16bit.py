"""Grow a tileable 16-bit picture, every pixel an exact copy: python examples/tileable_16bit.py [SIZE]."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import intarsia as ia


def main(size: int = 512, folder: Path = Path("demo")) -> Path:
    """Grow in 16 bit, and check that nothing was rounded on the way, not even through the file."""
    folder.mkdir(exist_ok=True)
    gravel = np.asarray(ia.read("sample:gravel").base).astype(np.uint16) * 257
    gravel += np.arange(gravel.size, dtype=np.uint16).reshape(gravel.shape) % 256  # detail that 8 bits cannot hold
    made = ia.synthesize(gravel, size, seed=3, wrap="both", blend=ia.Blend())
    out = folder / "gravel_16bit.png"
    ia.write(out, made, force=True)
    assert (np.asarray(ia.read(out).base) == gravel[made.map.yx[..., 0], made.map.yx[..., 1]]).all()
    ia.write(folder / "gravel_4x.png", np.tile(np.asarray(made), (2, 2)), force=True)  # shows that it tiles
    return out


if __name__ == "__main__":
    print(main(*(int(a) for a in sys.argv[1:])))
