"""The command ``intarsia``: a list of commands, each imported when it is called. Imports nothing heavy."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import click

from ..disk.limits import make_room
from ..version import VERSION
from .exits import begun, guarded

COMMANDS = {
    "grow": "Grow a larger or tileable texture from an example.",
    "paint": "Paint with textures: labels say what grows where.",
    "extend": "Continue a picture beyond its borders.",
    "heal": "Fill holes, remove objects, recover lost blocks.",
    "tile": "Make a photograph or a material tileable: only a band along its borders changes.",
    "weave": "Stream a texture of any size into zarr (resumes), BigTIFF or tiles.",
    "render": "Draw a saved map again: other planes, softer, harder, a window.",
    "replay": "Make a picture again from the recipe it carries.",
    "analyze": "Tell how a texture repeats, how large its elements are, and how to grow it.",
    "score": "Tell how good an output is, and what speaks against it.",
    "methods": "List the methods, or the parameters of one.",
    "studio": "Open a page on this machine to see, grow, paint and keep.",
    "warm-up": "Compile everything now, so that the first picture comes at once.",
}
"""Name -> what it does, in the order of the help. The module is named alike and holds `command`."""

PLANNED = {"grow", "paint", "extend", "heal", "tile"}
"""What is planned first, all alike by `commands/grow.py`, which says when the work begins."""

LIGHT = {"-h", "--help", "--help-all", "--version", "methods"}
"""What needs next to no memory."""


class LazyGroup(click.Group):
    """A group that imports a command when it is called, and says every error in one line."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        planned = name in PLANNED
        module = importlib.import_module(f".commands.{'grow' if planned else name.replace('-', '_')}", __package__)
        if not planned:
            begun()
        command: click.Command = module.command_of(name) if planned else module.command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def main(  # type: ignore[override]
        self, args: Sequence[str] | None = None, prog_name: str | None = None, **extra: Any
    ) -> NoReturn:
        """Run the command line and leave with an exit code; never a traceback for bad input."""
        given = sys.argv[1:] if args is None else list(args)
        name = prog_name or "intarsia"
        if os.environ.get(f"_{name.upper()}_COMPLETE"):
            super().main(given, name)

        def work() -> None:
            if given and not LIGHT & set(given):
                make_room()
            with self.make_context(name, given) as ctx:
                self.invoke(ctx)

        sys.exit(guarded(work, "--debug" in given))


@click.command(
    "intarsia",
    cls=LazyGroup,
    invoke_without_command=True,
    epilog='Shell completion: put  eval "$(_INTARSIA_COMPLETE=bash_source intarsia)"  into ~/.bashrc '
    "(zsh_source, fish_source for other shells).",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@click.version_option(VERSION, "--version", message="%(prog)s %(version)s")
@click.option("--debug", is_flag=True, expose_value=False, help="Show where an error came from.")
@click.pass_context
def cli(ctx: click.Context) -> None:
    """Grow textures from an example.

    A small picture goes in; a larger, tileable, exactly reproducible one made of its pieces comes out.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())
