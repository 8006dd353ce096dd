"""The figures of the fragments on segments that show synthesis from a texture."""

from __future__ import annotations

import time
from typing import Any

import intarsia as ia
from intarsia.published.segments.engine import published_segments
from intarsia.search import elements
from intarsia.tasks.drawings import segment_overlay

from .figures import Figure, Panel, Way, given, synthesized

TITLE = "Fragments on patch-based synthesis by segments"
AS_THERE = {"energy": "sum", "layout": "raster", "points": 1, "repeat_penalty": 0.0}


def found(exemplar: ia.Exemplar) -> list[Panel]:
    """Figure 1: the segments, and patch size and boundary zone that follow from them."""
    begun = time.perf_counter()
    segments = published_segments(exemplar, "sum")
    values = {"s": time.perf_counter() - begun, "a": float(segments.patch), "b": float(segments.zone)}
    values["elements"] = segments.patch / elements(exemplar).size
    return [given(exemplar), Panel(segments.why, ia.Plane(segment_overlay(exemplar, segments)), values, "< 2 s")]


def patches(**more: Any) -> Way:
    """Return a panel of 512 px by segments, with the source's settings except for those given."""
    return synthesized(512, "segment-based", AS_THERE | more)


def sizes(exemplar: ia.Exemplar) -> list[Panel]:
    """Figure 2: a patch that is too small, and one that is too large."""
    a = published_segments(exemplar, "sum").patch
    return [given(exemplar), patches(patch=max(a // 4, 4))(exemplar), patches(patch=2 * a)(exemplar)]


def results(exemplar: ia.Exemplar) -> list[Panel]:
    """Figures 3 and 4: the texture, synthesized with the sizes found."""
    made = patches()(exemplar)
    side, wide = published_segments(exemplar, "sum").patch - 1, 100 * ia.SegmentBased.hits
    share = wide / ((exemplar.height - side) * (exemplar.width - side))
    return [made._replace(values=made.values | {"compared": share})]


QUICK = "Textures are grown in seconds: few patches are compared, those with alike histograms."
FIGURES = (
    Figure("1", "The segments of the main feature tell patch size and boundary zone.", found, "elements 0.5 b 2"),
    Figure("2", "Too small a patch misses the structure, too large a one repeats.", sizes, "seams c b; most b c"),
    *(
        Figure(number, QUICK, results, "compared c 5", usual, "c")
        for number, usual in (("3", "sample:pebbles"), ("4", "sample:stones"))
    ),
)
