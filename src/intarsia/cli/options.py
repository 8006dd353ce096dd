"""The options that commands share; each decorator gathers its options into one noun. Imports nothing heavy."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any

import click

from ..arguments import ALPHAS, TIMES
from ..disk.limits import DEFAULT_PIXELS, VARIABLE, allowing
from ..errors import ParameterError
from ..methods.base import METHODS, method_class
from ..params import Parameter, parameters
from .report import Report
from .request import Inputs, Targets, Work
from .values import GATE, PLANE_WEIGHT, Channels, Colour, FileName, NamedFile, Place, Rectangle, Scale, Seed, Seeds

Command = Callable[..., Any]

FILE = FileName()
ALPHA = click.Choice(ALPHAS)
DEPTHS = ("8", "16", "half", "float")


class ParameterOption(click.Option):
    """The option of a parameter that some methods have."""


@dataclass(frozen=True)
class Opt:
    """One option (or, without names, an argument) of a gathered group, and the field that it fills."""

    field: str
    names: tuple[str, ...]
    facts: dict[str, Any]

    def attach(self, command: Command) -> Command:
        """Give the option to a command."""
        if not self.names:
            return click.argument(self.field, **self.facts)(command)
        return click.option(self.field, *self.names, **self.facts)(command)

    def but(self, **facts: Any) -> Opt:
        """Return the same option, of which some is told otherwise."""
        return replace(self, facts=self.facts | facts)


def opt(field: str, *names: str, **facts: Any) -> Opt:
    """Declare an option under the name of the field that it fills."""
    return Opt(field, names, facts)


def gathered(*options: Opt, into: str, make: Callable[..., Any]) -> Callable[[Command], Command]:
    """Return a decorator: add the options, and hand their values to the command as one argument `into`."""

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def wrapper(**given: Any) -> Any:
            values = {o.field: given.pop(o.field) for o in options}
            return command(**{into: make(**values)}, **given)

        for option in reversed(options):
            option.attach(wrapper)
        return wrapper

    return decorate


PLANE_WEIGHTS = opt(
    "weights", "--weight", "--plane-weight", multiple=True, type=PLANE_WEIGHT, metavar="NAME=F",
    help="How much a plane counts in matching, relative to what is usual, such as normal=2; 0: it is only drawn.",
)  # fmt: skip
INPUT_OPTIONS = (
    opt(
        "maps", "--map", multiple=True, type=NamedFile(),
        help="A further plane, such as normal=normals.png. Once for each: height=h.exr, roughness=rough.png.",
    ),
    opt(
        "masks", "--mask", multiple=True, type=FILE, metavar="FILE",
        help="White where exemplar pixels may be used. One for each exemplar.",
    ),
    opt(
        "packed", "--packed", type=Channels(), metavar="C=NAME,...",
        help="What the channels of the packed map hold (NAME_orm and the like, or --map packed=FILE), such as "
        "R=ao,G=roughness,B=metallic.",
    ),
    PLANE_WEIGHTS,
    opt("avoid", "--avoid", type=Colour(), help="Never use exemplar pixels of exactly this colour."),
    opt(
        "alpha", "--alpha", type=ALPHA, default="auto", show_default=True,
        help="Opacity is a channel to grow, or a mask of the pixels that may be used.",
    ),
    opt("toroidal", "--toroidal", is_flag=True, help="The exemplar continues across its borders."),
    opt("crop", "--crop", type=Rectangle(), help="Use this part of the exemplar only."),
    opt(
        "scale", "--scale", type=Scale(), default=1,
        help="Reduce the exemplar to 1/2, 1/3, ... first. After --crop; blocks are averaged in linear light.",
    ),
    opt(
        "flatten", "--flatten", is_flag=True,
        help="Even out uneven light in the exemplar first. That is a slope or a vignette; `intarsia analyze` tells "
        "where it helps.",
    ),
    opt("as_set", "--set", is_flag=True, help="All files are planes of one exemplar. Their names do not matter."),
    opt(
        "several", "--several", is_flag=True,
        help="Every file is an exemplar of its own. By default names decide: x_albedo and x_normal are one set.",
    ),
)  # fmt: skip

EXEMPLARS = opt("files", nargs=-1, required=True, type=FILE, metavar="EXEMPLAR...")
IMAGES = opt("files", nargs=-1, required=True, type=FILE, metavar="IMAGE...")
KNOWN = opt(
    "files", "--exemplar", "-e", multiple=True, type=FILE, metavar="FILE", help="The exemplar. Once for each file."
)

MAGNIFY = opt(
    "magnify", "--magnify", type=click.IntRange(1, TIMES), default=1, metavar="N",
    help="Grow small, at 1/N, and draw at full size. All pixels of the exemplar are drawn: for large outputs. Sizes "
    "stay those of the pictures; all else, such as --patch and --feather (then 1 if not given), counts px of 1/N.",
)  # fmt: skip

DONORS = opt(
    "donors", "--from", multiple=True, type=FILE, metavar="FILE",
    help="Take new pixels from this picture, or these. By default from the picture itself.",
)  # fmt: skip

FORCE = opt("force", "--force", is_flag=True, help="Replace files that exist.")
OUT = opt(
    "out", "-o", "--output", required=True, type=FILE, metavar="OUT",
    help="The picture to write. Further planes lie beside it as OUT_NAME; - is the standard output (PNG).",
)  # fmt: skip
USUAL = (
    " A name that ends in / is a folder: every material goes there by itself, under its own name. Default: NAME_{done} "
    "in the working folder, in the exemplar's format if that is lossless, else PNG or EXR."
)
TARGET_OPTIONS = (
    OUT,
    opt(
        "depth", "--depth", type=click.Choice(DEPTHS),
        help="Bits; by default exactly those of the exemplar.",
    ),
    opt("layers", "--layers", is_flag=True, help="Write all planes as layers of one OpenEXR file: OUT.exr."),
    FORCE,
)

MAP_OPTIONS = (
    opt("save_map", "--save-map", type=FILE, metavar="FILE.npz", help="Save which exemplar pixel went where."),
    opt("st_map", "--st-map", type=FILE, metavar="FILE.exr", help="Save the same as an ST map for compositing."),
    opt(
        "distance_map", "--distance-map", type=(Place(), FILE), default=None, metavar="X,Y FILE",
        help="Save how well every patch of the exemplar fitted when output pixel X,Y was filled: .exr or .tif "
        "holds distances (-1: no patch there), .png stretches them, dark is near.",
    ),
)

PAGE = opt(
    "page", "--report", type=FILE, metavar="FILE.html|png",
    help="A page or a picture on how good it is. What it is made of, and where it loses; of several outputs one for "
    "each where {stem} or {seed} is in its name, else one of all, the worst first.",
)  # fmt: skip
GATES = opt(
    "gates", "--gate", multiple=True, type=GATE,
    help="Exit with 4, writing nothing, if it is worse. The total goes to 100, the worth of a part to 1, see `intarsia "
    "score`; once for each.",
)  # fmt: skip
JUDGE_OPTIONS = (
    PAGE, GATES, opt("keep", "--keep", is_flag=True, help="Write all the same what misses a --gate."),
)  # fmt: skip

SEED = opt(
    "seed", "--seed", type=Seed(), metavar="N|random", help="The same number gives the same picture. Default: 0."
)
WORK_OPTIONS = (
    SEED,
    opt(
        "many", "--seeds", type=Seeds(), metavar="1..9|1,4,7",
        help="One output for each seed. {seed} in -o tells them apart.",
    ),
    opt("sheet", "--sheet", type=FILE, metavar="FILE.png", help="A contact sheet of all that is made."),
    opt("dry_run", "--dry-run", is_flag=True, help="Check everything, write nothing. Tells sizes and memory."),
)  # fmt: skip

REPORT_OPTIONS = (
    opt("as_json", "--json", is_flag=True, help="Print the result as a JSON object."),
    opt("progress", "--progress", type=click.Choice(["json"]), help="Tell progress as JSON lines on stderr."),
    opt("quiet", "--quiet", "-q", is_flag=True, help="Say nothing but errors."),
)


def common(command: Command) -> Command:
    """Add --threads, --debug and help under -h."""
    command = click.option("--debug", is_flag=True, expose_value=False, hidden=True)(command)
    return click.option(
        "--threads",
        type=click.IntRange(1, 1024),
        metavar="N",
        help="Threads to use; by default one a core. Never changes a pixel.",
    )(command)


def _inputs(as_set: bool = False, several: bool = False, **given: Any) -> Inputs:
    if as_set and several:
        raise ParameterError("--set and --several exclude each other; drop one.")
    return Inputs(how="set" if as_set else "several" if several else "auto", **given)


def input_options(*files: Opt, without: tuple[str, ...] = ()) -> Callable[[Command], Command]:
    """Add the options on exemplars; `files` declares how the pictures themselves are given."""
    kept = [o for o in INPUT_OPTIONS if o.field not in without]
    add = gathered(*files, *kept, into="inputs", make=_inputs)
    limit = click.option(
        "--max-pixels", type=click.IntRange(1), metavar="N", expose_value=False, callback=_allow,
        help=f"Most pixels of a picture that is read. Default: {DEFAULT_PIXELS} (8192x8192), or what {VARIABLE} says.",
    )  # fmt: skip
    return lambda command: add(limit(command))


def _allow(ctx: click.Context, param: click.Parameter, value: int | None) -> None:
    """Let --max-pixels hold while the command runs."""
    if not ctx.resilient_parsing:
        ctx.with_resource(allowing(value))


def named_target_options(done: str, more: tuple[Opt, ...] = ()) -> Callable[[Command], Command]:
    """Add the options on files to write, of which -o can be left out: NAME_grown.png where `done` is grown.

    `more`: those that one command has besides.
    """
    out = OUT.but(required=False, help=OUT.facts["help"] + USUAL.format(done=done))

    def make(out: str | None, **given: Any) -> Targets:
        return Targets(out="", done=done, **given) if out is None else Targets(out, **given)

    others = (*(o for o in TARGET_OPTIONS if o is not OUT), *more, *MAP_OPTIONS, *JUDGE_OPTIONS)
    return gathered(out, *others, into="targets", make=make)


target_options = gathered(*TARGET_OPTIONS, into="targets", make=Targets)
grown_target_options = gathered(*TARGET_OPTIONS, *MAP_OPTIONS, *JUDGE_OPTIONS, into="targets", make=Targets)
work_options = gathered(*WORK_OPTIONS, into="work", make=Work)
report_options = gathered(*REPORT_OPTIONS, into="report", make=Report)


Union = dict[str, tuple[Parameter, list[str]]]
"""The parameters of several methods by name, with the methods that have them."""

METAVARS = {
    "extent": "PX|WxH",
    "int": "N",
    "float": "F",
    "weights": "W,W,...",
    "levels": "F|F,F,...",
    "price": "F|inf",
    "pins": "'X,Y -> X,Y R'",
    "vectors": "'X,Y X,Y'",
    "isometries": "none|180|90|both|auto|IDS",
    "field": "F|FILE",
    "picture": "FILE",
}


def method_option(p: Parameter, owners: list[str], every: bool) -> Opt:
    """Declare the option of a method's parameter, as text that the method's own rules read later."""
    default = "" if p.default is None else f" Default: {_default(p)}."
    only = "" if every else f" ({', '.join(owners)})"
    metavar = "|".join((*p.choices, *([METAVARS[p.kind]] if p.kind in METAVARS else [])))
    metavar = metavar or p.kind.upper()
    text = f"{p.help[:1].upper()}{p.help[1:]}.{default}{only}"
    return opt(p.name, "--" + p.name.replace("_", "-"), cls=ParameterOption, metavar=metavar, help=text)


def _default(p: Parameter) -> str:
    value = p.default
    if isinstance(value, tuple):
        return ("x" if p.kind == "extent" else ",").join(map(str, reversed(value) if p.kind == "extent" else value))
    return f"{value} {p.unit}".strip() if p.kind in ("int", "extent") else str(value)


def offered(slugs: Collection[str], *options: Opt) -> tuple[Union, tuple[Opt, ...]]:
    """Return the parameters that some methods have, and an option for each; not those named as `options` are."""
    taken, every = {o.field for o in options}, dict[str, tuple[Parameter, list[str]]]()
    for slug in METHODS:
        for p in parameters(method_class(slug)):
            if p.name not in taken:
                every.setdefault(p.name, (p, []))[1].append(slug)
    union = {name: (p, own) for name, (p, owners) in every.items() if (own := [o for o in owners if o in slugs])}
    return union, tuple(method_option(p, owners, len(owners) == len(slugs)) for p, owners in union.values())
