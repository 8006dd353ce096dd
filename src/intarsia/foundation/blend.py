"""How the pieces of a map are blended when it is rendered: feathering, mixing, gradient-domain tone correction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, ClassVar

from . import FEATHER, ParameterError, Record, called, chosen, whole_within
from .params import check, param, values_of


@dataclass(frozen=True)
class Levelling:
    """Gradient-domain (Poisson) tone correction: remove steps of brightness and colour across seams.

    Parameters
    ----------
    radius : int
        Distance on either side of a seam, 1 to 1024 px of the map, default 96: slow changes of brightness and colour
        are matched within it, finer detail stays.
    strength : float
        Share of a step that is removed, 0 to 1, default 1.

    Raises
    ------
    ParameterError
        for a value out of range.
    """

    name: ClassVar[str] = "levelling"

    radius: int = param(
        96, "int", "distance on either side of a seam over which tone is corrected", low=1, high=FEATHER, unit="px"
    )
    strength: float = param(1.0, "float", "share of a step of tone that is removed", low=0, high=1)

    def __post_init__(self) -> None:
        check(self)

    @classmethod
    def read(cls, entry: Record) -> Levelling:
        """Read a finish from a map or a recipe; KeyError, TypeError or ParameterError for anything else."""
        values = dict(entry)
        return {cls.name: cls}[values.pop("name")](**values)

    @property
    def as_recipe(self) -> Record:
        """The finish as saved in maps and recipes."""
        return {"name": self.name, **values_of(self)}


Finish = Levelling
"""Corrections of a rendered picture; never applied to normals or labels."""


class Mixing(StrEnum):
    """How the overlapping pieces at a pixel are averaged within a feather.

    MEAN: weighted mean in linear light. SOURCE: weighted mean of the encoded values, as the papers do.
    """

    MEAN = "mean"  # in linear light
    SOURCE = "source"  # of the encoded values, as the papers do


@dataclass(frozen=True)
class Blend:
    """How pieces of a map are blended when it is rendered.

    Parameters
    ----------
    feather : int
        Width of the transition around a cut, 0 to 1024 px of the map, default 0: exact copies.
    mixing : {"mean", "source"}
        How pieces are averaged there, default "mean".
    finish : tuple of Levelling
        Tone correction after that, at most one; default none. It is never applied to normals or labels.

    Raises
    ------
    ParameterError
        for a value out of range.
    """

    feather: int = 0
    mixing: Mixing = Mixing.MEAN
    finish: tuple[Finish, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "feather", whole_within("feather", self.feather, 0, FEATHER))
        object.__setattr__(self, "mixing", chosen(Mixing, "mixing", self.mixing))
        if not isinstance(self.finish, (tuple, list)) or not all(isinstance(f, Finish) for f in self.finish):
            refused = f"finish={called(self.finish)} is not allowed"
            raise ParameterError(f"{refused}; give a tuple, such as (Levelling(32),).")
        object.__setattr__(self, "finish", tuple(self.finish))
        if len({f.name for f in self.finish}) < len(self.finish):  # a second would take the first one's work back
            raise ParameterError("finish holds two of a kind; give each at most once.")

    @classmethod
    def of(cls, recipe: Record) -> Blend:
        """Read a blend from a saved map or a recipe; without an entry ``finish`` there is none."""
        finish = tuple(Finish.read(entry) for entry in recipe.get("finish", ()))
        return cls(recipe["feather"], recipe["mixing"], finish)

    def but(self, **given: Any) -> Blend:
        """Return the blend with those of the given fields replaced that are not None."""
        return replace(self, **{name: value for name, value in given.items() if value is not None})

    @property
    def as_recipe(self) -> Record:
        """The blend as saved in maps and recipes; ``finish`` is left out if there is none."""
        most = {"feather": self.feather, "mixing": self.mixing.value}
        return most | ({"finish": [f.as_recipe for f in self.finish]} if self.finish else {})
