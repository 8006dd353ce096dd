"""Quality of an output against its exemplars: :func:`score`, the data of a report, and quality gates."""

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
    """An output with its score and everything that a report shows.

    Attributes
    ----------
    name : str
        Name of the output in the report and in messages.
    output : Plane
        Its base plane.
    exemplars : tuple of Exemplar
        The exemplars that it was judged against, at full size if they are magnified.
    judged : Judged
        The score, and the sources of its windows.
    wrap : Wrap
        Along which axes it should be periodic.
    map : SourceMap or None
        Its source map, in px of the exemplars reduced ``times``.
    times : int
        Magnification of the output relative to its map.
    recipe : dict
    command : str
        The command that makes the output again; empty if unknown.
    missed : tuple of str
        The gates that it misses.
    energy : int or None
        Seam energy of the map, in thresholds of the truncated quadratic per million px.
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
        """Its score."""
        return self.judged.score

    @property
    def sizes(self) -> list[Pair]:
        """Height and width of each exemplar, in px."""
        return [e.shape for e in self.exemplars]

    @classmethod
    def of(cls, made: Synthesis, name: str = "the output", output: Plane | None = None) -> Outcome:
        """Judge a synthesis; `output` is its base plane, if it is rendered already."""
        times = made.exemplars[0].times
        output = made.render() if output is None else output
        exemplars = tuple(e if times == 1 else _whole(e) for e in made.exemplars)
        judged = judge(exemplars, Exemplar.of(output, name=name), made.map.wrap)
        return cls(name, output, exemplars, judged, made.map.wrap, made.map, times, made.recipe, energy=made.energy)

    def but(self, **facts: Any) -> Outcome:
        """Return a copy with some fields replaced."""
        return replace(self, **facts)


def _whole(exemplar: Exemplar) -> Exemplar:
    """Return a magnified exemplar at full size: its rendered plane and the mask of usable pixels."""
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
    """Return the quality of a synthesised texture against its exemplars: 0 to 100, in total and by perceptual parts.

    Parameters
    ----------
    exemplar : as for :func:`synthesize`
        The exemplars that it was made from.
    output : as an exemplar, or a Synthesis
        The picture, (H, W) or (H, W, C), of any size and depth; its base plane is judged. Its kind and number of
        channels must be those of the exemplar.
    wrap : {"none", "x", "y", "both"}, optional
        Along which axes the picture should be periodic. Default: those of a Synthesis, else none.

    Returns
    -------
    Score
        ``total``, and ``parts`` by name, each with the measured number, its unit and its anchors.

    Raises
    ------
    InputError
        if a picture cannot be read, channels differ, or the map of a Synthesis has holes.
    ParameterError
        for an unknown `wrap`.

    Notes
    -----
    docs/score.md has the formula and its agreement with people.
    """
    return outcome_of(exemplar, output, wrap=wrap).score


def outcome_of(
    exemplar: ExemplarLike | Sequence[ExemplarLike],
    output: ExemplarLike | Synthesis,
    *,
    map: SourceMap | None = None,
    wrap: Wrap | str | None = None,
) -> Outcome:
    """Judge an output as :func:`score` does, and return the data of a report, using its map if there is one.

    Raises InputError if the map is of another size or other exemplars, or has holes.
    """
    exemplars = as_exemplars(exemplar)
    if isinstance(output, Synthesis):
        map = output.map if map is None else map
        output = Exemplar.of(output.render(), name="the output")
    (made,) = as_exemplars([output])
    if map is not None:
        check_start(map, exemplars)
        if map.shape != made.shape:
            raise InputError(
                f"the map is {map.width}x{map.height} px, {made.name} {made.width}x{made.height}; give its own map."
            )
        if bool(map.holes.any()):
            raise InputError("the map has holes; fill them first, with synthesize(start=...).")
    across = chosen(Wrap, "wrap", wrap) if wrap is not None else Wrap.NONE if map is None else map.wrap
    judged, costs = judge(exemplars, made, across), None if map is None else energy(exemplars, map)
    return Outcome(made.name, made.base, exemplars, judged, across, map, energy=costs)


Gates = Sequence[tuple[str, float]]
"""Pairs (name of a part, least normalised score that it must have, up to 1); for ``total`` the least total, of 100."""


def check_gates(gates: Gates) -> None:
    """Raise ParameterError for a gate of an unknown part, or of more than 1 for a part."""
    known = ("total", *(part.name for part in PARTS))
    for name, least in gates:
        if name not in known:
            raise ParameterError(f"--gate {name}={least:g}: no such part; choose one of {', '.join(known)}.")
        if name != "total" and least > 1:
            raise ParameterError(f"--gate {name}={least:g}: a part is worth at most 1; give a number from 0 to 1.")


def gated(found: Score, gates: Gates, name: str) -> None:
    """Raise QualityError, listing the missed gates, if the output called `name` misses any."""
    if missed := misses(found, gates):
        raise QualityError(f"{name} falls short: {', '.join(missed)}.")


def misses(found: Score, gates: Gates) -> tuple[str, ...]:
    """Return the gates that an output misses, with the values that it reaches."""
    missed = list[str]()
    for part, least in gates:
        reached = found.total if part == "total" else found.parts[part].normalised
        if reached < least:
            missed.append(f"{part} {reached:.4g} of {least:g}")
    return tuple(missed)
