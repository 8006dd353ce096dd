"""The figures of Lopez Recas 2011 that show synthesis from a near-regular texture."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.ndimage import binary_dilation

import intarsia as ia
from intarsia.analysis.elements import autocorrelation
from intarsia.analysis.features import features
from intarsia.published.lopez_recas2011.goodness import lattice_by_goodness
from intarsia.published.lopez_recas2011.goodness_kernels import ALPHA, MILLION, significant_sum
from intarsia.regular.tile_search import best_tile

from .figures import Figure, Panel, Way, given, row, shaded, synthesized

TITLE = "Lopez Recas 2011, Constrained Random Sampling and Gap Filling for Near-regular Texture Synthesis"
USUAL = "sample:tiles"
SIZE = 400


def blocks(feather: int = 4, **more: Any) -> Way:
    """Return a panel by random sampling and gap filling, with the source's settings except for those given."""
    settings = {"detector": "goodness", "channel_weights": (1.0,)} | more
    return synthesized(SIZE, "gap-filling", settings, feather=feather)


def tile(exemplar: ia.Exemplar) -> Panel:
    """Make a panel of the best tile, repeated."""
    return synthesized(SIZE, "best-tile", {"lattice": lattice_by_goodness(exemplar, (1.0,))})(exemplar)


quilted = synthesized(SIZE, "raster-quilting", {"patch": 50, "overlap": 10})
"""A panel by image quilting, with blocks of the same size: 50 px, 10 px of overlap."""


def vectors(exemplar: ia.Exemplar) -> np.ndarray:
    """Return the lattice of best goodness, rows (dy, dx) in px."""
    return np.array(lattice_by_goodness(exemplar, (1.0,)), int)[:, ::-1]


def goodness(exemplar: ia.Exemplar) -> list[Panel]:
    """Figure 3.5: the autocorrelation, the lattice points of three pairs of vectors marked, and the pairs' goodness."""
    picture, found = features([exemplar], (1.0,)).pictures[0], vectors(exemplar)
    correlation, _ = autocorrelation(picture)
    panels, values = [given(exemplar)], np.rint(MILLION * correlation).astype(np.int32)
    for pair in (found, 2 * found, found // 2):
        total, count = significant_sum(values, *pair, *picture.shape[:2])
        drawn, marks = shaded(correlation), np.zeros(values.shape)
        crosses = (np.mgrid[-20:21, -20:21].T @ pair).reshape(-1, 2) + np.array(values.shape) // 2
        inside = crosses[((crosses >= 0) & (crosses < values.shape)).all(axis=1)]
        marks[*inside.T] = 1
        drawn[binary_dilation(marks, iterations=3)] = 0
        good = {"goodness": (max(total, 0) / MILLION) ** ALPHA / max(count, 1)}
        panels.append(Panel(f"{pair.tolist()}", ia.Plane(drawn), good))
    return panels


def tile_costs(exemplar: ia.Exemplar) -> list[Panel]:
    """Figure 4.6: border cost of every tile position; the best tile repeated, and the worst."""
    pair = vectors(exemplar)
    costs = best_tile(features([exemplar], (1.0,)).pictures[0], (256 * pair).tolist()).costs
    known = np.where(costs < 0, np.nan, costs)
    panels, at = [Panel("costs", ia.Plane(shaded(known)))], np.mgrid[:SIZE, :SIZE].T
    inner = at - np.floor(at @ np.linalg.inv(pair)).astype(int) @ pair
    for n in (np.nanargmin(known), np.nanargmax(known)):
        y, x = (inner + np.unravel_index(n, known.shape)).T
        panels.append(Panel("repeated", ia.Plane(exemplar.base.pixels[y, x]), {"cost": known.flat[n]}))
    return panels


def sampled(exemplar: ia.Exemplar) -> list[Panel]:
    """Figure 4.7: the randomly sampled blocks; the gaps are still empty."""
    pixels, (i, j) = blocks(0)(exemplar).picture.pixels.copy(), np.mgrid[:SIZE, :SIZE] // 40
    pixels[(i + j) % 2 == 1] = 0
    return [Panel("every second block", ia.Plane(pixels))]


def failures(exemplar: ia.Exemplar) -> list[Panel]:
    """Figure 5.1: tiles of irregular and of regular colours, and bent ones; area of the tile found, in true tiles."""
    upright = np.mgrid[:180, :180]
    y, x = upright
    bent = upright + 6 * np.sin([x / 23 + y / 61 + 1, y / 27 + x / 57])
    i, j = upright // 18
    drawn = (i * i * 7919 + i * j * 31 + j * j * 4729) % 181 + 60
    tiles = (drawn, upright, 324), (150 - 16 * ((i + j) % 2), upright, 648), (150 - 16 * (j % 2), upright, 648)
    panels = []
    for shade, lines, true in (*tiles, (170, bent, 324)):
        plane = ia.Plane(np.where((lines % 18 < 2.5).any(axis=0), 40, shade).astype(np.uint8))
        pair = vectors(ia.Exemplar.of(plane.pixels))
        panels.append(Panel(f"{pair.tolist()}", plane, {"tiles": abs(np.linalg.det(pair)) / true}))
    return panels


FIGURES = (
    Figure(
        "3.5", "Of pairs of vectors the tile itself is best, not a larger or a smaller one.",
        goodness, "goodness c b; goodness d b", USUAL,
    ),
    Figure("4.6", "The best tile repeats smoothly, the worst with seams.", tile_costs, "cost c d", USUAL, "acd"),
    Figure("4.7", "Blocks are drawn among those in the same place of the lattice.", sampled, usual=USUAL),
    Figure(
        "4.10", "By correlation a little more blocky, by differences sharp edges fit a little worse.",
        row(blocks(fit="correlation"), blocks(fit="difference")), "seams b a", USUAL,
    ),
    Figure(
        "4.11", "Random sampling introduces irregularities without visible repetitions.",
        row(given, tile, blocks(0)), "shown b c; most c b", USUAL,
    ),
    Figure(
        "4.13", "The result after transitions have been smoothed.", row(blocks(0), blocks()), "sharp b a", USUAL,
    ),
    Figure(
        "5.1", "Irregular colours give too large a tile (a), regular ones half one (c, d), bent tiles a wrong one (f).",
        failures, "tiles 1.1 a; tiles c 0.9; tiles d 0.9; tiles 1.1 f", USUAL, "acdf",
    ),
    Figure(
        "5.2", "Near-regular textures are better synthesized so than by other approaches.",
        row(given, tile, blocks(), quilted), "shown b c; seams c d", USUAL,
    ),
    Figure(
        "5.12", "A wider blending area reduces the blocky appearance.", row(blocks(), blocks(28)), "sharp b a", USUAL,
    ),
    Figure(
        "5.13", "Irregular textures grow with the vectors 1,0 and 0,1.",
        row(given, blocks(lattice=((1.0, 0.0), (0.0, 1.0))), quilted),
    ),
)  # fmt: skip
