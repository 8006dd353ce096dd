"""What the memorandum says of its settings, shown with several values of each; it has no figures of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...model import Exemplar
from ..figures import Figure, Panel, given, grown, row

TITLE = "Memorandum of 2008 on the correction operation"
USUAL = "sample:pebbles"
AS_THERE = {"snap": "off", "channel_weights": (1.0,), "jitter": 0.3}


def varied(name: str, *values: Any) -> Callable[[Exemplar], list[Panel]]:
    """The same texture with several values of one setting."""
    ways = zip("bcd", values, strict=True)
    return row(given, *(grown(k, 200, "correction-2008", AS_THERE | {name: value}) for k, value in ways))


FIGURES = (
    Figure(
        "1", "The penalty favours the proximity set, so pieces are larger; at infinity the jump set is left out.",
        varied("kappa", 1.0, 1.5, "inf"), USUAL, "whole b c; whole b d",
    ),
    Figure(
        "2", "A jump set leads to pixels that fit better than those of the proximity set alone, so seams cost less.",
        varied("k", 1, 2, 4), USUAL, "seams c b; seams d b",
    ),
    Figure(
        "3", "Each pixel is replaced by what fits better, so every pass leaves fewer breaks.",
        varied("passes", 0, 1, 3), USUAL, "whole b c d",
    ),
    Figure(
        "4", "The mask takes away smoothness: the middle counts more (b: 5 x 5 alike, c: a Gaussian, d: 3 x 3).",
        varied("neighbourhood_mask", (1.0,) * 25, None, (0.5, 0.7, 0.5, 0.7, 1.0, 0.7, 0.5, 0.7, 0.5)),
        USUAL, "sharp b c d",
    ),
)  # fmt: skip
