"""``intarsia weave``: pictures too large for memory, streamed and resumed. Imports nothing heavy before the work."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import click

from ..auto import AUTO_METHOD
from ..errors import ParameterError
from ..methods.base import METHODS, Ability, method_class
from .choosing import chosen_of
from .grow import OWN as GROWN
from .grow import finish_of
from .options import (
    FILE,
    MAGNIFY,
    common,
    gathered,
    input_options,
    method_option,
    method_parameters,
    opt,
    report_options,
)
from .pictures import named_pictures
from .report import Report
from .request import Inputs, Wish
from .values import Position, Seed, Size

ABLE = tuple(slug for slug in METHODS if Ability.WINDOW in method_class(slug).supports)
ENDINGS = {".zarr": "zarr", ".tif": "tiff", ".tiff": "tiff", "": "tiles"}
MOST = 1 << 80  # px; cells and disk set the limit

OWN = (
    opt(
        "size", "--size", "-s", type=Size(MOST), required=True, metavar="WIDTHxHEIGHT",
        help="Size of the output in px, one number for a square; as large as the disk allows.",
    ),
    opt(
        "method", "--method", "-m", type=click.Choice([AUTO_METHOD, *ABLE]), default=AUTO_METHOD, show_default=True,
        help="How to grow; auto chooses, by what the exemplar is like, among those that make windows alone.",
    ),
    *(o for o in GROWN if o.field in ("feather", "mixing", "level")),
)  # fmt: skip

UNION = {
    name: (p, [o for o in owners if o in ABLE])
    for name, (p, owners) in method_parameters({o.field for o in OWN}).items()
    if set(owners) & set(ABLE)
}
PARAMETERS = tuple(method_option(p, owners, len(owners) == len(ABLE)) for p, owners in UNION.values())


@dataclass(frozen=True)
class Loom:
    """Where and how a giant picture is made."""

    out: str
    origin: tuple[int, int] = (0, 0)  # x, y
    chunk: int | None = None
    executor: str | None = None
    dask: str | None = None
    force: bool = False

    def __post_init__(self) -> None:
        if self.executor is not None and self.dask is not None:
            raise ParameterError("--executor and --dask exclude each other; drop one.")
        if self.out == "-":
            raise ParameterError("-o -: a giant picture does not fit into a pipe; name a .zarr, a .tif or a folder.")

    @property
    def who(self) -> str | None:
        """The executor in the words of the library."""
        return self.dask if self.dask is not None else self.executor


LOOM = (
    opt(
        "out", "-o", "--output", required=True, type=FILE, metavar="OUT",
        help="OUT.zarr, OUT.tif (tiled BigTIFF), or a name without an ending: a folder of DeepZoom tiles. Further "
        "planes lie beside it as OUT_NAME.",
    ),
    opt(
        "origin", "--origin", type=Position(), default="0,0", metavar="X,Y",
        help="Which pixel of the endless plane comes first; negative and huge ones too.",
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
        help="A dask cluster draws: one that is started here, or the one whose scheduler is at tcp://HOST:PORT.",
    ),
    opt("force", "--force", is_flag=True, help="Begin anew where another texture was woven."),
)  # fmt: skip


def wish_of(
    size: tuple[int, int], method: str, feather: int | None, mixing: str | None, level: int | None, **given: Any
) -> Wish:
    """Understand the options on method and size."""
    pictures = named_pictures(given, (p for p, _ in UNION.values()))
    chosen, finish = chosen_of(method, None, given, UNION), finish_of(level)
    return Wish(chosen, size, feather=feather, mixing=mixing, finish=finish, pictures=pictures)


@click.command(
    name="weave",
    epilog="What a stopped or killed command began, the same command goes on with. OUT may hold {stem}, {seed}, "
    "{method}, {w} and {h}.",
)
@gathered(*OWN, *PARAMETERS, into="wish", make=wish_of)
@click.option("--seed", type=Seed(), metavar="N|random", help="The same number gives the same picture. Default: 0.")
@gathered(*LOOM, into="loom", make=Loom)
@input_options(
    opt("files", nargs=-1, required=True, type=FILE, metavar="EXEMPLAR..."), MAGNIFY, without=("several",)
)
@click.option("--dry-run", is_flag=True, help="Check everything, tell size, memory and time, write nothing.")
@common
@report_options
def command(
    inputs: Inputs,
    wish: Wish,
    loom: Loom,
    report: Report,
    seed: int | None,
    threads: int | None,
    dry_run: bool,
) -> None:
    """Weave a texture of any size into a file, piece by piece, on this machine or a dask cluster.

    \b
    intarsia weave wall.png -o wall.zarr --size 65536 --dask local
    intarsia weave wall.png -o wall.tif --size 32768x16384 --threads 8
    intarsia weave wall.png -o wall --size 65536 --origin -4096,1000000
        writes DeepZoom tiles: wall/image.dzi and wall/image_files/
    """
    from .weaving import Weaving

    weaving = Weaving.plan(inputs, wish, loom, seed or 0, report)
    if dry_run:
        weaving.tell_plan(threads)
    else:
        weaving.carry_out(threads)
