"""``intarsia studio``: the server of a web page on this machine. Imports nothing heavy before the work."""

from __future__ import annotations

from contextlib import suppress
from importlib.util import find_spec

import click

from ...foundation import ResourceError
from .. import Interrupted, callers, debug_option, one_line
from ..verbs import FILE

NEEDED = {"starlette": "starlette", "uvicorn": "uvicorn", "python_multipart": "python-multipart"}
"""Modules that the server needs -> the names of their packages."""


@click.command(name="studio")
@click.argument("files", nargs=-1, type=FILE, metavar="[FILES]...")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, metavar="N",
    help="Listen there. By default at a free port that the folder keeps.",
)
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@click.option(
    "--folder", type=FILE, default="intarsia-studio", show_default=True, metavar="DIR",
    help="Keep exemplars and results there.",
)  # fmt: skip
@debug_option
def command(files: tuple[str, ...], port: int, no_browser: bool, folder: str) -> None:
    """Open a page on this machine: drop a picture, see what is in it, grow, paint, heal, look, keep.

    FILES are its first exemplars. Nothing leaves this machine; Ctrl-C ends the studio.

    \b
    intarsia studio
    intarsia studio stones.png --folder walls
    """
    missing = [name for module, name in NEEDED.items() if find_spec(module) is None]
    if missing:
        raise ResourceError(
            f"the studio needs {' and '.join(missing)}; install what is missing: pip install {' '.join(missing)} "
            "(in a checkout make studio does it)."
        )
    from ...studio.serving import serve

    with suppress(Interrupted):
        serve(files, folder, port, not no_browser, lambda line: callers.say(one_line(line)))
