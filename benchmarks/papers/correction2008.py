"""Claims of the memorandum on its settings, each shown with several values; it has no figures of its own."""

from __future__ import annotations

from typing import Any

from .figures import Figure, Panels, given, row, synthesized

TITLE = "Memorandum of 2008 on the correction operation"
AS_THERE = {"keep_lattice": "off", "channel_weights": (1.0,), "jitter": 0.3}


def varied(name: str, *values: Any) -> Panels:
    """Return the panels of one texture with several values of one setting."""
    return row(given, *(synthesized(200, "correction-2008", AS_THERE | {name: value}) for value in values))


FIGURES = (
    Figure(
        "1", "The penalty favours the proximity set, so pieces are larger; at infinity the jump set is left out.",
        varied("kappa", 1.0, 1.5, "inf"), "whole b c; whole b d",
    ),
    Figure(
        "2", "A jump set leads to pixels that fit better than those of the proximity set alone, so seams cost less.",
        varied("k", 1, 2, 4), "seams c b; seams d b",
    ),
    Figure(
        "3", "Each pixel is replaced by what fits better, so every pass leaves fewer breaks.",
        varied("passes", 0, 1, 3), "whole b c d",
    ),
    Figure(
        "4", "The mask takes away smoothness: the middle counts more (b: 5 x 5 alike, c: a Gaussian, d: 3 x 3).",
        varied("neighbourhood_mask", (1.0,) * 25, None, (0.5, 0.7, 0.5, 0.7, 1.0, 0.7, 0.5, 0.7, 0.5)), "sharp b c d",
    ),
)  # fmt: skip
