"""The request of a user, and its codecs: words of a command line, JSON of a job of the studio, and recipes.

Fields are declared once (fields.py). A recipe holds no paths. Keys of a job are the names of options; a value is a
number, a text or a list. Words of a command leave out defaults, and are in the order of the table.
"""

from __future__ import annotations

import dataclasses
import os
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..foundation import AUTO_METHOD, MARGIN, InputError, ParameterError, lazy, whole
from ..foundation.blend import Blend, Finish, Levelling
from ..foundation.geometry import Wrap
from ..foundation.params import KINDS, OVER, Parameter, parameters, parse
from ..methods import Method, keeps_lattice, known_parameters, make, method_of, parameters_of, renamed
from .field import FLAG, Field, fields_of
from .fields import METHOD_VERBS, PICTURE_VERBS, SETS, Options, default_parameters, methods_for

if TYPE_CHECKING:
    from ..choosing import auto
    from ..foundation import field as varying
else:  # where no method is named
    auto = lazy("intarsia.choosing.auto")


Json = dict[str, Any]
"""An object of JSON: a recipe, an answer, the options of a job."""


@dataclass(frozen=True)
class Request(Options):
    """What a user asked for: a verb and the values of its options.

    ``parameters`` are the given parameters of the method: values, or file names of pictures. ``folder``: where planes
    are written under the names of the exemplar's files. A recipe also sets the ``rim`` of ``start``, ``finish``, and
    ``said``: entries that are copied into the new recipe.
    """

    parameters: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    folder: str = ""
    rim: int | None = None
    finish: tuple[Finish, ...] | None = None
    said: Mapping[str, Any] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raise ParameterError for the first wrong file name or contradiction between options."""
        maps = ("--map", self.saved if self.verb == "score" else None), ("--start", self.start)
        beside = (
            ("--save-map", self.save_map), ("--preview", self.preview),
        )  # fmt: skip
        able_to = "a .zarr, a .tif or a folder" if self.verb == "weave" else "a file, or - for the standard output"
        for wrong, line in (
            (self.as_set and self.several, "--set and --several exclude each other; drop one."),
            (self.toroidal and self.crop is not None,
             "--toroidal does not go with --crop: a part no longer continues in itself; drop one."),
            (self.toroidal and self.flatten, "--flatten does not go with --toroidal: light that continues across the "
             "borders has no slope; drop one."),
            (self.explain and self.method != AUTO_METHOD, "--explain belongs to --method auto; name that, or drop it."),
            (self.trials is not None and self.method != AUTO_METHOD,
             "--trials belongs to --method auto; name that, or drop it."),
            (self.read.count("-") > 1, "the standard input (-) can be read once; name files for the others."),
            *((path == "-", f"a map is read from a file; give {option} the name of a .npz.") for option, path in maps),
            (self.page is not None and not self.page.lower().endswith(".html"),
             f"--report {self.page}: a report is a page; end its name in .html."),
            (self.sheet is not None and not self.sheet.lower().endswith(".png"),
             f"--sheet {self.sheet}: a contact sheet is a PNG; end its name in .png."),
            (self.out == "", f"-o: an empty name was given; name {able_to}."),
            (self.out == "-" and self.verb == "weave",
             "-o -: a giant picture does not fit into a pipe; name a .zarr or a .tif."),
            (self.out == "-" and self.verb in SETS, "-o -: a set does not fit into a pipe; name a folder."),
            *((path in ("", "-"), f"{option} needs the name of a file.") for option, path in beside),
            (self.verb == "extend" and not any(self.margins),
             "no side is extended; give at least one of --left, --right, --top and --bottom, in px."),
            (self.seed is not None and self.many is not None, "--seed and --seeds exclude each other; drop one."),
        ):  # fmt: skip
            if wrong:
                raise ParameterError(line)

    @property
    def read(self) -> tuple[str, ...]:
        """All pictures that are read, by name."""
        named = (path for _, path in self.maps)
        more = (*self.holes, *self.labels, *(p for p in (self.target, self.output) if p is not None))
        return (*self.files, *named, *self.masks, *self.usable, *self.donors, *more, *self.drawn.values())

    @property
    def drawn(self) -> dict[str, str]:
        """Parameter -> file, for parameters that are pictures."""
        known = known_parameters(self.method)
        named = {n: v for n, v in self.parameters.items() if n in known and names_a_picture(known[n][0], v)}
        return {**dict(self.pictures), **named}

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of this name of the method, or, if it has none, of another method."""
        return parameters_of(self.method).get(name) or known_parameters()[name][0]

    def written(self, name: str) -> str:
        """Return a given parameter as text of an option."""
        return self.drawn.get(name) or KINDS[self.parameter(name).kind].text(self.parameters[name])

    @cached_property
    def chosen(self) -> Method | auto.Auto:
        """The named method, or the choice among methods that have the given parameters; pictures are read."""
        values = dict(self.parameters)
        for name, value in values.items():
            if names_a_picture(p := self.parameter(name), value):
                values[name] = picture_of(p, value)
        if self.method == AUTO_METHOD:
            return auto.Auto(self.trials or 1, values)
        return make(self.method, {**default_parameters(self.verb, self.method), **values})

    @property
    def begun(self) -> bool:
        """Whether the canvas starts with the picture: with margins, with holes, or with a band along its borders."""
        return self.verb in PICTURE_VERBS

    @property
    def margins(self) -> tuple[int, int, int, int]:
        """Px to add at the left, right, top and bottom; by default to the right only, as in the source of the idea."""
        sides = (self.left, self.right, self.top, self.bottom)
        if all(px is None for px in sides):
            return 0, MARGIN, 0, 0
        left, right, top, bottom = (px or 0 for px in sides)
        return left, right, top, bottom

    @property
    def wrap_axes(self) -> str:
        """The axes along which the result tiles."""
        return self.axes if self.verb == "tile" else self.wrap or Wrap.NONE.value

    @property
    def how(self) -> str:
        """How several files are grouped: "set" (planes of one exemplar), "several" (exemplars), or "auto" (by name)."""
        return "set" if self.as_set else "several" if self.several else "auto"

    @property
    def corrections(self) -> tuple[Finish, ...] | None:
        """Corrections of the rendered picture; None: those that the method or the choice sets."""
        if self.finish is not None or self.even_tone is None:
            return self.finish
        return (Levelling(self.even_tone),) if self.even_tone else ()

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of all outputs."""
        return (self.seed or 0,) if self.many is None else self.many

    @property
    def into_folder(self) -> bool:
        """Whether `out` is a folder, for a result of every material of `files`."""
        out = self.out or ""
        if out.endswith(("/", os.sep)):
            return True
        plain = out not in ("", "-") and not os.path.splitext(out)[1]
        return (plain or os.path.isdir(out)) and any(os.path.isdir(path) for path in self.files)


FIELDS = fields_of(Request)
"""All fields, in the order in which help lists them."""

HEADINGS = tuple(dict.fromkeys(field.heading for field in FIELDS))
"""Headings of the options in help, in this order."""


def fields_of_verb(verb: str) -> tuple[Field, ...]:
    """Return the fields of a verb, with what is special to it."""
    return tuple(f.of(verb) for f in FIELDS if verb in f.verbs)


def parameters_of_verb(verb: str, slug: str | None = None) -> dict[str, tuple[Parameter, list[str]]]:
    """Return the parameters of methods that a verb offers, or of one method; none has the name of a field."""
    taken, slugs = {f.name for f in fields_of_verb(verb)}, methods_for(verb) if verb in METHOD_VERBS else ()
    kept = {name: (p, [s for s in owners if s in slugs]) for name, (p, owners) in known_parameters(slug).items()}
    return {name: (p, owners) for name, (p, owners) in kept.items() if owners and name not in taken}


def names_a_picture(p: Parameter, text: Any) -> bool:
    """Return whether a value of a parameter is a file name: neither a number nor one of its words."""
    if p.kind not in OVER or not isinstance(text, str) or text in p.choices:
        return False
    try:
        float(text)
    except ValueError:
        return True
    return False


def picture_of(p: Parameter, path: str) -> varying.Field:
    """Read a gray picture of any depth as the field of a parameter; InputError if it is none."""
    import numpy as np

    from .. import files
    from ..foundation import field as varying
    from ..model.image import Kind

    if not path or "\0" in path:
        raise InputError(f"{p.name}: {path!r} is no name of a file; choose another.")
    plane = files.read_plane(path, Kind.DATA)
    pixels, name = plane.samples, "stdin" if path == "-" else path
    if plane.channels in (2, 4):
        if (pixels[:, :, -1] != pixels[0, 0, -1]).any():
            raise InputError(f"{name} is transparent in parts; {p.name} takes a gray picture without opacity.")
        pixels = pixels[:, :, :-1]
    if not all(np.array_equal(pixels[:, :, 0], pixels[:, :, c], equal_nan=True) for c in range(1, pixels.shape[2])):
        raise InputError(f"{name} is a colour picture; {p.name} takes a gray one.")
    try:
        return varying.Field(pixels[:, :, 0], p.low, p.high)
    except InputError as e:
        raise InputError(f"{p.name}: of {name}, {e}") from None


def with_pictures(recipe: Json, pictures: Mapping[str, str], name: str) -> Json:
    """Return the recipe of `name`, which holds hashes of them, with its pictures read from files.

    InputError if a hash differs.
    """
    values, known = recipe.get("parameters"), parameters_of(recipe.get("method"))
    recorded = {k: v for k, v in values.items() if isinstance(v, dict)} if isinstance(values, dict) else {}
    asked = {k: v for k, v in recorded.items() if k in known and known[k].kind in OVER}
    for given in pictures:
        if given not in asked:
            raise ParameterError(f"{name} was made without a picture as {given}; drop --picture {given}=FILE.")
    found: Json = {}
    for key, was in asked.items():
        if "function" in was:
            told_by = f"{key} of {name} is the function {was['function']}"
            raise InputError(f"{told_by}, which no recipe holds; run the program again that made it.")
        if key not in pictures:
            raise ParameterError(f"{name} was made with a picture as {key}; name it with --picture {key}=FILE.")
        found[key] = picture_of(known[key], pictures[key])
        if found[key].as_recipe != was:
            raise InputError(f"{pictures[key]} is another picture than the recipe has as {key}; give the same file.")
    return recipe | {"parameters": values | found} if found and isinstance(values, dict) else recipe


def to_argv(request: Request, joined: bool = False) -> list[str]:
    """Return the words of the command line after ``intarsia``; `joined`: option and value as one word."""
    arguments: list[str] = []
    options: list[str] = []
    for field in fields_of_verb(request.verb):
        value = getattr(request, field.name)
        if value != field.default:
            said = options if field.flags else arguments
            said += _said(field, value, joined)
    return [request.verb, *arguments, *options, *parameter_words(request, joined)]


def to_line(request: Request, joined: bool = False) -> str:
    """Return the request as a command line, quoted for a shell."""
    return shlex.join(["intarsia", *to_argv(request, joined)])


def repeated(request: Request, sets: Sequence[Mapping[str, str]], method: Method, seed: int, **more: Any) -> Request:
    """Return the request that makes the same picture with method and seed named, from the planes and masks of `sets`.

    Fields that do not bear on the picture are left out; `more` replaces fields.
    """
    further = [plane for found in sets for plane in list(found.items())[1:]]
    finish = request.corrections
    named: Json = {
        "files": tuple(next(iter(found.values())) for found in sets),
        "maps": tuple(plane for plane in further if plane[0] != "mask"),
        "masks": tuple(path for name, path in further if name == "mask"),
        "method": method.slug,
        "parameters": values_of(method),
        "pictures": tuple(request.drawn.items()),
        "seed": seed,
        "even_tone": None if finish is None else finish[0].radius if finish else 0,
        "finish": None,
        "repair": 0 if keeps_lattice(method) else request.repair,  # it was not repaired
    }
    passing = {field.name: field.default for field in FIELDS if field.without_effect}
    return replace(request, **passing | named | more)


def _said(field: Field, value: Any, joined: bool) -> list[str]:
    texts = list(map(field.kind.text, value if field.many else [value]))
    if not field.flags or field.kind is FLAG:
        return [field.flag] if field.flags else texts
    short = field.flags[0]
    return [word for text in texts for word in _option(short if len(short) == 2 else field.flag, text, joined)]


def _option(flag: str, text: str, joined: bool) -> list[str]:
    return [f"{flag}={text}"] if joined and flag.startswith("--") else [flag, text]


def parameter_words(request: Request, joined: bool = False) -> list[str]:
    """Return the options of the method's parameters that differ from the defaults of the verb."""
    usual = {name: p.default for name, p in parameters_of(request.method).items()}
    usual |= default_parameters(request.verb, request.method)
    told = [n for n, value in request.parameters.items() if n not in usual or value != usual[n]]
    return [word for n in told for word in _option("--" + n.replace("_", "-"), request.written(n), joined)]


