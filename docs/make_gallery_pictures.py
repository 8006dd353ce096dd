"""Remake the pictures of the README: what the program does, input beside output, and what it cannot do.

Exemplars are painted by formula, or are photographs that come with scikit-image under CC0.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from make_painting_pictures import coloured, path_and_lawn
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


def grown(exemplar: np.ndarray, size: int = SIDE, seed: int = 1, **more: Any) -> np.ndarray:
    """What grows by the command without an option."""
    return rgb(ia.synthesize(exemplar, size, seed=seed, **more))


def pair(exemplar: np.ndarray, **more: Any) -> np.ndarray:
    """An exemplar beside what grows from it."""
    return beside(exemplar, grown(exemplar, **more))


def grow() -> np.ndarray:
    return pair(part("pebbles", PART))


def tile() -> np.ndarray:
    """A photograph that tiles afterwards, four times."""
    tiled = rgb(ia.tile(part("gravel", PART), seed=1))
    return beside(part("gravel", PART), np.tile(tiled, (2, 2, 1))[:SIDE, :SIDE])


def extend() -> np.ndarray:
    return beside(part("stones", PART), rgb(ia.extend(part("stones", PART), ia.Margins(80, 80, 80, 80), seed=2)))


def heal() -> np.ndarray:
    """A disc and a scratch, and the same wall without."""
    wall = sample("stones")
    y, x = np.mgrid[: wall.shape[0], : wall.shape[1]]
    hole = ((y - 124) ** 2 + (x - 150) ** 2 < 30**2) | (abs(y - 0.55 * x - 60) < 3)
    marked = np.where(hole[..., None], np.uint8([230, 30, 160]), wall)
    return beside(marked, rgb(ia.heal(wall, hole, seed=2)))


def paint() -> np.ndarray:
    """A path in grass, labels of another path, and that path."""
    pixels, marks = path_and_lawn()
    y, x = np.mgrid[:SIDE, :SIDE] - SIDE / 2
    radius = np.hypot(y, x) + 8 * np.sin(3 * np.arctan2(y, x))
    target = ((radius > 65) & (radius < 120)).astype(np.uint8)
    guide = ia.Guide(*(ia.Plane(m, ia.Kind.LABEL) for m in (marks, target)))
    wished = coloured(target)[::2, ::2]
    return beside(pixels[:PART, :PART], wished, rgb(ia.synthesize(pixels, None, seed=2, guide=guide)))


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
    return pair(np.ascontiguousarray(data.coffee()[60:300:1, 100:340][::3, ::3].repeat(2, 0).repeat(2, 1)))


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
    "gallery-grow": grow, "gallery-tile": tile, "gallery-extend": extend, "gallery-heal": heal, "gallery-paint": paint,
    "gallery-material": material, "limit-picture": picture, "limit-once": once, "limit-two": two, "limit-light": lit,
    "limit-packed": packed, "limit-slanted": slanted,
}  # fmt: skip


if __name__ == "__main__":
    for name, make in PICTURES.items():
        Image.fromarray(make()).save(FOLDER / f"{name}.jpg", quality=84, optimize=True)
