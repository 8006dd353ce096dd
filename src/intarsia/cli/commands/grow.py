"""``grow``, ``extend``, ``heal``, ``paint`` and ``tile``: what they say of themselves, and what they do alike."""

from __future__ import annotations

import sys

import click

from ...arguments import SAMPLES
from ...errors import ParameterError, ResourceError
from ...request import Request
from .. import Report, begun
from ..help import HelpfulCommand

BUILT_IN = f"Built-in exemplars: {', '.join('sample:' + s for s in SAMPLES)}. "
EACH = "OUT may hold {stem}, {seed}, {method}, {w} and {h}: with {stem} every picture makes an output of its own."

TOLD = {
    "grow": (
        """Grow a larger texture from EXEMPLARs: pictures, or sets of planes.

        \b
        intarsia grow brick.png -o wall.png --size 2048x1024 --wrap both
        intarsia grow albedo.png --map normal=n.png --map height=h.exr -o out.png
        intarsia grow *.jpg -o "big/{stem}_{seed}.png" --seeds 1..3 --sheet sheet.png
        intarsia grow materials/ -o grown/ --size 2048 --wrap both
        """,
        BUILT_IN + EACH.replace("picture", "exemplar"),
    ),
    "extend": (
        """Continue IMAGE beyond its borders, 100 px to the right if no side is named.

        \b
        intarsia extend wall.png -o wide.png --right 300
        intarsia extend wall.png -o around.png --left 64 --right 64 --top 64 --bottom 64
        intarsia extend meadow.png -o mixed.png --bottom 200 --from gravel.png
        """,
        EACH,
    ),
    "heal": (
        """Fill the holes of IMAGE with what suits there; all other pixels stay, byte for byte.

        \b
        intarsia heal wall.png --mask graffiti.png -o clean.png
        intarsia heal scan.png --mask scratches.png --grow 2 -o whole.png
        intarsia heal cutout.png --mask alpha -o filled.png
        """,
        EACH,
    ),
    "paint": (
        """Paint with textures: each region of TARGET is grown from the parts of the EXEMPLAR that carry its label.

        \b
        intarsia paint coast.png --labels coast_labels.png --target island.png -o island_grown.png
        intarsia paint --several sand.png moss.png -l sand_l.png -l moss_l.png -t map.png -o out.png
        """,
        BUILT_IN + "OUT may hold {seed}, {method}, {w} and {h}; with --seeds every seed makes an output.",
    ),
    "tile": (
        """Make IMAGE tileable: it continues in itself, and only a band along its borders changes.

        \b
        intarsia tile stones.png -o tile.png --preview many.png
        intarsia tile planks.png -o tile.png --axes x --band 96
        intarsia tile albedo.png --map normal=n.png --map height=h.exr -o tile.png
        """,
        EACH,
    ),
}
"""Verb -> its help, and what stands below the options."""


def command_of(verb: str) -> click.Command:
    """Return the command of a verb."""
    return HelpfulCommand(verb, carry_out, *TOLD[verb])


def carry_out(request: Request, report: Report) -> None:
    """Do what was asked for, or only plan it."""
    _ = request.chosen  # a method that cannot be is refused before anything is read
    check_stdout(request, report)
    if request.many is not None and request.out and "{seed}" not in request.out:
        raise ParameterError(f"-o {request.out}: all seeds would write one file; put {{seed}} into the name.")

    from ..batch import Batch

    batch = Batch.plan(request, report)
    begun()
    batch.tell_plan() if request.dry_run else batch.carry_out()


def check_stdout(request: Request, report: Report) -> None:
    """Refuse what would mix a picture with other things on the standard output."""
    if not request.to_stdout:
        return
    if report.as_json:
        raise ParameterError("--json and -o - both want the standard output; write the picture to a file.")
    if sys.stdout is None:
        raise ResourceError("-o -: the standard output is closed; name a file.")
    if sys.stdout.isatty():
        raise ParameterError("-o - would print a picture on the terminal; redirect it, or name a file.")
