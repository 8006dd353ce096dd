"""``intarsia tile``: a picture that continues in itself. Imports nothing heavy before the work starts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import click

from ...geometry import Wrap
from ..options import DONORS, FILE, IMAGES, gathered, input_options, offered, opt
from ..request import Begin, Border, Wish
from ..values import Size
from .grow import growing
from .heal import ABLE, exact_wish, method_options

MOST_BAND, MOST_TILES = 1 << 16, 16

BORDER = (
    opt(
        "axes", "--axes", type=click.Choice([w.value for w in (Wrap.X, Wrap.Y, Wrap.BOTH)]), default=Wrap.BOTH.value,
        show_default=True, help="Axes along which it is to tile.",
    ),
    opt(
        "band", "--band", type=click.IntRange(1, MOST_BAND), metavar="PX",
        help="Width of the band that is grown anew. Half lies at either border. Default: one and a half elements.",
    ),
    opt(
        "size", "--size", "-s", type=Size(), metavar="WIDTHxHEIGHT",
        help="Cut its middle out first. Default: all, or the largest size in which a sure lattice or courses close.",
    ),
)  # fmt: skip
METHOD = tuple(o for o in method_options("How to grow the band.") if o.field != "wrap")
_, PARAMETERS = offered(ABLE, *METHOD, *BORDER)

SEEN = (
    opt("preview", "--preview", type=FILE, metavar="FILE", help="Write the result repeated. 3 x 3 times, to look at."),
    opt(
        "tiles", "--preview-tiles", type=click.IntRange(1, MOST_TILES), default=3, metavar="N",
        help="How often the preview repeats it along each axis that continues. Default: 3.",
    ),
    opt("offset", "--offset", type=FILE, metavar="FILE", help="Write the picture as it was, shifted by half."),
)  # fmt: skip


def _begin(**given: Any) -> Begin:
    return Begin(border=Border(**given))


@growing(
    "tile", "tiled", input_options(IMAGES, DONORS, without=("several", "toroidal")),
    gathered(*BORDER, into="begin", make=_begin),
    gathered(*METHOD, *PARAMETERS, into="wish", make=exact_wish),
    epilog="OUT may hold {stem}, {seed}, {method}, {w} and {h}: with {stem} every picture makes an output of its own.",
    files=SEEN,
)  # fmt: skip
def command(wish: Wish, begin: Begin) -> Wish:
    """Make IMAGE tileable: it continues in itself, and only a band along its borders changes.

    \b
    intarsia tile stones.png -o tile.png --preview many.png
    intarsia tile planks.png -o tile.png --axes x --band 96
    intarsia tile albedo.png --map normal=n.png --map height=h.exr -o tile.png
    """
    return replace(wish, begin=begin, wrap=begin.border.axes if begin.border is not None else "none")
