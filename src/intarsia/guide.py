"""A guide says what the output should look like where: a picture beside the exemplar, one for the canvas."""

from __future__ import annotations

from dataclasses import dataclass

from .errors import InputError
from .image import Kind, Plane


@dataclass(frozen=True)
class Guide:
    """Labels, or a target picture, on both sides: beside the exemplar and over the canvas.

    Parameters
    ----------
    source : Plane
        One value (or vector) for each exemplar pixel; LABEL for label maps.
    target : Plane
        The same for each canvas pixel, of the same kind and number of channels.
    weight : float
        How much the guide counts against the pixels, at least 0.

    Raises
    ------
    InputError
        where kind or channels of the two differ, or the target names labels that the source lacks.
    """

    source: Plane
    target: Plane
    weight: float = 1.0

    def __post_init__(self) -> None:
        if (self.source.kind, self.source.channels) != (self.target.kind, self.target.channels):
            raise InputError("the guide's two pictures differ in kind or channels; give two of one kind.")
        if not 0 <= self.weight < 1e6:
            raise InputError(f"weight={self.weight} of the guide is not allowed; give 0 to 1e6.")
        if self.source.kind is Kind.LABEL:
            missing = sorted(set(self.target.pixels.ravel().tolist()) - set(self.source.pixels.ravel().tolist()))
            if missing:
                raise InputError(
                    f"the target's labels {missing[:8]} do not occur beside the exemplar; map them to others."
                )