def values_of(method: Method) -> Json:
    """Return the parameters of a method by name."""
    return {p.name: getattr(method, p.name) for p in parameters(method)}


VERBS = {"extend": "extend", "tile": "tile", "heal": "heal", "guide": "paint"}
"""Key of a recipe -> its verb; `grow` if it has none of them."""


def inputs_of(request: Request) -> Json:
    """Return what a recipe records of how the exemplars are used: the fields that are not default."""
    told = {}
    for field in FIELDS:
        value = getattr(request, field.name)
        if field.of_exemplars and value != field.default:
            told[field.name] = dict(value) if field.many else field.kind.json(value)
    return told


def from_recipe(recipe: Mapping[str, Any], given: Request, called: str) -> Request:
    """Return the request of a recipe, with the files of `given`, whose other fields override the recipe.

    InputError, with the name `called`, if the recipe is damaged.
    """
    try:
        return _filled(recipe, given)
    except ParameterError as e:
        raise InputError(f"{called} cannot be followed: {e}") from None
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"{called} is damaged, or of an unknown version; grow it again.") from None


def _filled(recipe: Mapping[str, Any], given: Request) -> Request:
    verb = next((verb for word, verb in VERBS.items() if word in recipe), "grow")
    method, joined = method_of(recipe["method"], recipe["parameters"]), Blend.of(recipe["blend"])
    told, names = _fields(recipe, given), [(str(e["sha256"]), e.get("name", ""))[1] for e in recipe["exemplars"]]
    (width, height), times = recipe["size"], told.get("magnify", given.magnify)
    if not names:
        raise ValueError
    told |= {"method": method.slug, "parameters": values_of(method), "finish": joined.finish, "usable": ()}
    told |= {"files": given.files or tuple(names), "said": {k: recipe[k] for k in ("auto",) if k in recipe}}
    told["masks"] = given.usable + (() if verb == "heal" else given.masks)
    if verb == "extend":
        left, right, top, bottom = map(whole, recipe["extend"])
        told |= {"left": left, "right": right, "top": top, "bottom": bottom}
    if verb == "heal":
        told["holes"] = ("alpha",) if recipe["heal"].get("mask") == "alpha" else given.masks
    if verb == "tile":
        told["axes"] = told["wrap"]
    if verb not in PICTURE_VERBS:
        from ..model.canvas import Canvas

        Canvas(height, width)
        told["size"] = width * times, height * times
        if "start" in recipe and "rim" in recipe:
            told["rim"] = whole(recipe["rim"])
    return replace(given, verb=verb, picture=None, **told)


