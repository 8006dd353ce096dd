"""Grow colour, height and normals of one surface together: python examples/material_set.py [SIZE].

The built-in exemplar has colours only, so height and normals are made from its brightness; use maps of your own with
``ia.read("moss.png", height="moss_height.png", normal="moss_normal.png")``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import intarsia as ia


def material() -> ia.Exemplar:
    """Make a set of planes: 8-bit colour, 16-bit height, 8-bit normals."""
    colour = np.asarray(ia.read("sample:pebbles").base)
    light = colour.astype(np.float64) @ (0.30, 0.59, 0.11)
    height = np.round(light / 255 * 65535).astype(np.uint16)
    down, right = np.gradient(light / 24)
    normal = np.stack([-right, down, np.ones_like(light)], axis=2)  # green points up
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return ia.Exemplar.of(
        {"albedo": colour, "height": height, "normal": np.round((normal + 1) / 2 * 255).astype(np.uint8)}
    )


def main(size: int = 512, folder: Path = Path("demo")) -> list[Path]:
    """Grow the set once, with mirrored and turned pieces (normals turn with them), and write every plane."""
    folder.mkdir(exist_ok=True)
    made = ia.synthesize(material(), size, ia.ImageQuilting(isometries="both"), seed=2, wrap="both")
    written = []
    for name in made.exemplars[0].planes:
        written.append(folder / f"pebbles_{name}.png")
        ia.write(written[-1], made.render(name), force=True)
    return written


if __name__ == "__main__":
    print(*main(*(int(a) for a in sys.argv[1:])), sep="\n")
