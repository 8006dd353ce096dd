"""Remake the pictures of the documentation from built-in exemplars: ``make pictures``.

The pixels are the same on every machine; the bytes of the JPEG files depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP = 16
WHITE = 255


def grown(name: str, size: int | tuple[int, int], method: Any = "auto", **more: Any) -> ia.Synthesis:
    """Grow a built-in exemplar."""
    return ia.synthesize(f"sample:{name}", size, method, **more)


def rgb(picture: Any) -> np.ndarray:
    """Return 8-bit pixels as (H, W, 3)."""
    pixels = np.asarray(picture)
    return np.dstack([pixels] * 3) if pixels.ndim == 2 else pixels[:, :, :3]


def sample(name: str) -> np.ndarray:
    """Return a built-in exemplar as (H, W, 3)."""
    return rgb(ia.read(f"sample:{name}").base)


def beside(*pictures: np.ndarray) -> np.ndarray:
    """Put pictures side by side on white, centred."""
    height = max(p.shape[0] for p in pictures)
    width = sum(p.shape[1] for p in pictures) + GAP * (len(pictures) - 1)
    out = np.full((height, width, 3), WHITE, np.uint8)
    x = 0
    for p in pictures:
        y = (height - p.shape[0]) // 2
        out[y : y + p.shape[0], x : x + p.shape[1]] = p
        x += p.shape[1] + GAP
    return out


def hero() -> np.ndarray:
    """An exemplar, and what grows from it."""
    return beside(sample("tiles"), rgb(grown("tiles", (512, 768), seed=3)))


def photographs() -> np.ndarray:
    """What grows from the photographs of scikit-image."""
    return beside(*(rgb(grown(name, 320, "image-quilting", seed=1)) for name in ("brick", "grass", "gravel")))


def baseline() -> np.ndarray:
    """Random tiling and image quilting with patches of one size."""
    methods = ia.RandomTiling(patch=72), ia.ImageQuilting(patch=72)
    return beside(*(rgb(grown("stones", 400, method, seed=3)) for method in methods))


def patches() -> np.ndarray:
    """Patches too small, as chosen, and large."""
    return beside(*(rgb(grown("stones", 320, ia.ImageQuilting(patch=patch), seed=2)) for patch in (16, None, 128)))


def map_of() -> np.ndarray:
    """A picture, its pieces, and its coordinates as colours."""
    made = grown("stones", 320, seed=1)
    pieces = made.map.pieces().astype(np.uint32)
    mixed = (pieces + 1) * np.uint32(0x9E3779B1)
    mixed ^= mixed >> np.uint32(15)
    colours = np.stack([(mixed >> np.uint32(s)) & np.uint32(127) for s in (3, 11, 19)], axis=2).astype(np.uint8) + 96
    where = np.dstack([made.map.yx[:, :, ::-1], np.full((320, 320), 96)]).astype(np.uint8)  # 0 to 255 each
    return beside(rgb(made), colours, where)


def feathers() -> np.ndarray:
    """One map drawn with feathers of 0, 8 and 32 px."""
    made = grown("gravel", 320, ia.RandomTiling(patch=80), seed=1)
    return beside(*(rgb(made.render(feather=f)) for f in (0, 8, 32)))


def repetition() -> np.ndarray:
    """Without and with a price on using a patch again."""
    return beside(*(rgb(grown("planks", 480, ia.ImageQuilting(repeat_penalty=u), seed=4)) for u in (0.0, 0.2)))


def repeat() -> np.ndarray:
    """A sample that tiles, repeated, and a photograph that does not."""
    return beside(rgb(grown("tiles", (320, 512), "repeat")), rgb(grown("brick", (320, 640), "repeat"))[:, 400:])


def pixel_by_pixel() -> np.ndarray:
    """Gravel grown by the three methods that go pixel by pixel."""
    gravel = np.ascontiguousarray(ia.read("sample:gravel").base.pixels[:128, :128])
    methods = ia.EfrosLeung(window=15), ia.WeiLevoy(), ia.Ashikhmin()
    return beside(rgb(gravel), *(rgb(ia.synthesize(gravel, 192, m, seed=1, wrap="both")) for m in methods))


def window_sizes() -> np.ndarray:
    """Windows too small, and large enough for a brick."""
    brick = np.ascontiguousarray(ia.read("sample:brick").base.pixels[::4, ::4])
    return beside(rgb(brick), *(rgb(ia.synthesize(brick, 192, ia.EfrosLeung(window=n), seed=2)) for n in (5, 11, 23)))


PICTURES = {
    "hero": hero,
    "photographs": photographs,
    "baseline": baseline,
    "patches": patches,
    "map": map_of,
    "feathers": feathers,
    "repetition": repetition,
    "repeat": repeat,
    "pixels": pixel_by_pixel,
    "windows": window_sizes,
}


def main() -> None:
    """Write all pictures."""
    FOLDER.mkdir(exist_ok=True)
    for name, make in PICTURES.items():
        path = FOLDER / f"{name}.jpg"
        Image.fromarray(make()).save(path, quality=86, optimize=True)
        print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
