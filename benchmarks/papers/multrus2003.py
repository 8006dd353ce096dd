"""The figures of Multrus 2003 that show synthesis from a texture.

Panels that begin with the same block in the thesis begin with the same seed here.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.ndimage import minimum_filter
from scipy.signal import fftconvolve

import intarsia as ia
from intarsia.analysis.features import transformed
from intarsia.tasks.completion import extended

from .figures import Figure, Panel, Way, cropped, given, listed, log_plot, row, shaded, synthesized

TITLE = "Multrus 2003, Texture Synthesis Using Patch Based Sampling"
TILES, GRASS, GRAVEL = "sample:tiles", "sample:grass", "sample:gravel"
AS_THERE = {"search": "exact", "repetition": "none", "channel_weights": (1.0,)}
ALIKE = {"boundary_patch": 0, "boundary_isometries": "none", "boundary_tolerance": 10_000, "boundary_join": "same"}
PYRAMID = {"pyramid": "mean", "pyramid_draws": "every"}


def patches(size: Any, printed: str = "", feather: Any = None, start: Any = None, guide: Any = None,
            **more: Any) -> Way:  # fmt: skip
    """Return a panel by patch-based sampling, with the source's settings except for those given."""
    settings = {"patch": 25, "overlap": 5, **more}
    way = synthesized(size, "patch-sampling", AS_THERE | settings, printed, feather, start=start, guide=guide)
    return lambda e: way(e)._replace(told=listed(settings))


def by_pixels(columns: int, printed: str) -> Way:
    """Return a panel synthesized pixel by pixel."""
    return synthesized(200, "wei-levoy", {"matching": "exact", "noise": "white", "window": (3, columns)}, printed)


def isometries(size: int | None, *printed: str, **more: Any) -> list[Way]:
    """Return panels with larger and larger sets of isometries."""
    ways = zip(("none", "180", "90", "both"), printed, strict=True)
    return [patches(size, seconds, isometries=kind, **more) for kind, seconds in ways]


REPETITIONS = row(
    given, patches(300, "73 s", candidates=1), patches(300, "73 s", candidates=1, repetition="counter"), side=200
)
"""Without and with the prevention of repetitions."""


def multiresolution(exemplar: ia.Exemplar) -> list[Panel]:
    """Figure 4.9: without and with the pyramid."""
    e = cropped(exemplar, 200)
    made = row(patches(200, "33.4 s"), patches(200, "1.0 s", **PYRAMID))(e)
    _, *work = laws(np.array([e.width])).values()
    counted = zip(made, work, strict=True)
    return [given(e), *(panel._replace(values=panel.values | {"differences": float(n[0])}) for panel, n in counted)]


