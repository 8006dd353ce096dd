"""Plain repetition: the exemplar again and again; right for a picture that is already tileable.

No paper; the yardstick for repetition. Cost: none to speak of.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from . import Ability, EndlessBase


@dataclass(frozen=True)
class Repeat(EndlessBase):
    """Repeat the exemplar side by side."""

    slug: ClassVar[str] = "repeat"
    paper: ClassVar[str] = "none"
    summary: ClassVar[str] = "the exemplar again and again"
    engine: ClassVar[str] = "intarsia.regular.repeat"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.START, Ability.WINDOW})
