"""Plain repetition: the exemplar again and again; right for a picture that is already tileable.

No paper; the yardstick for repetition. Cost: none to speak of.
"""

from __future__ import annotations

from dataclasses import dataclass

from . import EndlessBase, abilities


@dataclass(frozen=True)
class Repeat(EndlessBase):
    """Repeat the exemplar side by side."""

    slug = "repeat"
    paper = "none"
    summary = "the exemplar again and again"
    engine = "intarsia.regular.repeat"
    supports = abilities("start", "window")
