"""What a user asked for, as nouns that the commands hand on. Imports nothing heavy."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..choosing.auto import Auto
from ..errors import ParameterError
from ..levelling import Finish
from ..methods.base import Method

PAGES = (".html", ".png")
"""What the name of a report ends in."""


def check_page(path: str | None) -> None:
    """Refuse a name that no report can have."""
    if path is not None and not path.lower().endswith(PAGES):
        raise ParameterError(f"--report {path}: a report is a page or a picture; end its name in .html or .png.")


@dataclass(frozen=True)
class Inputs:
    """The pictures to grow from, and what of them may be used.

    ``how`` says how several files are read: as one set of planes, as several exemplars, or by their names.
    ``scale`` is the n of 1/n; `magnify` says how many times larger pictures are drawn than they are grown. `donors` are
    pictures from which new pixels come in place of those of `files`. `packed` says what a packed map
    holds, as in R=ao,G=roughness,B=metallic, and `weights` how much planes count in matching.
    """

    files: tuple[str, ...]
    maps: tuple[tuple[str, str], ...] = ()
    masks: tuple[str, ...] = ()
    alpha: str = "auto"
    avoid: tuple[int, int, int] | None = None
    toroidal: bool = False
    crop: tuple[int, int, int, int] | None = None
    scale: int = 1
    how: str = "auto"
    flatten: bool = False
    donors: tuple[str, ...] = ()
    magnify: int = 1
    packed: str | None = None
    weights: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        if self.toroidal and self.crop is not None:
            raise ParameterError("--toroidal does not go with --crop: a part no longer continues in itself; drop one.")
        if self.toroidal and self.flatten:
            raise ParameterError(
                "--flatten does not go with --toroidal: light that continues across the borders has no slope; drop one."
            )
        self.check_standard_input()

    def check_standard_input(self, *further: str) -> None:
        """Refuse the standard input in more than one place, `further` files of the command counted."""
        named = [*self.files, *(path for _, path in self.maps), *self.masks, *self.donors, *further]
        if named.count("-") > 1:
            raise ParameterError("the standard input (-) can be read once; name files for the others.")

    def recipe(self) -> dict[str, Any]:
        """Return what a recipe must say of it: all that differs from the plain file, but no path."""
        said = {
            "alpha": self.alpha, "avoid": self.avoid and "#" + bytes(self.avoid).hex(), "toroidal": self.toroidal,
            "crop": self.crop and list(self.crop), "scale": f"1/{self.scale}", "flatten": self.flatten,
            "magnify": self.magnify, "packed": self.packed, "weights": dict(self.weights),
        }  # fmt: skip
        return {name: said[name] for name in said if getattr(self, name) != getattr(Inputs, name)}


@dataclass(frozen=True)
class Labels:
    """What is where: a label picture for each exemplar, one for the output, and how much they count."""

    sources: tuple[str, ...]
    target: str
    weight: float
    reach: int


@dataclass(frozen=True)
class Border:
    """The band along the borders of a picture that is to continue in itself along `axes`.

    `band` is its width in px, None: one that suits; `size` (width, height) is cut out of the picture's middle first,
    None: what holds whole numbers of its periods.
    """

    axes: str = "both"
    band: int | None = None
    size: tuple[int, int] | None = None


@dataclass(frozen=True)
class Begin:
    """What the canvas starts with: the picture in the middle of margins, or with holes.

    `margins` are left, right, top, bottom in px; `holes` one mask for each picture, or ``alpha``; `grow` enlarges
    the holes, None as far as a rim of the defect is seen; `edge` px along their edge are filled again, pixel by pixel.
    `border`: a band along the borders is grown anew, so that the picture continues in itself.
    """

    margins: tuple[int, int, int, int] | None = None
    holes: tuple[str, ...] = ()
    grow: int | None = 0
    edge: int = 0
    border: Border | None = None


@dataclass(frozen=True)
class Wish:
    """What to grow: the method with its parameters, the size (width, height), how it closes and how it is joined.

    `begin` says what is there already, if anything is; `start` names a saved map to continue, and how deep from its
    holes it may be replaced. With `labels` the size is that of their target. `explain`: tell how the method was chosen.
    `said` is what the recipe says besides. `repair`: how often the worst seams are looked for. `pictures` are the files
    of parameters that are pictures, by their names.
    """

    method: Method | Auto
    size: tuple[int, int] | None = None
    wrap: str = "none"
    feather: int | None = None
    mixing: str | None = None
    begin: Begin | None = None
    labels: Labels | None = None
    start: tuple[str, int | None] | None = None
    explain: bool = False
    said: Mapping[str, Any] = field(default_factory=dict)
    finish: tuple[Finish, ...] | None = None
    repair: int = 0
    pictures: Mapping[str, str] = field(default_factory=dict)

    @property
    def files(self) -> tuple[str, ...]:
        """The files to read beside the exemplars: masks of holes, labels and their target, pictures of parameters."""
        holes = (*self.pictures.values(), *(() if self.begin is None else self.begin.holes))
        return holes if self.labels is None else (*holes, *self.labels.sources, self.labels.target)


@dataclass(frozen=True)
class Work:
    """How often the work is done, and whether: one seed or several, a contact sheet of all, or a plan alone."""

    seed: int | None = None
    many: tuple[int, ...] | None = None
    sheet: str | None = None
    dry_run: bool = False

    def __post_init__(self) -> None:
        if self.seed is not None and self.many is not None:
            raise ParameterError("--seed and --seeds exclude each other; drop one.")
        if self.sheet is not None and not self.sheet.lower().endswith(".png"):
            raise ParameterError(f"--sheet {self.sheet}: a contact sheet is a PNG; end its name in .png.")

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of all that is made."""
        return (self.seed or 0,) if self.many is None else self.many


