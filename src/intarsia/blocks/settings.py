"""The parameters that layouts of lattice blocks read from a method."""

from __future__ import annotations

from typing import Protocol


class LatticeSettings(Protocol):
    """The parameters that every layout of lattice blocks reads."""

    @property
    def lattice(self) -> tuple[tuple[float, float], ...] | None:
        """The lattice vectors, (x, y) px."""

    @property
    def block(self) -> int | None:
        """The wanted side of a block, px."""

    @property
    def border(self) -> int | None:
        """Width of the zone in which gaps are compared and cut in, px."""

    @property
    def slack(self) -> int:
        """How far a gap's block may leave the lattice, px."""

    @property
    def channel_weights(self) -> tuple[float, ...] | None:
        """How much each channel counts."""


class Settings(LatticeSettings, Protocol):
    """The parameters that a mosaic reads, too."""

    @property
    def bend(self) -> int:
        """How far parts of a gap's block may move so that lines meet, px."""

    @property
    def isometries(self) -> str | tuple[int, ...]:
        """Which mirrored and turned blocks may be used."""


class PlainSettings(LatticeSettings, Protocol):
    """The parameters that the plain variant reads, too."""

    @property
    def fit(self) -> str:
        """What fits: "difference" or "correlation"."""
