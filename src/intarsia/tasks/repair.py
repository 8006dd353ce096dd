"""Repair of a finished synthesis: its worst seams are refined by graph-cut placement of new patches.

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

LEAST_PATCH = 8  # px: least side of the patches of a repair
LEAST_WINDOW = 12  # px: least side of the windows in which filled holes are refined
FINER = 0.375  # of the sides of the patches that filled a hole: sides of the windows in which it is refined
COVERED, GROWN = 4, 2  # passes of refinement over a filled hole, and rounds of expansion moves after them


def repair(made: Synthesis, passes: int = PASSES, *, run: Run | None = None) -> Synthesis:
    """Refine the worst seams of a synthesis: place new patches over them wherever that lowers the seam energy.

    Each patch is cut in along a minimum cut over the existing seams (Kwatra et al. 2003, section 3).

    Parameters
    ----------
    made : Synthesis
        Of any method that copies pixels exactly and keeps no lattice. Its start map, labels and minimum distance of
        repeats stay in force.
    passes : int
        Number of searches for the worst places, 0 to 1000, default 4; each pass refines many of them.
    run : Run, optional
        Threads, progress, cancelling.

    Returns
    -------
    Synthesis
        With a map of equal or lower energy; its recipe holds the number of passes.

    Raises
    ------
    ParameterError
        if the method keeps a lattice, or rotates or scales pieces; if `passes` is out of range; if `made` was repaired
        before.
    InputError
        if `made` is no Synthesis, or its map has holes or belongs to other exemplars.
    """
    return repaired_with_statistics(made, passes, run)[0]


def repaired_with_statistics(
    made: Synthesis, passes: int, run: Run | None = None
) -> tuple[Synthesis, repairs.Repaired]:
    """Repair a synthesis as :func:`repair` does; return it with the statistics of the repair."""
    expect(made, Synthesis, "what is to be repaired", "what synthesize, extend or heal returned", InputError)
    run = run_of(run)
    check_repair(made.method, passes)
    if "repair" in made.recipe:
        raise ParameterError("this picture was repaired already; repair the first one with more passes.")
    check_start(made.map, made.exemplars)
    if made.map.holes.any():
        raise InputError("the map has holes; fill them before its seams are repaired.")
    canvas = made.canvas or Canvas(*made.map.shape, made.map.wrap)
    asked = repair_of(made.method, made.exemplars, passes)
    done = repairs.repaired(asked, made.exemplars, canvas, made.map, run)
    return replace(made, map=done.map, recipe=made.recipe | {"repair": passes}), done


def refined(made: Synthesis, run: Run) -> Synthesis:
    """Refine the worst seams of filled holes in windows of FINER of the patch size, then by expansion moves.

    Returned unchanged if the method places no patches, does not copy exactly, or keeps a lattice. One fill refined so
    has a lower seam energy than the best of four fills with patches of four sizes.
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
    """Raise ParameterError if a repair would break the result of a method: no exact copies, or a lattice."""
    whole_within("repair", passes, 0, MOST_PASSES, "passes")
    if passes and not traits(method).exact:
        raise ParameterError("repair lays whole pixels over what is turned or scaled; leave it out, or angle and zoom.")
    if passes and keeps_lattice(method):
        raise ParameterError(
            f"{method.slug} keeps a lattice, which a repair would break; leave repair out, or choose another method."
        )


def repair_of(method: Method, exemplars: tuple[Exemplar, ...], passes: int) -> repairs.Repair:
    """Return the settings of a repair: patch size and isometries of the method.

    For methods without patches the automatic size is taken, halved until the exemplars hold a usable patch.
    """
    its = traits(method)
    rows, columns = its.footprint or (0, 0)
    if not rows or not columns:
        rows = columns = default_patch(exemplars)
        while rows > LEAST_PATCH and not any(
            valid_windows(e.shape, e.usable, e.toroidal, (rows, columns)).any() for e in exemplars
        ):
            rows = columns = max(rows // 2, LEAST_PATCH)
    return repairs.Repair((rows, columns), passes, its.channel_weights, its.isometries)
