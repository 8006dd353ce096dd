"""Where a file or a value can be given on the command line, read off the commands themselves.

A command that is added later is covered at once: its file parameters are found, and each must be known here as one
that is read (``SOUND``) or written (``WRITTEN``).
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import click
import numpy as np
from click.testing import CliRunner

import intarsia as ia
from intarsia import files
from intarsia.cli import COMMANDS, cli
from intarsia.cli.verbs import parameters_of

SOUND = {
    "files": "a.png",
    "maps": "a.png",
    "masks": "m.png",
    "usable": "m.png",
    "start": "map.npz",
    "donors": "b.png",
    "holes": "hole.png",
    "labels": "l.png",
    "output": "b.png",
    "target": "t.png",
    "saved": "map.npz",
    "picture": "grown.png",
    "pictures": "j.png",
    "jitter_output": "j.png",
    "jitter_exemplar": "m.png",
    "feature": "l.png",
    "angle": "j.png",
    "zoom": "j.png",
}
"""Parameters that name files to read -> a sound one of those that `make_sound` makes, 24x20 px."""

WRITTEN = {"out": "out.png", "save_map": "o.npz", "sheet": "o.png", "page": "o.html", "preview": "o.png"}
"""Parameters that name files to write -> a name that their format allows."""

GIANT = "out.tif"
"""What `weave` writes in place of a picture; it goes on with what it began."""

SORT = {"saved": "map", "start": "map", "picture": "recipe"}
"""What a parameter reads, where that is no picture."""

NAMED = {"maps": "height", "pictures": "jitter_output"}
"""What stands before the name of a file."""

GRAY = {"pictures": (0, 1), "jitter_output": (0, 1), "jitter_exemplar": (0, 1), "feature": (0, 1),
        "angle": (-180, 180), "zoom": (0.25, 4)}  # fmt: skip
"""Parameters that read one number for each pixel, and no colours -> the least and the greatest of them."""

OVER_OUTPUT = ("jitter_output", "angle", "zoom")
"""Those of them that lie over the output."""

LABELS = ("masks", "usable", "holes", "labels", "target")
"""Parameters that read numbers rather than colours: 32 bits are welcome."""

ALSO = {"render": ("files",), "replay": ("files",)}
"""Parameters that a command can do without only for built-in exemplars."""

SMALL = {"grow": ("--size", "26x22"), "weave": ("--size", "28x24", "--method", "repeat"), "extend": ("--right", "5"),
         "analyze": ("--json",), "score": ("--json",), "export": ("--for", "blender"),
         "tileset": ("--size", "16")}  # fmt: skip
"""What keeps the work of a sound line short."""

BESIDE = {
    ("replay", "maps"): {"picture": "planes.png"},
    ("replay", "masks"): {"picture": "healed.png", "usable": "m.png"},
    ("replay", "usable"): {"picture": "healed.png", "masks": "hole.png"},
    ("replay", "donors"): {"picture": "donated.png", "masks": "hole.png"},
    ("replay", "labels"): {"picture": "painted.png", "target": "t.png"},
    ("replay", "target"): {"picture": "painted.png", "labels": "l.png"},
    ("replay", "start"): {"picture": "continued.png"},
    ("replay", "pictures"): {"picture": "jittered.png"},
}
"""Command and parameter -> what must stand beside it, so that it is asked for."""

MADE = {
    "grown": "grow a.png --size 26x22 --patch 8 --save-map map.npz",
    "planes": "grow a.png --size 26x22 --patch 8 --map height=a.png",
    "healed": "heal a.png --patch 6 --mask hole.png --usable m.png",
    "donated": "heal a.png --patch 6 --mask hole.png --from b.png",
    "painted": "paint a.png --patch 8 --labels l.png --target t.png",
    "jittered": "grow a.png --size 26x22 --method parallel-controllable --jitter-output j.png",
}
"""How the pictures that replay repeats are made."""


@cache
def command(name: str) -> click.Command:
    found = cli.get_command(click.Context(cli), name)
    assert found is not None
    found.params = found.params or parameters_of(name)
    return found


@cache
def parameter(name: str, field: str) -> click.Parameter:
    return next(p for p in command(name).params if p.name == field)


@cache
def names_a_file(p: click.Parameter) -> bool:
    if p.name == "called":  # what others name
        return False
    kinds = p.type.types if isinstance(p.type, click.Tuple) else [p.type]
    return any(isinstance(k, click.Path | click.File) for k in kinds) or "FILE" in (p.make_metavar(CONTEXT) or "")


CONTEXT = click.Context(click.Command("intarsia"))


STAYS = ("studio", "install-plugin")
"""Commands that serve until they are stopped, or copy; tests/studio and tests/plugins give them files."""


@cache
def file_parameters(name: str) -> tuple[str, ...]:
    """The parameters of a command that name files, in their order; none of one that stays."""
    if name in STAYS:
        return ()
    found = [str(p.name) for p in command(name).params if names_a_file(p)]
    unknown = set(found) - set(SOUND) - set(WRITTEN)
    assert not unknown, f"{name}: say in SOUND or WRITTEN whether {unknown} are read or written"
    return tuple(found)


def said(name: str, field: str, value: str) -> list[str]:
    """A parameter and its value, as words of a command line."""
    p = parameter(name, field)
    option = [] if isinstance(p, click.Argument) else [max(p.opts, key=len)]
    if field in NAMED:
        return [*option, f"{NAMED[field]}={value}"]
    return [*option, "0,0", value] if isinstance(p.type, click.Tuple) else [*option, value]


def line(name: str, **given: str) -> list[str]:
    """A sound command line with all that a command needs; `given` replaces values, or adds parameters."""
    known = file_parameters(name)
    needed = [f for f in known if parameter(name, f).required or f == "out" or f in ALSO.get(name, ())]
    for field in tuple(given):
        given = BESIDE.get((name, field), {}) | given
    words = [name, *SMALL.get(name, ())]
    if any(p.name == "quiet" for p in command(name).params):
        words.append("--quiet")
    if name == "weave" and set(given) & set(GRAY):
        words += ["--method", "parallel-controllable"]
    for field in dict.fromkeys([*needed, *given]):
        usual = GIANT if (name, field) == ("weave", "out") else (SOUND | WRITTEN)[field]
        words += said(name, field, given.get(field) or usual)
    return words


@dataclass(frozen=True)
class Role:
    """A way to give a file to a command: as which parameter, and how."""

    command: str
    field: str
    how: str = "path"  # or stdin, folder, second

    @property
    def sort(self) -> str:
        """What is to be read: a picture, a map or a recipe."""
        return SORT.get(self.field, "picture")

    def words(self, given: Given) -> tuple[list[str], bytes | None] | None:
        """The command line, and the standard input; None where this file cannot be given so."""
        if self.how == "path":
            return line(self.command, **{self.field: given.path}), None
        if self.how == "second":
            return [*line(self.command), "--several", given.path], None
        if given.data is None:
            return None
        if self.how == "stdin":
            return line(self.command, **{self.field: "-"}), given.data
        return None if given.folder is None else (line(self.command, **{self.field: given.folder}), None)


@dataclass(frozen=True)
class Given:
    """A bad file: its path, its bytes if it has any, and its folder if it is the only picture there."""

    path: str
    data: bytes | None
    folder: str | None

    @classmethod
    def of(cls, path: Path) -> Given:
        """Look at a file once, to give it in many roles."""
        plain = os.path.isfile(path) and not path.is_symlink() and path.stat().st_size < 1 << 22
        alone = plain and path.suffix in files.formats.SUFFIXES
        return cls(os.fspath(path), path.read_bytes() if plain else None, os.fspath(path.parent) if alone else None)


def roles(name: str) -> Iterator[Role]:
    """All ways to give a file to a command."""
    for field in file_parameters(name):
        if field in WRITTEN:
            continue
        yield Role(name, field)
        yield Role(name, field, "stdin")
        if field in ("files", "donors"):
            yield Role(name, field, "folder")
        p = parameter(name, field)
        if isinstance(p, click.Argument) and p.nargs == -1 and any(q.name == "several" for q in command(name).params):
            yield Role(name, field, "second")


READERS = [name for name in COMMANDS if any(True for _ in roles(name))]
"""The commands that read files."""


def make_sound(folder: Path) -> None:
    """Make one sound file of every sort."""
    here = os.getcwd()
    os.chdir(folder)
    y, x = np.mgrid[:20, :24]
    colour = np.stack([(x * 7 + y * 3) % 256, (x * y * 5) % 253, (x * 11 + y * 13) % 251], axis=2).astype(np.uint8)
    left = np.where(x < 12, 0, 255).astype(np.uint8)
    files.write("a.png", ia.Plane(colour))
    files.write("b.png", ia.Plane(colour[::-1]))
    files.write("m.png", ia.Plane(np.full((20, 24), 255, np.uint8)))
    files.write("hole.png", ia.Plane(((abs(x - 12) < 3) & (abs(y - 10) < 3)).astype(np.uint8) * 255))
    files.write("l.png", ia.Plane(left))
    files.write("j.png", ia.Plane(np.resize(colour[:, :, 0], (22, 26))))
    files.write("t.png", ia.Plane(left[:, ::-1]))
    for name, words in MADE.items():
        result = CliRunner().invoke(cli, [*words.split(), "--output", f"{name}.png", "--quiet"])
        assert result.exit_code == 0, result.stderr
    continued = ia.synthesize("a.png", (22, 26), ia.ImageQuilting(patch=8), start=ia.SourceMap.load("map.npz"))
    files.write("continued.png", continued.render(), recipe=continued.recipe_text)
    os.chdir(here)
