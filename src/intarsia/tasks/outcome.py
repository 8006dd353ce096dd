"""An output with all that a report tells of it: what it was grown from, how it was judged, how it is made again."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from ..exemplar import Exemplar
from ..geometry import Wrap
from ..image import Plane
from ..judging.score import Judged, Score, judge
from ..sourcemap import SourceMap
from ..synthesis import Synthesis


@dataclass(frozen=True, eq=False)
class Outcome:
    """An output to report on.

    ``output`` is its base plane, ``exemplars`` are as they were judged by. ``map`` points into them, reduced ``times``
    where they are magnified, and ``energy`` is what its seams cost. ``command`` makes the output again; ``missed`` says
    which gates it misses.
    """

    name: str
    output: Plane
    exemplars: tuple[Exemplar, ...]
    judged: Judged
    wrap: Wrap = Wrap.NONE
    map: SourceMap | None = None
    times: int = 1
    recipe: dict[str, Any] = field(default_factory=dict)
    command: str = ""
    missed: tuple[str, ...] = ()
    energy: int | None = None

    @property
    def score(self) -> Score:
        """How good it is."""
        return self.judged.score

    @property
    def sizes(self) -> list[tuple[int, int]]:
        """Height and width of each exemplar, in px."""
        return [(e.height, e.width) for e in self.exemplars]

    @classmethod
    def of(cls, made: Synthesis, name: str = "the output", output: Plane | None = None) -> Outcome:
        """Judge what was made; `output` is its base plane, where that is drawn already.

        What only a map tells is told where it lies at whole pixels of exemplars that are not magnified.
        """
        times = made.exemplars[0].times
        output = made.render() if output is None else output
        exemplars = tuple(e if times == 1 else _whole(e) for e in made.exemplars)
        told = made.map if made.map.exact and times == 1 else None
        judged = judge(exemplars, Exemplar.of(output, name=name), made.map.wrap, told)
        return cls(name, output, exemplars, judged, made.map.wrap, made.map, times, made.recipe, energy=made.energy)

    def but(self, **facts: Any) -> Outcome:
        """Return the same, of which some is told otherwise."""
        return replace(self, **facts)


def _whole(exemplar: Exemplar) -> Exemplar:
    """The plane that is drawn of a magnified exemplar, and what of it may be used."""
    name, n = exemplar.drawn[0], exemplar.times
    usable = exemplar.usable
    return Exemplar(
        {name: exemplar.planes[name]}, None if usable is None else usable.repeat(n, 0).repeat(n, 1),
        exemplar.toroidal, exemplar.name,
    )  # fmt: skip
