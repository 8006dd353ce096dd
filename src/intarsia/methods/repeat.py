"""Plain repetition of the exemplar, for pictures that are tileable already.

Source: no paper. Cost: negligible.
"""

from __future__ import annotations

from dataclasses import dataclass

from . import EndlessBase, abilities


@dataclass(frozen=True)
class Repeat(EndlessBase):
    """Repeat the exemplar side by side; it has no parameters."""

    slug = "repeat"
    paper = "none"
    summary = "the exemplar again and again"
    engine = "intarsia.regular.repeat"
    supports = abilities("window")
