"""Remake the pictures of the README: what the program does, input beside output, and what it cannot do.

Exemplars are painted by formula, or are photographs that come with scikit-image under CC0.
"""

from __future__ import annotations

import numpy as np
from make_pictures import FOLDER, beside, rgb, sample
from PIL import Image
from scipy.ndimage import zoom
from skimage import data
from skimage.transform import ProjectiveTransform, warp

import intarsia as ia

SIDE = 320  # px of what is grown
PART = 160  # px of an exemplar, as it is shown


def part(name: str, side: int = 192) -> np.ndarray:
    """The corner of a built-in exemplar."""
    return np.ascontiguousarray(sample(name)[:side, :side])


def grown(exemplar: np.ndarray, size: int = SIDE) -> np.ndarray:
    """What grows by the command without an option."""
    return rgb(ia.synthesize(exemplar, size, seed=1))


def pair(exemplar: np.ndarray) -> np.ndarray:
    """An exemplar beside what grows from it."""
    return beside(exemplar, grown(exemplar))


def grow() -> np.ndarray:
    return pair(part("pebbles", PART))


def tile() -> np.ndarray:
    """A photograph that tiles afterwards, four times."""
    tiled = rgb(ia.tile(part("gravel", PART), seed=1))
    return beside(part("gravel", PART), np.tile(tiled, (2, 2, 1))[:SIDE, :SIDE])


def material() -> np.ndarray:
    """Albedo, normal, roughness and height, grown together."""
    made = ia.synthesize("sample:setts", SIDE, seed=1)
    every = [np.asarray(made.render(name))[:PART, :PART] for name in made.exemplars[0].planes]
    seen = [rgb((p >> 8).astype(np.uint8) if p.dtype == np.uint16 else p) for p in every]
    return beside(part("setts", PART), np.concatenate([np.concatenate(seen[k : k + 2], 1) for k in (0, 2)]))


def picture() -> np.ndarray:
    """No texture: the cat of scikit-image."""
    return pair(np.ascontiguousarray(data.chelsea()[40:232, 120:312]))


def once() -> np.ndarray:
    """What is there once."""
    return pair(np.ascontiguousarray(data.coffee()[60:300, 100:340]))


def two() -> np.ndarray:
    """Two textures side by side."""
    return pair(np.concatenate([part("stones")[:, :96], part("planks")[:, :96]], axis=1))


def lit() -> np.ndarray:
    """A trend of light."""
    lamp = np.linspace(0.35, 1.25, 192)[None, :, None]
    return pair(np.clip(part("gravel") * lamp, 0, 255).astype(np.uint8))


def packed() -> np.ndarray:
    """Packed pebbles, twice as large as they grow: some are cut or fused."""
    made = grown(part("pebbles"), 256)[40:200, 60:220]
    return beside(part("pebbles")[:PART, :PART], zoom(made, (2, 2, 1), order=1))


def slanted() -> np.ndarray:
    """A wall seen from the side."""
    wall = data.brick() / 255.0
    corners = [[0, 0], [191, 70], [191, 150], [0, 191]], [[0, 0], [511, 0], [511, 511], [0, 511]]
    far = ProjectiveTransform.from_estimate(*map(np.array, corners))
    return pair(rgb((warp(wall, far, output_shape=(192, 192), mode="wrap") * 255).astype(np.uint8)))


PICTURES = {
    "gallery-grow": grow, "gallery-tile": tile, "gallery-material": material, "limit-picture": picture,
    "limit-once": once, "limit-two": two, "limit-light": lit, "limit-packed": packed, "limit-slanted": slanted,
}  # fmt: skip


if __name__ == "__main__":
    for name, make in PICTURES.items():
        Image.fromarray(make()).save(FOLDER / f"{name}.jpg", quality=84, optimize=True)
