"""``intarsia extend``: a picture, continued beyond its borders. Imports nothing heavy before the work starts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import click

from ..errors import ParameterError
from .grow import OWN, PARAMETERS, check_stdout, wish_of
from .options import DONORS, FILE, common, gathered, grown_target_options, input_options, opt, report_options
from .report import Report
from .request import Begin, Inputs, Targets, Wish
from .values import Seed

USUAL = 100  # as starts.USUAL; asking it here would import numpy for a help text
MOST = 1 << 20


PLACES = ("left", "right", "top", "bottom")
SIDES = tuple(
    opt(p, f"--{p}", type=click.IntRange(0, MOST), metavar="N", help=f"Px to add at the {p}.") for p in PLACES
)


def _begin(**sides: int | None) -> Begin:
    """The margins; with none named, as the source of the idea has it: to the right."""
    if all(px is None for px in sides.values()):
        return Begin((0, USUAL, 0, 0))
    left, right, top, bottom = (sides[name] or 0 for name in PLACES)
    if not left + right + top + bottom:
        raise ParameterError("no side is extended; give at least one of --left, --right, --top and --bottom, in px.")
    return Begin((left, right, top, bottom))


@click.command(
    name="extend",
    epilog="OUT may hold {stem}, {seed}, {method}, {w} and {h}: with {stem} every picture makes an output of its own.",
)
@gathered(*SIDES, into="begin", make=_begin)
@gathered(*(o for o in OWN if o.field not in ("size", "level")), *PARAMETERS, into="wish", make=wish_of)
@click.option("--seed", type=Seed(), metavar="N|random", help="The same number gives the same picture. Default: 0.")
@grown_target_options
@input_options(
    opt("files", nargs=-1, required=True, type=FILE, metavar="IMAGE..."), DONORS, without=("several", "flatten")
)
@click.option("--dry-run", is_flag=True, help="Check everything, tell sizes and memory, write nothing.")
@common
@report_options
def command(
    inputs: Inputs,
    targets: Targets,
    wish: Wish,
    begin: Begin,
    report: Report,
    seed: int | None,
    threads: int | None,
    **more: Any,
) -> None:
    """Continue IMAGE beyond its borders, 100 px to the right if no side is named.

    \b
    intarsia extend wall.png -o wide.png --right 300
    intarsia extend wall.png -o around.png --left 64 --right 64 --top 64 --bottom 64
    intarsia extend meadow.png -o mixed.png --bottom 200 --from gravel.png
    """
    check_stdout(targets, report)

    from .batch import Batch

    batch = Batch.plan(inputs, targets, replace(wish, begin=begin), (seed or 0,), report)
    if more["dry_run"]:
        batch.tell_plan()
    else:
        batch.carry_out(threads)
