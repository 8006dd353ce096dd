"""``intarsia heal``: holes filled, objects removed, lost blocks recovered. Imports nothing heavy before the work."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import click

from ...choosing.auto import AUTO_METHOD
from ...methods.base import METHODS, Ability, method_class
from ...params import parameters
from ..options import DONORS, FILE, IMAGES, Opt, gathered, input_options, offered, opt
from ..request import Begin, Wish
from ..values import EnlargedSize
from .grow import OWN as GROWN
from .grow import growing, wish_of

MOST_GROWN, MOST_EDGE = 1024, 64  # px

HOLES = (
    opt(
        "holes", "--mask", multiple=True, type=FILE, metavar="HOLE|alpha", required=True,
        help="White is healed; with alpha what is transparent. As large as the picture; one for all "
        "pictures, or one for each.",
    ),
    opt(
        "grow", "--grow", type=EnlargedSize(MOST_GROWN), default="auto", metavar="N|auto",
        help="Enlarge the hole by N px first. With auto as far as a rim of the defect is seen outside. Default: auto.",
    ),
    opt(
        "edge", "--edge", type=click.IntRange(0, MOST_EDGE), default=0, metavar="N",
        help="Fill N px along the edge of holes again, pixel by pixel; slow.",
    ),
)  # fmt: skip
USABLE = opt(
    "masks", "--usable", multiple=True, type=FILE, metavar="FILE",
    help="White where pixels may be taken from. One for each picture.",
)  # fmt: skip


def _begin(**given: Any) -> Begin:
    """The holes, and how far they grow; a negative number stands for auto."""
    return Begin(**(given | {"grow": given["grow"] if given["grow"] >= 0 else None}))


def exact_wish(**given: Any) -> Wish:
    """What was asked for; of all patches the best is taken if nothing else is said."""
    slug = given["method"]
    exact = slug != AUTO_METHOD and any(p.name == "tolerance" for p in parameters(method_class(slug)))
    if exact and given["tolerance"] is None:
        given["tolerance"] = "0"
    return wish_of(feather=None, mixing=None, union=UNION, **given)


ABLE = tuple(slug for slug in METHODS if {Ability.START, Ability.MASK} <= method_class(slug).supports)


def method_options(said: str) -> list[Opt]:
    """The options of grow on method, choice, wrap and repair; only methods that can continue a picture are offered."""
    options = []
    for o in GROWN:
        if o.field == "method":
            options.append(o.but(type=click.Choice([AUTO_METHOD, *ABLE]), help=said))
        elif o.field == "wrap":
            options.append(o.but(help="Axes along which the picture continues in itself."))
        elif o.field in ("explain", "repair"):
            options.append(o)
    return options


OWN = method_options("How to fill the holes.")
UNION, PARAMETERS = offered(ABLE, *OWN)


@growing(
    "heal", "healed",
    input_options(IMAGES, DONORS, USABLE, without=("several", "masks", "crop", "scale", "flatten")),
    gathered(*HOLES, into="begin", make=_begin), gathered(*OWN, *PARAMETERS, into="wish", make=exact_wish),
    epilog="OUT may hold {stem}, {seed}, {method}, {w} and {h}: with {stem} every picture makes an output of its own.",
)  # fmt: skip
def command(wish: Wish, begin: Begin) -> Wish:
    """Fill the holes of IMAGE with what suits there; all other pixels stay, byte for byte.

    \b
    intarsia heal wall.png --mask graffiti.png -o clean.png
    intarsia heal scan.png --mask scratches.png --grow 2 -o whole.png
    intarsia heal cutout.png --mask alpha -o filled.png
    """
    return replace(wish, begin=begin)
