"""``intarsia install-plugin``: copies a plug-in to where its program looks for it. Imports nothing heavy."""

from __future__ import annotations

import click

from ...foundation import ParameterError
from ...plugins import KNOWN, install, remove
from .. import debug_option, print_lines
from ..verbs import FILE


@click.command(name="install-plugin")
@click.argument("program", type=click.Choice(list(KNOWN)), metavar="|".join(KNOWN))
@click.option("--to", type=FILE, metavar="DIR", help="The folder of its plug-ins, if it is not the usual one.")
@click.option("--remove", "away", is_flag=True, help="Remove the plug-in again.")
@debug_option
def command(program: str, to: str | None, away: bool) -> None:
    """Put intarsia into Blender, GIMP, Krita or ComfyUI: copy its plug-in to where that program looks for it.

    \b
    intarsia install-plugin gimp
    intarsia install-plugin comfyui --to ComfyUI/custom_nodes
    intarsia install-plugin krita --remove
    """
    host = KNOWN[program]
    if away:
        gone = remove(program, to)
        if not gone:
            raise ParameterError(f"no plug-in of intarsia is in {host.title}; there is nothing to remove.")
        print_lines(f"removed {place}" for place in gone)
        return
    print_lines([*(f"wrote {place}" for place in install(program, to)), f"next: {host.then}."])
