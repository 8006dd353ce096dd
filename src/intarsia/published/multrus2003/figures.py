"""The figures of Multrus 2003 that are grown from a texture, one function each.

Panels that begin with the same block there begin with the same seed here.
"""

from __future__ import annotations

from typing import Any

from ...exemplar import Exemplar
from ..figures import Figure, Panel, cropped, given, grown

TITLE = "Multrus 2003, Texture Synthesis Using Patch Based Sampling"
PEBBLES = "sample:pebbles"
AS_THERE = {"search": "exact", "repetition": "none", "channel_weights": (1.0,)}
ISOMETRIES = {"b": "none", "c": "180", "d": "90", "e": "both"}


def patches(letter: str, exemplar: Exemplar, size: Any, printed: str = "", feather: Any = None, **more: Any) -> Panel:
    """A panel by patch-based sampling, with the source's settings but for those that are given."""
    settings = {"patch": 25, "overlap": 5, **more}
    panel = grown(letter, exemplar, size, "patch-sampling", AS_THERE | settings, printed, feather)
    return panel._replace(told=", ".join(f"{name} {value}" for name, value in settings.items()))


def pixel_results(exemplar: Exemplar) -> list[Panel]:
    """Figure 2.5: pixel by pixel, with two neighbourhoods."""
    e, ways = cropped(exemplar, 128), {"matching": "exact", "noise": "white"}
    low = grown("b", e, 200, "wei-levoy", ways | {"window": (3, 7)}, "> 2100 s")
    return [given(e), low, grown("c", e, 200, "wei-levoy", ways | {"window": (3, 9)}, "2780 s")]


def blending(exemplar: Exemplar) -> list[Panel]:
    """Figure 3.4: blocks without and with blending."""
    return [given(exemplar), patches("b", exemplar, 200, feather=0), patches("c", exemplar, 200)]


def patch_sizes(exemplar: Exemplar) -> list[Panel]:
    """Figure 3.6: patches of 5, 25, 45 and 100 px."""
    sizes = {"b": 5, "c": 25, "d": 45, "e": 100}
    return [given(exemplar), *(patches(k, exemplar, 200, patch=n, overlap=4) for k, n in sizes.items())]


def seam_sizes(exemplar: Exemplar) -> list[Panel]:
    """Figure 3.7: seams of 1, 3, 5, 10 and 20 px."""
    sizes = {"b": 1, "c": 3, "d": 5, "e": 10, "f": 20}
    return [given(exemplar), *(patches(k, exemplar, 200, overlap=n) for k, n in sizes.items())]


def isometries(exemplar: Exemplar) -> list[Panel]:
    """Figure 4.3: categories of isometries."""
    e, printed = cropped(exemplar, 150), dict(zip("bcde", ("17 s", "46 s", "57 s", "83 s"), strict=True))
    return [given(e), *(patches(k, e, 200, printed[k], isometries=kind) for k, kind in ISOMETRIES.items())]


def repetitions(exemplar: Exemplar) -> list[Panel]:
    """Figure 4.5: without and with the prevention of repetitions."""
    e = cropped(exemplar, 200)
    without = patches("b", e, 300, "73 s", candidates=1)
    return [given(e), without, patches("c", e, 300, "73 s", candidates=1, repetition="counter")]


def multiresolution(exemplar: Exemplar) -> list[Panel]:
    """Figure 4.9: without and with the pyramid."""
    e = cropped(exemplar, 200)
    coarse = patches("c", e, 200, "1.0 s", pyramid="mean", pyramid_draws="every")
    return [given(e), patches("b", e, 200, "33.4 s"), coarse]


FIGURES = (
    Figure("2.5", "Pixel based synthesis. Results.", pixel_results, PEBBLES),
    Figure("3.4", "Without blending block boundaries can easily be recognized.", blending, PEBBLES),
    Figure("3.6", "Small patches lose the structure, large ones leave little interaction.", patch_sizes, PEBBLES),
    Figure("3.7", "Narrow seams match badly, 5 px are best, wide ones bring errors by blending.", seam_sizes, PEBBLES),
    Figure("4.3", "Isometries lead to an improved variability, in several times the time.", isometries, PEBBLES),
    Figure("4.5", "With the prevention of repetitions there are less noticeable ones.", repetitions, PEBBLES),
    Figure("4.9", "By the pyramid 30 times as fast, of equal quality if stochastic.", multiresolution, PEBBLES),
)