def laws(side: np.ndarray) -> dict[str, np.ndarray]:
    """Return the pixel differences per output pixel for square inputs, by the formulas of 2.3, 3.4 and 4.3.2."""

    def searched(places: Any, n: int) -> Any:
        """Return the cost of `places` blocks along each axis, n times smaller than 25 px with seams of 5 px."""
        return places**2 * 2 * (5 // n) * (25 // n + 2 * (5 // n)) / 35**2

    around = searched(36, 1) + searched(17, 2)  # what fits into an area of twice the block's side
    return {
        "pixels": side**2 * (12 * 25 + 13), "blocks": searched(side - 34, 1),
        "pyramid": searched(side // 4 - 7, 4) + around,
    }  # fmt: skip


def costs(exemplar: ia.Exemplar, curves: int) -> list[Panel]:
    """Figures 2.4, 3.8 and 4.8: the cost formulas over the side of the input; the gain by the last of them."""
    side = np.arange(64, 513)
    drawn = dict([*laws(side).items()][:curves])
    *before, last = drawn.values()
    values = {"growth": last[-1] / last[0], "gain": before[-1][-1] / last[-1] if before else 1.0}
    return [Panel("differences for a pixel, input of 64 to 512 px", log_plot(side, drawn), values)]


def farness(pixels: np.ndarray, block: np.ndarray, poses: Sequence[int]) -> Any:
    """Return the RMS distance of the seam above and left of a block to that of every block, in its best pose."""
    known = np.ones((*block.shape[:2], 1))
    known[5:, 5:] = 0
    squares, maps = (pixels**2).sum(axis=2), []
    for pose in poses:
        mask, part = transformed(known, pose), transformed(block * known, pose)
        across = fftconvolve(pixels, part[::-1, ::-1], "valid", axes=(0, 1)).sum(axis=2)
        maps.append(fftconvolve(squares, mask[::-1, ::-1, 0], "valid") - 2 * across + (part**2).sum())
    return np.sqrt(np.maximum(np.min(maps, axis=0), 0) / known.sum())


def maps(exemplar: ia.Exemplar, *ways: Sequence[int]) -> list[Panel]:
    """Figures 3.12 and 4.2: distances of all blocks to the next one of a partial synthesis, each in its best pose.

    The part above and left of the next block is made on canvases that end there. `ways`: the poses of each panel.
    `periodic`: the highest correlation of a map with itself, moved by a third of a block or more, and by no more than
    half of the map.
    """
    e = cropped(exemplar, 150)
    above, left = row(patches((90, 200)), patches((200, 90)))(e)
    begun = np.zeros((120, 200, *above.picture.samples.shape[2:]), above.picture.samples.dtype)
    begun[:90], begun[90:, :90] = above.picture.samples, left.picture.samples[90:120]
    found = [farness(e.base.samples.astype(np.float64), begun[85:, 85:120] * 1.0, poses) for poses in ways]
    panels, ends = [above._replace(picture=ia.Plane(begun))], [*map(np.min, found), *map(np.max, found)]
    for poses, far in zip(ways, found, strict=True):
        low = (far == minimum_filter(far, 9)) & (far < (far.min() + np.median(far)) / 2)
        values = {"mean": float(far.mean()), "minima": float(low.sum()), "periodic": periodic(far)}
        panels.append(Panel(f"distances, isometries {poses}", ia.Plane(shaded(far, min(ends), max(ends))), values))
    return panels


def periodic(values: np.ndarray) -> float:
    """Return the highest autocorrelation of a map at shifts of 12 px or more, and of at most half its size."""
    around = [2 * n for n in values.shape]
    power = [np.abs(np.fft.rfft2(v, around)) ** 2 for v in (values - values.mean(), np.ones(values.shape))]
    moved, shared = (np.fft.irfft2(p, around) for p in power)
    steps = np.maximum.outer(*(np.abs(np.fft.fftfreq(2 * n, 1 / (2 * n))) for n in values.shape))
    there = (steps >= 12) & (steps <= min(values.shape) / 2)
    return float((moved[there] / shared[there]).max() / values.var())


def continued(exemplar: ia.Exemplar) -> list[Panel]:
    """Figures 4.1 and 5.1: the input is extended to the right, with larger and larger sets of isometries."""
    e = cropped(exemplar, 150)
    start = extended((e.source,), 0, ia.Margins(right=e.width))
    ways = isometries(None, "9 s", "23 s", "30 s", "45 s", start=start, candidates=2)
    return row(given, *ways)(e)


def avoided(exemplar: ia.Exemplar) -> list[Panel]:
    """Figure 5.2: a corner of the input is masked, and must not appear in the output."""
    pixels = exemplar.base.samples[:300, :300].copy()
    usable = np.ones(pixels.shape[:2], bool)
    usable[:50, :50] = False
    pixels[~usable] = 0
    made = patches(300, "243 s")(ia.Exemplar.of(pixels, usable=usable))
    return [made._replace(values=made.values | {"marked": (made.picture.samples == 0).all(axis=2).sum()})]


def labelled(exemplar: ia.Exemplar, side: int, dark: float, printed: dict[float, str], **more: Any) -> list[Panel]:
    """Figures 5.5 to 5.8: a disc of labels is filled from two regions, one darker; alpha weighs the guide."""
    side = min(side, exemplar.height, exemplar.width)
    y, x = np.mgrid[:side, :side]
    there, here = x > side / 2 + side / 20 * np.sin(y / 12), np.hypot(y - side / 2, x - side / 2) < side / 3
    pixels = exemplar.base.samples[:side, :side]
    two = ia.Exemplar.of(np.where(there[..., None], pixels * dark, pixels).astype(pixels.dtype))
    source, target = (ia.Plane(marks.astype(np.uint8), ia.Kind.LABEL) for marks in (there, here))
    more = {"isometries": "both"} | ALIKE | more
    panels = [given(two), Panel("labels", ia.Plane(shaded(here * 1)))]
    for alpha, seconds in printed.items():
        made = patches(side, seconds, guide=ia.Guide(source, target, alpha), **more)(two)
        panels.append(made._replace(told=f"alpha {alpha}"))
    return panels


def painted(number: str, claim: str, rising: str, side: int, dark: float, **more: Any) -> Figure:
    """Figures 5.5 to 5.8."""
    return Figure(number, claim, partial(labelled, side=side, dark=dark, **more), rising, GRAVEL, "acdefgh")


FIGURES = (
    Figure("2.4", "The work grows with the size of the input.", partial(costs, curves=1), "growth 60 a"),
    Figure("3.8", "Blocks take clearly less of it than pixels.", partial(costs, curves=2), "gain 10 a"),
    Figure("4.8", "The pyramid takes clearly less than blocks.", partial(costs, curves=3), "gain 10 a"),
    Figure(
        "2.5", "Pixel by pixel; a larger neighbourhood keeps larger structures.",
        row(given, by_pixels(7, "> 2100 s"), by_pixels(9, "2780 s"), side=128), "whole b c",
    ),
    Figure(
        "3.4", "Without blending block boundaries can easily be recognized.",
        row(given, patches(200, feather=0), patches(200)), "sharp c b",
    ),
    Figure(
        "3.6", "Small patches lose the structure, large ones leave little interaction.",
        row(given, *(patches(200, patch=n, overlap=4) for n in (5, 25, 45, 100))), "seams e d c b", TILES,
    ),
    Figure(
        "3.7", "Narrow seams match badly, 5 px are best, wide ones bring errors by blending.",
        row(given, *(patches(200, overlap=n) for n in (1, 3, 5, 10, 20))), "seams d b; sharp f d",
    ),
    Figure(
        "3.12", "A stochastic texture has few places that fit ...",
        lambda e: maps(e, (0,)), "minima c 4; periodic c 0.5", GRASS, "bc",
    ),
    Figure(
        "3.12d", "... a regular one many, which repeat.",
        lambda e: maps(e, (0,)), "minima 4 c; periodic 0.5 c", TILES, "bc",
    ),
    Figure(
        "4.1", "Isometries continue an arc otherwise than by the same piece (b is figure 5.1).",
        continued, "most e b", GRAVEL,
    ),
    Figure(
        "4.2", "With isometries many blocks come nearer.",
        lambda e: maps(e, (0,), (0, 1, 2, 6), (0, 3, 4, 5, 7), tuple(range(8))),
        "mean f d c; mean f e c", GRASS, "bcdef",
    ),
    Figure(
        "4.3", "Isometries lead to an improved variability.",
        row(given, *isometries(200, "17 s", "46 s", "57 s", "83 s"), side=150), "whole e b",
    ),
    Figure("4.5", "With the prevention of repetitions there are less noticeable ones.", REPETITIONS,
           "most c b; shown b c"),
    Figure("4.6", "On a regular texture it makes the result slightly worse.", REPETITIONS, "seams b c", TILES),
    Figure("4.9", "By the pyramid far fewer differences are taken, at equal quality if stochastic.", multiresolution,
           "differences c b"),
    Figure("4.10", "On a regular texture the pyramid joins blocks worse.", multiresolution, "seams b c", TILES),
    Figure("5.2", "What is marked is avoided.", avoided, "marked c 1", letters="c"),
    painted("5.5", "The more alpha, the better the boundary, and the worse the seams.", "agree d e f; seams f g h",
            150, 0.4, printed={0.5: "50 s", 1: "51 s", 2: "50 s", 3: "49 s", 5: "51 s"}, patch=7, overlap=4),
    painted("5.6", "A smooth boundary is followed, quickly by the pyramid.", "agree 97 d",
            300, 0.9, printed={1: "35 s"}, **PYRAMID),
    painted("5.7", "A boundary of strong contrast is met only where the input has one like it.", "agree d 99",
            300, 0.4, printed={2: "598 s"}, patch=10, boundary_candidates=2),
    painted("5.8", "Without alpha the boundary is free, and the seams are better.", "agree e d; seams e d",
            256, 0.4, printed={1.5: "559 s", 0: "560 s"}, patch=7, overlap=4),
)  # fmt: skip
