"""How good an output is by its exemplar: :func:`score`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..arguments import called, chosen, expect
from ..errors import InputError, ParameterError, QualityError
from ..exemplar import Exemplar
from ..geometry import Wrap
from ..judging.mapped import MAPPED, WRAPPED
from ..judging.parts import PARTS
from ..judging.score import Score, judge
from ..methods.base import check_start
from ..run import Run
from ..seams.cost import energy
from ..sourcemap import SourceMap
from ..synthesis import ExemplarLike, Synthesis, as_exemplars
from .outcome import Outcome

RECIPE = "recipe"
"""In place of a map: the one that the recipe in the output's file makes again."""


def score(
    exemplar: ExemplarLike | Sequence[ExemplarLike],
    output: ExemplarLike | Synthesis,
    *,
    map: SourceMap | str | None = None,
    wrap: Wrap | str | None = None,
) -> Score:
    """Tell how good an output is, as people would: 0 to 100, and by its parts.

    Parameters
    ----------
    exemplar : as for :func:`synthesize`
        What it was grown from.
    output : as an exemplar, or a Synthesis
        The picture, of any size and depth; its base plane is looked at, and its make-up must be the exemplar's.
    map : SourceMap or "recipe", optional
        Where its pixels come from; that of a Synthesis is known. It adds parts, and changes none of the others.
        ``"recipe"`` makes it again from the recipe in the file that `output` names, which takes as long as growing.
    wrap : {"none", "x", "y", "both"}, optional
        Along which axes the picture should continue in itself. Default: those of the map, else none.

    Returns
    -------
    Score
        ``total``, and ``parts`` by name, each with the number that was measured, its unit and its anchors.

    Raises
    ------
    InputError
        where one cannot be read, make-ups differ, or the map is of another size or other exemplars; where the file
        carries no recipe, or it makes other pixels of these exemplars.

    Notes
    -----
    The formula and how far it agrees with people stand in docs/score.md.
    """
    return outcome_of(exemplar, output, map=map, wrap=wrap).score


def outcome_of(
    exemplar: ExemplarLike | Sequence[ExemplarLike],
    output: ExemplarLike | Synthesis,
    *,
    map: SourceMap | str | None = None,
    wrap: Wrap | str | None = None,
) -> Outcome:
    """Judge an output as :func:`score` does, and keep what a report tells of it."""
    exemplars = as_exemplars(exemplar)
    if isinstance(output, Synthesis):
        map = output.map if map is None else map
        output = Exemplar.of(output.render(), name="the output")
    (made,) = as_exemplars([output])
    if isinstance(map, str):
        if map != RECIPE or not isinstance(output, str | Path):
            raise ParameterError(f'map={called(map)}: give a SourceMap, or "{RECIPE}" where the output is a file.')
        from .replaying import recipe_map  # it tiles and repairs, and is slow to import

        map = recipe_map(output, made.base, exemplars, Run())
    if map is not None:
        expect(map, SourceMap, "map", "a SourceMap", InputError)
        check_start(map, exemplars)
        if (map.height, map.width) != (made.height, made.width):
            raise InputError(
                f"the map is {map.width}x{map.height} px, {made.name} {made.width}x{made.height}; give its own map."
            )
        if bool(map.holes.any()):
            raise InputError("the map has holes; fill them first, with synthesize(start=...).")
    across = chosen(Wrap, "wrap", wrap) if wrap is not None else Wrap.NONE if map is None else map.wrap
    judged, costs = judge(exemplars, made, across, map), None if map is None else energy(exemplars, map)
    return Outcome(made.name, made.base, exemplars, judged, across, map, energy=costs)


Gates = Sequence[tuple[str, float]]
"""Names of parts with the least that each must be worth, 0 to 1; ``total`` counts to 100."""


def check_gates(gates: Gates, mapped: bool = True, wraps: bool = True) -> None:
    """Refuse a gate that no score has, or none where no map of whole pixels is known, or that wraps; ParameterError."""
    known = ("total", *(part.name for part in (*PARTS, *MAPPED, WRAPPED)))
    for name, least in gates:
        if name not in known:
            raise ParameterError(f"--gate {name}={least:g}: no such part; choose one of {', '.join(known)}.")
        if name != "total" and least > 1:
            raise ParameterError(f"--gate {name}={least:g}: a part is worth at most 1; give a number from 0 to 1.")
        if name == WRAPPED.name and not wraps:
            raise ParameterError(f"--gate {name}={least:g}: the output does not wrap; give --wrap, or drop the gate.")
        if not mapped and name in {part.name for part in MAPPED}:
            raise ParameterError(
                f"--gate {name}={least:g}: only a map of whole pixels tells this, and none is made; drop the gate."
            )


def gated(found: Score, gates: Gates, name: str) -> None:
    """Raise QualityError where an output called `name` misses a gate, naming each that it misses."""
    if missed := misses(found, gates, name):
        raise QualityError(f"{name} falls short: {', '.join(missed)}.")


def misses(found: Score, gates: Gates, name: str) -> tuple[str, ...]:
    """Say which gates an output called `name` misses, with what it reaches."""
    missed = list[str]()
    for part, least in gates:
        if part != "total" and part not in found.parts:
            raise ParameterError(f"--gate {part}={least:g}: {name} has no such part without its map, or its wrap.")
        reached = found.total if part == "total" else found.parts[part].worth
        if reached < least:
            missed.append(f"{part} {reached:.4g} of {least:g}")
    return tuple(missed)
