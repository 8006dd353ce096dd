"""What a user asked for: the request, each field of it declared once, and what cannot be asked for together."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from ..arguments import MARGIN
from ..blend import Finish, Levelling
from ..choosing.auto import AUTO_METHOD, Auto, By
from ..errors import ParameterError
from ..geometry import Wrap
from ..methods.base import Method, make, method_class
from ..params import Parameter, parameters
from .field import Field, fields_of
from .fields import Asked
from .pictures import names_a_picture, picture_of
from .verbs import BEGUN, MADE, able, known_parameters, usual_parameters

PAGES = (".html", ".png")
"""What the name of a report ends in."""


@dataclass(frozen=True)
class Request(Asked):
    """What a user asked for.

    ``parameters`` are those of the method that were given: values, and names of files where they are pictures.
    ``folder`` is where planes go under the names of their exemplar's files. What a recipe says beyond options are the
    ``rim`` of ``start``, ``finish``, and ``said``, which the new recipe says, too.
    """

    parameters: Mapping[str, Any] = field(default_factory=dict)
    folder: str = ""
    rim: int | None = None
    finish: tuple[Finish, ...] | None = None
    said: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._check_exemplars()
        self._check_method()
        self._check_files()
        if self.verb == "extend" and not any(self.margins):
            raise ParameterError(
                "no side is extended; give at least one of --left, --right, --top and --bottom, in px."
            )
        if self.seed is not None and self.many is not None:
            raise ParameterError("--seed and --seeds exclude each other; drop one.")
        if self.executor is not None and self.dask is not None:
            raise ParameterError("--executor and --dask exclude each other; drop one.")

    def _check_exemplars(self) -> None:
        if self.as_set and self.several:
            raise ParameterError("--set and --several exclude each other; drop one.")
        if self.toroidal and self.crop is not None:
            raise ParameterError("--toroidal does not go with --crop: a part no longer continues in itself; drop one.")
        if self.toroidal and self.flatten:
            raise ParameterError(
                "--flatten does not go with --toroidal: light that continues across the borders has no slope; drop one."
            )

    def _check_method(self) -> None:
        if self.explain and self.method != AUTO_METHOD:
            raise ParameterError("--explain belongs to --method auto; name that, or drop it.")
        if self.by is not None and self.trials is None:
            raise ParameterError(f"--by {self.by} says how trials are compared; give --trials N as well, or drop it.")
        if self.trials is not None and self.method != AUTO_METHOD:
            raise ParameterError("--trials belongs to --method auto; name that, or drop it.")

    def _check_files(self) -> None:
        """Refuse names that no such file can have, and the standard input in more than one place."""
        if self.read.count("-") > 1:
            raise ParameterError("the standard input (-) can be read once; name files for the others.")
        for option, path in (("--map", self.saved if self.verb == "score" else None), ("--start", self.start)):
            if path == "-":
                raise ParameterError(f"a map is read from a file; give {option} the name of a .npz.")
        drawn = [*(path for _, path in self.overlays), self.best_tile]
        if "" in drawn:
            raise ParameterError("an empty file name was given; name the file to write.")
        if drawn.count("-") > 1:
            raise ParameterError("the standard output (-) holds one picture; name files for the others.")
        if self.page is not None and not self.page.lower().endswith(PAGES):
            raise ParameterError(
                f"--report {self.page}: a report is a page or a picture; end its name in .html or .png."
            )
        if self.sheet is not None and not self.sheet.lower().endswith(".png"):
            raise ParameterError(f"--sheet {self.sheet}: a contact sheet is a PNG; end its name in .png.")
        if self.keep and not self.gates:
            raise ParameterError("--keep keeps what misses a --gate, and none is given; give one, or drop it.")
        if self.out == "":
            able_to = "a .zarr, a .tif or a folder" if self.verb == "weave" else "a file, or - for the standard output"
            raise ParameterError(f"-o: an empty name was given; name {able_to}.")
        if self.out == "-" and self.verb == "weave":
            raise ParameterError("-o -: a giant picture does not fit into a pipe; name a .zarr, a .tif or a folder.")
        for option, path in (
            ("--save-map", self.save_map), ("--st-map", self.st_map), ("--preview", self.preview),
            ("--distance-map", self.distance_map and self.distance_map[1]), ("--offset", self.offset),
        ):  # fmt: skip
            if path in ("", "-"):
                raise ParameterError(f"{option} needs the name of a file.")

    @property
    def read(self) -> tuple[str, ...]:
        """The names of all pictures that are read."""
        named = (path for _, path in self.maps)
        more = (*self.holes, *self.labels, *(p for p in (self.target, self.output) if p is not None))
        return (*self.files, *named, *self.masks, *self.usable, *self.donors, *more, *self.drawn.values())

    @property
    def drawn(self) -> dict[str, str]:
        """The files of parameters that are pictures, by their names."""
        known = known_parameters()
        named = {n: v for n, v in self.parameters.items() if n in known and names_a_picture(known[n][0], v)}
        return {**dict(self.pictures), **named}

    @cached_property
    def chosen(self) -> Method | Auto:
        """The method that is named, or the choice among those that have the given parameters; pictures are read."""
        own = {} if self.method == AUTO_METHOD else {p.name: p for p in parameters(method_class(self.method))}
        values = dict(self.parameters)
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


def parameters_of_verb(verb: str) -> dict[str, tuple[Parameter, list[str]]]:
    """The parameters that a verb offers: those of its methods that no field of the verb is called like."""
    taken, slugs = {f.name for f in fields_of_verb(verb)}, able(verb) if verb in MADE else ()
    kept = {name: (p, [s for s in owners if s in slugs]) for name, (p, owners) in known_parameters().items()}
    return {name: (p, owners) for name, (p, owners) in kept.items() if owners and name not in taken}
