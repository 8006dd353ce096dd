"""``intarsia weave``: pictures too large for memory, streamed to the disk. Imports nothing heavy before the work."""

from __future__ import annotations

from ...request import Request
from .. import Report
from ..verbs import HelpfulCommand


def weave(request: Request, report: Report) -> None:
    """Weave a texture of any size into a file, piece by piece, on this machine or a dask cluster.

    \b
    intarsia weave wall.png -o wall.zarr --size 65536 --dask local
    intarsia weave wall.png -o wall.tif --size 32768x16384 --threads 8
    intarsia weave wall.png -o wall.png --size 2048 --origin -4096,1000000
    """
    from ..weaving import Weaving

    weaving = Weaving.plan(request, report)
    weaving.tell_plan() if request.dry_run else weaving.carry_out()


command = HelpfulCommand(
    "weave", weave,
    epilog="What a stopped or killed command began, the same command goes on with where OUT is a .zarr; all else "
    "begins anew, and nothing of it is left. OUT may hold {stem}, {seed}, {method}, {w} and {h}.",
)  # fmt: skip
