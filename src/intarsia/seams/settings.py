"""How patches are placed and joined where seams are searched for."""

from __future__ import annotations

from dataclasses import dataclass

from ..lattice.vectors import Vector


@dataclass(frozen=True)
class GraphcutSettings:
    """How patches are placed and joined.

    Attributes
    ----------
    usage : float
        Price of a repeat, in usual distances.
    seam : str
        ``difference``: a seam costs what the colours that meet there differ; ``gradient``: less where there is detail;
        ``sharp``: what is seen costs more than in proportion, what is not seen less.
    margin : int
        How far around its window a patch may replace what is there, px.
    lattice : two vectors, (rows, columns) in 1/256 px
        Patches are laid in step with the first one; none: anywhere.
    """

    usage: float = 0.05
    seam: str = "difference"
    margin: int = 16
    lattice: tuple[Vector, Vector] | None = None
