"""What is done to a picture once it is drawn, in words: today one finish, which levels steps at seams."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from .arguments import FEATHER
from .params import check, param, parameters


@dataclass(frozen=True)
class Levelling:
    """Even out steps of light and colour across seams, over `radius` px to either side of them.

    Parameters
    ----------
    radius : int
        1 to 1024 px of the map: slow changes of light and colour meet within it, finer detail stays.
    strength : float
        0 to 1: which share of the step is taken away.
    """

    name: ClassVar[str] = "levelling"

    radius: int = param(
        96, "int", "how far to either side of a seam light is evened out", low=1, high=FEATHER, unit="px"
    )
    strength: float = param(1.0, "float", "which share of a step is taken away", low=0, high=1)

    def __post_init__(self) -> None:
        check(self)

    @classmethod
    def read(cls, entry: dict[str, Any]) -> Levelling:
        """Read a finish of a map or a recipe; KeyError, TypeError or ParameterError for anything else."""
        values = dict(entry)
        return {cls.name: cls}[values.pop("name")](**values)

    @property
    def as_recipe(self) -> dict[str, Any]:
        """A finish as maps and recipes hold it."""
        return {"name": self.name, **{p.name: getattr(self, p.name) for p in parameters(self)}}


Finish = Levelling
"""All that can be done to a drawn picture; never to normals or labels."""
