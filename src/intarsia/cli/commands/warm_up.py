"""``intarsia warm-up``: compile every kernel beforehand. Imports nothing heavy before the work."""

from __future__ import annotations

import time

import click

from ..exits import CANCEL, begun
from ..options import common, gathered, opt
from ..report import Report


@click.command(name="warm-up")
@common
@gathered(opt("quiet", "--quiet", "-q", is_flag=True, help="Say nothing but errors."), into="report", make=Report)
def command(report: Report, threads: int | None) -> None:
    """Compile everything for this computer now, so that the first picture comes at once."""
    began = time.perf_counter()
    from ...run import Run
    from ...tasks.warming import warm_up

    begun()
    pictures = warm_up(Run(threads, None, CANCEL))
    report.note(f"ready: grew {pictures} small textures in {time.perf_counter() - began:.1f} s")
