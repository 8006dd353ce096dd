"""``intarsia where``: what other programs ask first. Imports nothing heavy."""

from __future__ import annotations

import sys

import click

from ...kernels import cache_folder, is_warm
from ...plugins import CONTRACT, own_command
from ...version import VERSION
from .. import debug_option, print_lines, say_json


@click.command(name="where")
@click.option("--json", "as_json", is_flag=True, help="Print a JSON object.")
@debug_option
def command(as_json: bool) -> None:
    """Tell where this program is, its version, and whether all is compiled.

    CONTRACT is the number of what programs that call it may rely on: docs/callers.md.
    """
    found = {
        "version": VERSION,
        "contract": CONTRACT,
        "command": own_command(),
        "python": sys.executable,
        "cache": cache_folder(),
        "warm": is_warm(),
    }
    if as_json:
        say_json(found)
    else:
        words = found | {"command": " ".join(own_command()), "warm": "yes" if found["warm"] else "no"}
        print_lines(f"{name:9} {value}" for name, value in words.items())
