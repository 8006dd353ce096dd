"""How good an output is by its exemplar: :func:`score`, what a report tells of it, and the gates that it must pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ..foundation import InputError, ParameterError, QualityError, chosen
from ..foundation.arrays import Pair
from ..foundation.geometry import Wrap
from ..judging import Judged, Score, judge
from ..judging.parts import PARTS
from ..methods import check_start
from ..model import Exemplar
from ..model.image import Plane
from ..model.sourcemap import SourceMap
from ..seams import energy
from ..synthesis import ExemplarLike, Synthesis, as_exemplars


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
    def sizes(self) -> list[Pair]:
        """Height and width of each exemplar, in px."""
        return [(e.height, e.width) for e in self.exemplars]

    @classmethod
    def of(cls, made: Synthesis, name: str = "the output", output: Plane | None = None) -> Outcome:
        """Judge what was made; `output` is its base plane, where that is drawn already."""
        times = made.exemplars[0].times
        output = made.render() if output is None else output
        exemplars = tuple(e if times == 1 else _whole(e) for e in made.exemplars)
        judged = judge(exemplars, Exemplar.of(output, name=name), made.map.wrap)
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


def score(
    exemplar: ExemplarLike | Sequence[ExemplarLike],
    output: ExemplarLike | Synthesis,
    *,
    wrap: Wrap | str | None = None,
) -> Score:
    """Tell how good an output is, as people would: 0 to 100, and by its parts.

    Parameters
    ----------
    exemplar : as for :func:`synthesize`
        What it was grown from.
    output : as an exemplar, or a Synthesis
        The picture, of any size and depth; its base plane is looked at, and its make-up must be the exemplar's.
    wrap : {"none", "x", "y", "both"}, optional
        Along which axes the picture should continue in itself. Default: those of a Synthesis, else none.

    Returns
    -------
    Score
        ``total``, and ``parts`` by name, each with the number that was measured, its unit and its anchors.

    Raises
    ------
    InputError
        where one cannot be read, or make-ups differ.

    Notes
    -----
    The formula and how far it agrees with people stand in docs/score.md.
    """
    return outcome_of(exemplar, output, wrap=wrap).score


def outcome_of(
    exemplar: ExemplarLike | Sequence[ExemplarLike],
    output: ExemplarLike | Synthesis,
    *,
    map: SourceMap | None = None,
    wrap: Wrap | str | None = None,
) -> Outcome:
    """Judge an output as :func:`score` does, and keep what a report tells of it, by its map where that is known.

    Raises InputError where the map is of another size or other exemplars, or has holes.
    """
    exemplars = as_exemplars(exemplar)
    if isinstance(output, Synthesis):
        map = output.map if map is None else map
        output = Exemplar.of(output.render(), name="the output")
    (made,) = as_exemplars([output])
    if map is not None:
        check_start(map, exemplars)
        if (map.height, map.width) != (made.height, made.width):
            raise InputError(
                f"the map is {map.width}x{map.height} px, {made.name} {made.width}x{made.height}; give its own map."
            )
        if bool(map.holes.any()):
            raise InputError("the map has holes; fill them first, with synthesize(start=...).")
    across = chosen(Wrap, "wrap", wrap) if wrap is not None else Wrap.NONE if map is None else map.wrap
    judged, costs = judge(exemplars, made, across), None if map is None else energy(exemplars, map)
    return Outcome(made.name, made.base, exemplars, judged, across, map, energy=costs)


Gates = Sequence[tuple[str, float]]
"""Names of parts with the least that each must be worth, 0 to 1; ``total`` counts to 100."""


def check_gates(gates: Gates) -> None:
    """Refuse a gate that no score has; ParameterError."""
    known = ("total", *(part.name for part in PARTS))
    for name, least in gates:
        if name not in known:
            raise ParameterError(f"--gate {name}={least:g}: no such part; choose one of {', '.join(known)}.")
        if name != "total" and least > 1:
            raise ParameterError(f"--gate {name}={least:g}: a part is worth at most 1; give a number from 0 to 1.")


def gated(found: Score, gates: Gates, name: str) -> None:
    """Raise QualityError where an output called `name` misses a gate, naming each that it misses."""
    if missed := misses(found, gates):
        raise QualityError(f"{name} falls short: {', '.join(missed)}.")


def misses(found: Score, gates: Gates) -> tuple[str, ...]:
    """Say which gates an output misses, with what it reaches."""
    missed = list[str]()
    for part, least in gates:
        reached = found.total if part == "total" else found.parts[part].worth
        if reached < least:
            missed.append(f"{part} {reached:.4g} of {least:g}")
    return tuple(missed)
