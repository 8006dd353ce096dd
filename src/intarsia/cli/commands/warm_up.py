"""``intarsia warm-up``: compile every kernel beforehand. Imports nothing heavy before the work."""

from __future__ import annotations

import time

import click

from .. import CANCEL, Report, debug_option, enable_collection


@click.command(name="warm-up")
@click.option(
    "--threads", type=click.IntRange(1, 1024), metavar="N",
    help="Threads to use; by default one a core. Never changes a pixel.",
)  # fmt: skip
@debug_option
@click.option("--quiet", "-q", is_flag=True, help="Say nothing but errors.")
def command(threads: int | None, quiet: bool) -> None:
    """Compile everything for this computer now, so that the first picture comes at once."""
    began, report = time.perf_counter(), Report(quiet=quiet)
    from ...foundation.run import Run
    from ...tasks.precompile import precompile_all

    enable_collection()
    pictures = precompile_all(Run(threads, None, CANCEL))
    report.note(f"ready: grew {pictures} small textures in {time.perf_counter() - began:.1f} s")
