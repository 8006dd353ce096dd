"""``intarsia weave``: pictures too large for memory, streamed to the disk. Imports nothing heavy before the work."""

from __future__ import annotations

from functools import partial
from typing import Any

import click

from ...choosing.auto import AUTO_METHOD
from ...errors import ParameterError
from ...methods.base import METHODS, Ability, method_class
from ..help import HelpfulCommand
from ..options import EXEMPLARS, FILE, MAGNIFY, SEED, common, gathered, input_options, offered, opt, report_options
from ..report import Report
from ..request import Inputs, Loom, Wish
from ..values import Position, Size
from .grow import METHOD, wish_of
from .grow import OWN as GROWN

ABLE = tuple(slug for slug in METHODS if Ability.WINDOW in method_class(slug).supports)
MOST = 1 << 80  # px; cells and disk set the limit

OWN = (
    opt(
        "size", "--size", "-s", type=Size(MOST), required=True, metavar="WIDTHxHEIGHT",
        help="Size in px, as large as the disk allows. One number is a square.",
    ),
    METHOD.but(
        type=click.Choice([AUTO_METHOD, *ABLE]),
        help="How to grow; auto chooses. It goes by what the exemplar is like, among methods that make windows alone.",
    ),
    *(o for o in GROWN if o.field in ("explain", "feather", "mixing", "level")),
)  # fmt: skip

UNION, PARAMETERS = offered(ABLE, *OWN)

LOOM = (
    opt(
        "out", "-o", "--output", type=FILE, metavar="OUT",
        help="OUT.zarr, OUT.tif, a folder of tiles, or OUT.png. A .zarr goes on where it was stopped, all else begins "
        "anew; a .tif is a tiled BigTIFF; a name without an ending is a folder of DeepZoom tiles; a .png, or another "
        "picture, must fit into memory. Further planes lie beside it as OUT_NAME. Default: NAME_woven.tif in the "
        "working folder.",
    ),
    opt(
        "origin", "--origin", type=Position(), default="0,0", metavar="X,Y",
        help="Which pixel of the endless plane comes first. Negative and huge ones too.",
    ),
    opt(
        "chunk", "--chunk", type=click.IntRange(16, 8192), metavar="PX",
        help="Side of the chunks of a zarr array, or of the tiles. Default: 512, and 256 for a folder of tiles.",
    ),
    opt(
        "executor", "--executor", type=click.Choice(["threads", "processes"]),
        help="Who draws, as many as --threads says. Default: threads. Never changes a pixel.",
    ),
    opt(
        "dask", "--dask", metavar="local|ADDRESS",
        help="A dask cluster draws. One that is started here, or the one whose scheduler is at tcp://HOST:PORT.",
    ),
    opt("force", "--force", is_flag=True, help="Begin anew where another texture or picture lies."),
)  # fmt: skip


def loom_of(out: str | None, seed: int | None, **given: Any) -> Loom:
    """Understand the options on where and how."""
    if out == "":
        raise ParameterError("-o: an empty name was given; name a .zarr, a .tif or a folder.")
    return Loom(out or "", seed=seed or 0, **given)


@click.command(
    name="weave",
    cls=HelpfulCommand,
    epilog="What a stopped or killed command began, the same command goes on with where OUT is a .zarr; all else "
    "begins anew, and nothing of it is left. OUT may hold {stem}, {seed}, {method}, {w} and {h}.",
)
@gathered(*OWN, *PARAMETERS, into="wish", make=partial(wish_of, union=UNION))
@gathered(SEED, *LOOM, into="loom", make=loom_of)
@input_options(EXEMPLARS, MAGNIFY, without=("several",))
@click.option("--dry-run", is_flag=True, help="Check everything, write nothing. Tells size, memory and time.")
@common
@report_options
def command(inputs: Inputs, wish: Wish, loom: Loom, report: Report, threads: int | None, dry_run: bool) -> None:
    """Weave a texture of any size into a file, piece by piece, on this machine or a dask cluster.

    \b
    intarsia weave wall.png -o wall.zarr --size 65536 --dask local
    intarsia weave wall.png -o wall.tif --size 32768x16384 --threads 8
    intarsia weave wall.png -o wall --size 65536 --origin -4096,1000000
        writes DeepZoom tiles: wall/image.dzi and wall/image_files/
    """
    from ..weaving import Weaving

    weaving = Weaving.plan(inputs, wish, loom, report)
    if dry_run:
        weaving.tell_plan(threads)
    else:
        weaving.carry_out(threads)
