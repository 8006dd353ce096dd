"""What the plain rule for lattices does on the cases that its source calls failures, and what ours does.

    python benchmarks/lattice_failures.py      the table of docs/sources-001.md
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.lattice import find_lattice
from intarsia.published.lopez_recas2011.goodness import goodness_lattice

SIDE = 180
Vectors = tuple[tuple[float, float], tuple[float, float]]  # rows (dy, dx)


def _tiles(rows: float, columns: float, shear: float, colours: Any, y: Any, x: Any) -> Any:
    """Tiles with dark joints; `colours` (n, n, C) by row and column."""
    i = np.floor(y / rows).astype(int)
    u = x - i * shear
    j = np.floor(u / columns).astype(int)
    joint = (y % rows < 2.5) | (u % columns < 2.5)
    n = len(colours)
    return np.where(joint[..., None], 40, colours[i % n, j % n])


def _finished(picture: Any, noise: float, rng: np.random.Generator) -> Any:
    return np.clip(np.rint(picture + rng.normal(0, noise, picture.shape)), 0, 255).astype(np.uint8)


def irregular_colours(shear: float = 0.0) -> tuple[Any, Vectors]:
    """Colours drawn for every tile of a regular grid."""
    rng = np.random.default_rng(3)
    y, x = np.mgrid[:SIDE, :SIDE].astype(float)
    colours = rng.uniform(60, 240, (40, 40, 3))
    picture = _tiles(18, 24 if shear else 18, shear, colours, y, x)
    return _finished(picture, 3, rng), ((18, shear), (0, 24 if shear else 18))


def regular_colours(columns: bool = False) -> tuple[Any, Vectors]:
    """Every second tile a little darker, as on a chequer board, or every second column."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[:SIDE, :SIDE].astype(float)
    i, j = np.mgrid[:40, :40]
    dark = (j if columns else i + j) % 2
    colours = np.dstack([150 - 16 * dark, 140 - 14 * dark, 120 - 12 * dark]).astype(float)
    picture = _tiles(17, 17, 0, colours, y, x)
    return _finished(picture, 4, rng), ((17, 0), (0, 34)) if columns else ((17, 17), (17, -17))


def two_lattices() -> tuple[Any, Vectors]:
    """Dots on one lattice over tiles of another, that have no multiple in common."""
    rng = np.random.default_rng(7)
    y, x = np.mgrid[:SIDE, :SIDE].astype(float)
    picture = _tiles(26, 26, 0, np.full((1, 1, 3), 170.0), y, x)
    a, b = (0.96 * y + 0.28 * x) / 15.3, (-0.28 * y + 0.96 * x) / 15.3
    dot = np.hypot(a % 1 - 0.5, b % 1 - 0.5) < 0.22
    picture = np.where(dot[..., None], (200, 90, 60), picture)
    return _finished(picture, 3, rng), ((26, 0), (0, 26))


def distorted(noisy: bool = False) -> tuple[Any, Vectors]:
    """A grid bent by up to a third of its pitch, or under noise as strong as itself."""
    rng = np.random.default_rng(9)
    y, x = np.mgrid[:SIDE, :SIDE].astype(float)
    picture = _tiles(18, 18, 0, np.full((1, 1, 3), 170.0), y, x)
    if noisy:
        return _finished(picture, float(picture.std()), rng), ((18, 0), (0, 18))
    bend = 6 * np.sin(np.array([x / 23 + 1, y / 27]) + np.array([y / 61, x / 57]))
    bent = [map_coordinates(picture[..., c], [y + bend[0], x + bend[1]], order=1, mode="reflect") for c in range(3)]
    return _finished(np.dstack(bent), 3, rng), ((18, 0), (0, 18))


CASES: dict[str, Callable[[], tuple[Any, Vectors]]] = {
    "a: irregular colours on a grid": irregular_colours,
    "b: the same, in running bond": lambda: irregular_colours(12.0),
    "c: regular colours, chequered": regular_colours,
    "d: regular colours, in columns": lambda: regular_colours(True),
    "e: two lattices, no common multiple": two_lattices,
    "f: bent by a third of the pitch": distorted,
    "f: noise as strong as the grid": lambda: distorted(True),
}


def judged(found: Any, truth: Vectors) -> str:
    """Say how lattice vectors (n, 2) in px, or None, compare with the true ones."""
    if found is None:
        return "refused"
    if len(found) == 1:
        return "one vector " + words(found)
    cells = abs(np.linalg.det(found)) / abs(np.linalg.det(np.array(truth, float)))
    times = found @ np.linalg.inv(np.array(truth, float))
    off = float(np.hypot(*((times - np.rint(times)) @ np.array(truth, float)).T).max())
    if off <= 1.0 and round(cells) >= 1:
        return f"true, {off:.2f} px off" if round(cells) == 1 else f"{round(cells)} true cells, {off:.2f} px off"
    return f"not the true one, {cells:.2f} cells: " + words(found)


def words(found: Any) -> str:
    """The vectors, x,y px."""
    return " ".join(f"{x:.1f},{y:.1f}" for y, x in found)


def answers(name: str) -> tuple[str, str, float]:
    """What the plain rule finds, what ours finds, and the confidence of ours."""
    pixels, truth = CASES[name]()
    picture = features([ia.Exemplar.of(pixels)]).pictures[0]
    ours = find_lattice(picture)
    accepted = None if ours.accepted is None else ours.accepted.pixels
    confidence = ours.ranked[0].confidence if ours.ranked else 0.0
    return judged(goodness_lattice(picture), truth), judged(accepted, truth), confidence


def main() -> None:
    """Print the table."""
    print("| case | plain rule of the source | ours | confidence |\n|---|---|---|---|")
    for name in CASES:
        plain, ours, confidence = answers(name)
        print(f"| {name} | {plain} | {ours} | {confidence:.2f} |")


if __name__ == "__main__":
    main()
