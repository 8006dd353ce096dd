"""Repairing: the worst seams of a finished picture, covered anew.

    wall = ia.synthesize("brick.png", 1024, ia.PatchSampling(), seed=3)
    better = ia.repair(wall)
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..analysis import valid_windows
from ..foundation import MOST_PASSES, PASSES, InputError, ParameterError, expect, lazy, whole_within
from ..foundation.run import Run, run_of
from ..methods import Method, check_start, keeps_lattice, traits
from ..model import Exemplar
from ..model.canvas import Canvas
from ..search import default_patch
from ..synthesis import Synthesis

if TYPE_CHECKING:
    from ..seams import repair as repairs
else:
    repairs = lazy("intarsia.seams.repair")

LEAST_PATCH = 8
LEAST_WINDOW = 12  # px
FINER = 0.375  # of its patches' sides are windows in which what is filled is covered anew,
COVERED, GROWN = 4, 2  # in so many passes, and so often its pieces grow then


def repair(made: Synthesis, passes: int = PASSES, *, run: Run | None = None) -> Synthesis:
    """Cover the worst seams of a finished texture anew, wherever that makes all seams together cheaper.

    Parameters
    ----------
    made : Synthesis
        What any method made that keeps no lattice. Its start map, labels and least distance of repeats stay in force.
    passes : int
        How often the worst places are looked for, 0 to 1000; each pass covers many at a time.
    run : Run, optional
        Threads, progress, cancelling.

    Returns
    -------
    Synthesis
        With another map; the same seams, or cheaper ones.

    Raises
    ------
    ParameterError
        where the method keeps a lattice, or `made` was repaired before.
    InputError
        where the map has holes, or belongs to other exemplars.
    """
    return mended(made, passes, run)[0]


def mended(made: Synthesis, passes: int, run: Run | None = None) -> tuple[Synthesis, repairs.Repaired]:
    """Repair, and tell what it did."""
    expect(made, Synthesis, "what is to be repaired", "what synthesize, extend or heal returned", InputError)
    run = run_of(run)
    check_repair(made.method, passes)
    if "repair" in made.recipe:
        raise ParameterError("this picture was repaired already; repair the first one with more passes.")
    check_start(made.map, made.exemplars)
    if made.map.holes.any():
        raise InputError("the map has holes; fill them before its seams are repaired.")
    canvas = made.canvas or Canvas(made.map.height, made.map.width, made.map.wrap)
    asked = repair_of(made.method, made.exemplars, passes)
    done = repairs.repaired(asked, made.exemplars, canvas, made.map, run)
    return replace(made, map=done.map, recipe=made.recipe | {"repair": passes}), done


def settled(made: Synthesis, run: Run) -> Synthesis:
    """Cover the worst seams of what was filled in smaller windows, and let its pieces grow; without patches all stays.

    One fill and this make seams cheaper than the best of four fills with patches of four sizes does.
    """
    rows, columns = traits(made.method).footprint or (0, 0)
    if not min(rows, columns) or not traits(made.method).exact or keeps_lattice(made.method):
        return made
    canvas = made.canvas
    assert canvas is not None
    high, wide = (min(n, max(round(n * FINER), LEAST_WINDOW)) for n in (rows, columns))
    asked = replace(repair_of(made.method, made.exemplars, COVERED), patch=(high, wide), grown=GROWN, structure=0)
    return replace(made, map=repairs.repaired(asked, made.exemplars, canvas, made.map, run).map)


def check_repair(method: Method, passes: int) -> None:
    """Refuse to repair what a repair would break."""
    whole_within("repair", passes, 0, MOST_PASSES, "passes")
    if passes and not traits(method).exact:
        raise ParameterError("repair lays whole pixels over what is turned or scaled; leave it out, or angle and zoom.")
    if passes and keeps_lattice(method):
        raise ParameterError(
            f"{method.slug} keeps a lattice, which a repair would break; leave repair out, or choose another method."
        )


def repair_of(method: Method, exemplars: tuple[Exemplar, ...], passes: int) -> repairs.Repair:
    """How what a method made is repaired: by patches of its own size, in its poses; pixel methods have none."""
    its = traits(method)
    rows, columns = its.footprint or (0, 0)
    if not rows or not columns:
        rows = columns = default_patch(exemplars)
        while rows > LEAST_PATCH and not any(
            valid_windows((e.height, e.width), e.usable, e.toroidal, (rows, columns)).any() for e in exemplars
        ):
            rows = columns = max(rows // 2, LEAST_PATCH)
    return repairs.Repair((rows, columns), passes, its.channel_weights, its.isometries, its.min_repeat_distance)