@dataclass(frozen=True)
class Targets:
    """The files to write: the picture, planes beside it, and what else was asked for.

    With `layers` all planes are layers of one file. Without `out` the pictures are named after the exemplars and what
    is `done` with them, such as grown; with `folder` they lie there, named as the files of the exemplar are. `page` is
    the report; what misses one of `gates` is written only to `keep` it.
    """

    out: str
    depth: str | None = None
    force: bool = False
    save_map: str | None = None
    st_map: str | None = None
    distance_map: tuple[tuple[int, int], str] | None = None
    done: str = ""
    folder: str = ""
    page: str | None = None
    gates: tuple[tuple[str, float], ...] = ()
    keep: bool = False
    preview: str | None = None  # the result, `tiles` times side by side along each axis
    tiles: int = 3
    offset: str | None = None  # the picture as it was, moved by half its size
    layers: bool = False

    def __post_init__(self) -> None:
        check_page(self.page)
        if self.keep and not self.gates:
            raise ParameterError("--keep keeps what misses a --gate, and none is given; give one, or drop it.")
        if not (self.out or self.done or self.folder):
            raise ParameterError("-o: an empty name was given; name a file, or - for the standard output.")
        distances = None if self.distance_map is None else self.distance_map[1]
        named = (
            ("--save-map", self.save_map), ("--st-map", self.st_map), ("--distance-map", distances),
            ("--preview", self.preview), ("--offset", self.offset),
        )  # fmt: skip
        for option, path in named:
            if path is not None and path in ("", "-"):
                raise ParameterError(f"{option} needs the name of a file.")

    @property
    def to_stdout(self) -> bool:
        """True where the picture goes to the standard output."""
        return self.out == "-"

    def into_folder(self, sources: tuple[str, ...]) -> bool:
        """True where `out` is a folder, to hold a result for every material of `sources`."""
        if self.out.endswith(("/", os.sep)):
            return True
        plain = self.out not in ("", "-") and not os.path.splitext(self.out)[1]
        return (plain or os.path.isdir(self.out)) and any(os.path.isdir(path) for path in sources)


@dataclass(frozen=True)
class Loom:
    """Where and how a giant picture is made."""

    out: str = ""  # named after the exemplars, if not given
    origin: tuple[int, int] = (0, 0)  # x, y
    chunk: int | None = None
    executor: str | None = None
    dask: str | None = None
    force: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        if self.executor is not None and self.dask is not None:
            raise ParameterError("--executor and --dask exclude each other; drop one.")
        if self.out == "-":
            raise ParameterError("-o -: a giant picture does not fit into a pipe; name a .zarr, a .tif or a folder.")

    @property
    def who(self) -> str | None:
        """The executor in the words of the library."""
        return self.dask if self.dask is not None else self.executor