def _fields(recipe: Mapping[str, Any], given: Request) -> Json:
    """Return the fields that a recipe holds, without those that are given."""
    told = {}
    for field in FIELDS:
        root, _, leaf = field.recipe.partition(".")
        if root in recipe and getattr(given, field.name) == field.default:
            value = recipe[root]
            if field.of_exemplars and leaf not in value:
                continue
            if leaf:
                value = value[leaf]
            told[field.name] = field.of_json(value)
    if not {"seed", "wrap", "size"} <= set(told):
        raise KeyError
    return told


def from_json(verb: str, given: Mapping[str, Any], **more: Any) -> Request:
    """Return the request of a verb and the options of a job; `more` are fields that are no options of a job.

    ParameterError, with the name of the option, if a value is invalid or missing.
    """
    values, given = dict(more), renamed(given)
    for field in fields_of_verb(verb):
        if field.flags and field.name not in more:
            if (value := given.get(field.key)) is not None:
                values[field.name] = _read(field, value)
            elif field.required:
                flags = " / ".join(f"'{flag}'" for flag in field.flags)
                raise ParameterError(f"Missing option {flags}.")
    return Request(verb, **values, parameters=parameter_values(verb, values.get("method", AUTO_METHOD), given))


def parameter_values(verb: str, slug: str, given: Mapping[str, Any]) -> Json:
    """Return the parameters of methods among given options, read as those of the method `slug`."""
    own, fields, found = parameters_of(slug), {f.name for f in fields_of_verb(verb)}, Json()
    others = any(value is not None for name, value in given.items() if name not in fields and name not in own)
    for name, (p, _) in parameters_of_verb(verb, None if others else slug).items():
        if given.get(name) is not None:
            p, text = own.get(name, p), text_of(p.kind, given[name])
            found[name] = text if names_a_picture(p, text) else parse(p, text)
    return found


def to_json(request: Request) -> Json:
    """Return the options of a job: the fields and parameters that are not default."""
    told = {
        f.key: [f.kind.json(one) for one in value] if f.many else f.kind.json(value)
        for f in fields_of_verb(request.verb) if f.flags and (value := getattr(request, f.name)) != f.default
    }  # fmt: skip
    return told | {name: request.written(name) for name in request.parameters}


def text_of(kind: str, value: Any) -> str:
    """Return a value of JSON as text of an option."""
    if isinstance(value, list):
        return ("x" if kind in ("size", "extent") else ",").join(map(str, value))
    return str(value)


def _read(field: Field, value: Any) -> Any:
    if field.kind is FLAG:
        if not isinstance(value, bool):
            raise ParameterError(f"{field.key} is yes or no; give true or false.")
        return value
    values = value if field.many and isinstance(value, list) else [value]
    try:
        read = [field.kind.read(text_of(field.kind.name, one)) for one in values]
    except ValueError as e:
        raise ParameterError(f"{field.key}: {e}") from None
    return tuple(read) if field.many else read[0]
