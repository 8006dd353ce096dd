"""``intarsia extend``: a picture, continued beyond its borders. Imports nothing heavy before the work starts."""

from __future__ import annotations

from dataclasses import replace

import click

from ...arguments import MARGIN
from ...errors import ParameterError
from ..options import DONORS, IMAGES, gathered, input_options, opt
from ..request import Begin, Wish
from .grow import OWN, PARAMETERS, growing, wish_of

MOST = 1 << 20


PLACES = ("left", "right", "top", "bottom")
SIDES = tuple(
    opt(p, f"--{p}", type=click.IntRange(0, MOST), metavar="N", help=f"Px to add at the {p}.") for p in PLACES
)


def _begin(**sides: int | None) -> Begin:
    """The margins; with none named, as the source of the idea has it: to the right."""
    if all(px is None for px in sides.values()):
        return Begin((0, MARGIN, 0, 0))
    left, right, top, bottom = (sides[name] or 0 for name in PLACES)
    if not left + right + top + bottom:
        raise ParameterError("no side is extended; give at least one of --left, --right, --top and --bottom, in px.")
    return Begin((left, right, top, bottom))


@growing(
    "extend", "extended", input_options(IMAGES, DONORS, without=("several", "flatten")),
    gathered(*SIDES, into="begin", make=_begin),
    gathered(*(o for o in OWN if o.field not in ("size", "level")), *PARAMETERS, into="wish", make=wish_of),
    epilog="OUT may hold {stem}, {seed}, {method}, {w} and {h}: with {stem} every picture makes an output of its own.",
)  # fmt: skip
def command(wish: Wish, begin: Begin) -> Wish:
    """Continue IMAGE beyond its borders, 100 px to the right if no side is named.

    \b
    intarsia extend wall.png -o wide.png --right 300
    intarsia extend wall.png -o around.png --left 64 --right 64 --top 64 --bottom 64
    intarsia extend meadow.png -o mixed.png --bottom 200 --from gravel.png
    """
    return replace(wish, begin=begin)
