"""Remake the pictures of docs/painting.md from built-in exemplars: ``python docs/make_painting_pictures.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import distance_transform_edt, gaussian_filter
from skimage import data

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP, SIDE = 12, 300


def tinted(name: str, tint: tuple[float, float, float]) -> np.ndarray:
    """A gray photograph in a colour."""
    gray = np.asarray(ia.read(f"sample:{name}").base).reshape(512, 512)[:SIDE, :SIDE]
    return np.clip(gray[:, :, None] * np.array(tint), 0, 255)


def path_and_lawn() -> tuple[np.ndarray, np.ndarray]:
    """An exemplar with two regions, gravel in grass with a dark rim, and its labels."""
    y, x = np.mgrid[:SIDE, :SIDE]
    inside = np.sin(x / 23 + 1) * 22 + np.sin(y / 31) * 24 + 0.35 * x - 0.2 * y > 20
    shade = np.clip(distance_transform_edt(inside) / 5, 0.3, 1)[:, :, None]
    path, lawn = tinted("gravel", (1.1, 1.0, 0.85)) * shade, tinted("grass", (0.8, 1.15, 0.5))
    return np.where(inside[:, :, None], path, lawn).astype(np.uint8), inside.astype(np.uint8)


def coloured(marks: np.ndarray) -> np.ndarray:
    """Labels as colours."""
    return np.array([(230, 200, 120), (60, 90, 160), (150, 60, 60)], np.uint8)[marks]


def beside(*pictures: np.ndarray) -> np.ndarray:
    """Pictures side by side on white."""
    height = max(p.shape[0] for p in pictures)
    out = np.full((height, sum(p.shape[1] + GAP for p in pictures) - GAP, 3), 255, np.uint8)
    x = 0
    for p in pictures:
        out[: p.shape[0], x : x + p.shape[1]] = p
        x += p.shape[1] + GAP
    return out


def labels(marks: np.ndarray) -> ia.Plane:
    """Numbers as a plane of labels."""
    return ia.Plane(marks, ia.Kind.LABEL)


def ring() -> np.ndarray:
    """One exemplar, its labels, a target, and what is painted."""
    pixels, marks = path_and_lawn()
    y, x = np.mgrid[:SIDE, :SIDE] - SIDE / 2
    r = np.hypot(y, x) + 8 * np.sin(3 * np.arctan2(y, x))
    target = ((r > 60) & (r < 115)).astype(np.uint8)
    out = ia.synthesize(pixels, None, seed=2, guide=ia.Guide(labels(marks), labels(target)))
    return beside(pixels, coloured(marks), coloured(target), np.asarray(out))


def three() -> np.ndarray:
    """Three exemplars of one label each: they never meet, so they are cut at the boundary."""
    y, x = np.mgrid[:SIDE, : SIDE * 3 // 2]
    target = np.zeros(y.shape, np.uint8)
    target[y > 120 + 25 * np.sin(x / 50)] = 1
    target[y > 210 + 18 * np.sin(x / 35 + 2)] = 2
    exemplars = [ia.read(f"sample:{n}") for n in ("pebbles", "planks", "stones")]
    sources = [labels(np.full((e.height, e.width), k, np.uint8)) for k, e in enumerate(exemplars)]
    out = ia.synthesize(exemplars, None, seed=2, guide=ia.Guide(sources, labels(target)))
    return beside(coloured(target), np.asarray(out)[:, :, :3])


def corrected() -> np.ndarray:
    """Strokes of 6 to 20 px in the exemplar of the ring, and a photograph in pebbles, both pixel by pixel."""
    pixels, marks = path_and_lawn()
    y, x = np.mgrid[:SIDE, :SIDE]
    strokes = np.zeros((SIDE, SIDE), np.uint8)
    for k, width in enumerate((6, 10, 14, 20)):
        strokes[abs(y - 45 - 70 * k - 14 * np.sin(x / 30 + k)) < width / 2] = 1
    method = ia.ParallelControllable()
    first = ia.synthesize(pixels, None, method, seed=2, guide=ia.Guide(labels(marks), labels(strokes)))

    pebbles = np.asarray(ia.read("sample:pebbles").base)[:, :, :3]
    tones = gaussian_filter(pebbles @ [0.299, 0.587, 0.114], 2)
    picture = np.asarray(Image.fromarray(data.camera()[20:340, 80:400]).resize((SIDE, SIDE))).astype(float)
    ranks = np.argsort(np.argsort(picture, axis=None)).reshape(SIDE, SIDE) / SIDE**2
    source, target = (ia.Plane(p.astype(np.uint8)) for p in (tones, np.quantile(tones, ranks)))
    second = ia.synthesize(pebbles, None, method, seed=2, guide=ia.Guide(source, target, 3.0))
    return beside(coloured(strokes), np.asarray(first), picture[:, :, None].repeat(3, 2), np.asarray(second))


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, make in (("painting-ring", ring), ("painting-three", three), ("painting-corrected", corrected)):
        Image.fromarray(make()).save(FOLDER / f"{name}.jpg", quality=88)
