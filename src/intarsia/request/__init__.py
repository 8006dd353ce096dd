"""What a user asked for: one noun, its fields declared once, written as words of a command, JSON, recipe or Python.

What a user asked for: the request, each field of it declared once, and what cannot be asked for together.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..arguments import MARGIN
from ..blend import Finish, Levelling
from ..choosing.auto import AUTO_METHOD, Auto, By
from ..errors import ParameterError
from ..geometry import Wrap
from ..methods import Method, make
from ..params import Parameter
from .field import Field, fields_of
from .fields import BEGUN, MADE, Asked, able, known_parameters, parameters_of, usual_parameters
from .pictures import names_a_picture, picture_of


@dataclass(frozen=True)
class Request(Asked):
    """What a user asked for.

    ``parameters`` are those of the method that were given: values, and names of files where they are pictures.
    ``folder`` is where planes go under the names of their exemplar's files. What a recipe says beyond options are the
    ``rim`` of ``start``, ``finish``, and ``said``, which the new recipe says, too.
    """

    parameters: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    folder: str = ""
    rim: int | None = None
    finish: tuple[Finish, ...] | None = None
    said: Mapping[str, Any] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse names that no such file can have, and what does not go together; the first that is wrong is told."""
        drawn = [*(path for _, path in self.overlays), self.best_tile]
        maps = ("--map", self.saved if self.verb == "score" else None), ("--start", self.start)
        beside = (
            ("--save-map", self.save_map), ("--st-map", self.st_map), ("--preview", self.preview),
            ("--distance-map", self.distance_map and self.distance_map[1]), ("--offset", self.offset),
        )  # fmt: skip
        able_to = "a .zarr, a .tif or a folder" if self.verb == "weave" else "a file, or - for the standard output"
        for wrong, line in (
            (self.as_set and self.several, "--set and --several exclude each other; drop one."),
            (self.toroidal and self.crop is not None,
             "--toroidal does not go with --crop: a part no longer continues in itself; drop one."),
            (self.toroidal and self.flatten, "--flatten does not go with --toroidal: light that continues across the "
             "borders has no slope; drop one."),
            (self.explain and self.method != AUTO_METHOD, "--explain belongs to --method auto; name that, or drop it."),
            (self.by is not None and self.trials is None,
             f"--by {self.by} says how trials are compared; give --trials N as well, or drop it."),
            (self.trials is not None and self.method != AUTO_METHOD,
             "--trials belongs to --method auto; name that, or drop it."),
            (self.read.count("-") > 1, "the standard input (-) can be read once; name files for the others."),
            *((path == "-", f"a map is read from a file; give {option} the name of a .npz.") for option, path in maps),
            ("" in drawn, "an empty file name was given; name the file to write."),
            (drawn.count("-") > 1, "the standard output (-) holds one picture; name files for the others."),
            (self.page is not None and not self.page.lower().endswith((".html", ".png")),
             f"--report {self.page}: a report is a page or a picture; end its name in .html or .png."),
            (self.sheet is not None and not self.sheet.lower().endswith(".png"),
             f"--sheet {self.sheet}: a contact sheet is a PNG; end its name in .png."),
            (self.keep and not self.gates,
             "--keep keeps what misses a --gate, and none is given; give one, or drop it."),
            (self.out == "", f"-o: an empty name was given; name {able_to}."),
            (self.out == "-" and self.verb == "weave",
             "-o -: a giant picture does not fit into a pipe; name a .zarr, a .tif or a folder."),
            *((path in ("", "-"), f"{option} needs the name of a file.") for option, path in beside),
            (self.verb == "extend" and not any(self.margins),
             "no side is extended; give at least one of --left, --right, --top and --bottom, in px."),
            (self.seed is not None and self.many is not None, "--seed and --seeds exclude each other; drop one."),
            (self.executor is not None and self.dask is not None,
             "--executor and --dask exclude each other; drop one."),
        ):  # fmt: skip
            if wrong:
                raise ParameterError(line)

    @property
    def read(self) -> tuple[str, ...]:
        """The names of all pictures that are read."""
        named = (path for _, path in self.maps)
        more = (*self.holes, *self.labels, *(p for p in (self.target, self.output) if p is not None))
        return (*self.files, *named, *self.masks, *self.usable, *self.donors, *more, *self.drawn.values())

    @property
    def drawn(self) -> dict[str, str]:
        """The files of parameters that are pictures, by their names."""
        known = known_parameters(self.method)
        named = {n: v for n, v in self.parameters.items() if n in known and names_a_picture(known[n][0], v)}
        return {**dict(self.pictures), **named}

    @cached_property
    def chosen(self) -> Method | Auto:
        """The method that is named, or the choice among those that have the given parameters; pictures are read."""
        own, values = parameters_of(self.method), dict(self.parameters)
        for name, value in values.items():
            p = own.get(name) or known_parameters()[name][0]
            if names_a_picture(p, value):
                values[name] = picture_of(p, value)
        if self.method == AUTO_METHOD:
            laying = self.distance_map is not None and self.verb not in ("heal", "tile")
            return Auto(self.trials or 1, values, laying=laying, by=self.by or By.SCORE)
        return make(self.method, {**usual_parameters(self.verb, self.method), **values})

    @property
    def begun(self) -> bool:
        """Whether the canvas begins with the picture: amid margins, with holes, or with a band along its borders."""
        return self.verb in BEGUN

    @property
    def margins(self) -> tuple[int, int, int, int]:
        """Px on the left, right, top and bottom; with none named, as the source of the idea has it: to the right."""
        sides = (self.left, self.right, self.top, self.bottom)
        if all(px is None for px in sides):
            return 0, MARGIN, 0, 0
        left, right, top, bottom = (px or 0 for px in sides)
        return left, right, top, bottom

    @property
    def closing(self) -> str:
        """The axes along which the result continues in itself."""
        return self.axes if self.verb == "tile" else self.wrap or Wrap.NONE.value

    @property
    def how(self) -> str:
        """How several files are read: as one set of planes, as several exemplars, or by their names."""
        return "set" if self.as_set else "several" if self.several else "auto"

    @property
    def finishing(self) -> tuple[Finish, ...] | None:
        """What is done to the drawn picture; None leaves things as they are meant."""
        if self.finish is not None or self.level is None:
            return self.finish
        return (Levelling(self.level),) if self.level else ()

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of all that is made."""
        return (self.seed or 0,) if self.many is None else self.many

    @property
    def to_stdout(self) -> bool:
        """True where a picture goes to the standard output."""
        return "-" in (self.out, self.best_tile, *(path for _, path in self.overlays))

    @property
    def into_folder(self) -> bool:
        """True where `out` is a folder, to hold a result for every material of `files`."""
        out = self.out or ""
        if out.endswith(("/", os.sep)):
            return True
        plain = out not in ("", "-") and not os.path.splitext(out)[1]
        return (plain or os.path.isdir(out)) and any(os.path.isdir(path) for path in self.files)


FIELDS = fields_of(Request)
"""All that may be asked for, in the order in which help lists it."""


def fields_of_verb(verb: str) -> tuple[Field, ...]:
    """The fields that a verb has, as it has them."""
    return tuple(f.of(verb) for f in FIELDS if verb in f.verbs)


def parameters_of_verb(verb: str, slug: str | None = None) -> dict[str, tuple[Parameter, list[str]]]:
    """The parameters that a verb offers: those of its methods, or of one, that no field of the verb is called like."""
    taken, slugs = {f.name for f in fields_of_verb(verb)}, able(verb) if verb in MADE else ()
    kept = {name: (p, [s for s in owners if s in slugs]) for name, (p, owners) in known_parameters(slug).items()}
    return {name: (p, owners) for name, (p, owners) in kept.items() if owners and name not in taken}
