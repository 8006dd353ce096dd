"""Click commands built from the table of fields: their options, the request that they make, and their help.

``grow``, ``extend``, ``heal``, ``paint`` and ``tile`` are made here. Help fits a screen: the usual options, in
groups; --help-all lists all. Imports nothing heavy.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from ..disk import allowing
from ..foundation import AUTO_METHOD, SAMPLES, ParameterError, ResourceError
from ..foundation.params import KINDS, Parameter, parameters
from ..methods import METHODS, RENAMED, method_class, preset
from ..request import FIELDS, HEADINGS, Json, Request, fields_of_verb, parameter_values, parameters_of_verb
from ..request.field import FLAG, Field, File, Kind, Number, Whole
from ..request.fields import methods_for
from . import CANCEL, Report, callers, enable_collection

if TYPE_CHECKING:
    ParamType = click.ParamType[Any]
else:  # older versions of click do not take the bracket
    ParamType = click.ParamType


def entries(*slugs: str) -> list[Json]:
    """Return these methods, or all, as ``intarsia methods --json`` prints them."""
    return [
        {
            "slug": cls.slug,
            "paper": cls.paper,
            "summary": cls.summary,
            "supports": sorted(ability.value for ability in cls.supports),
            "parameters": [p.as_dict() for p in parameters(cls)],
        }
        for cls in map(method_class, slugs or METHODS)
    ]


class ParameterOption(click.Option):
    """The option of a parameter that some methods have."""


class FileName(click.Path):
    """The name of a file, or - ; it is checked when it is opened."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        return File().read(str(value))


FILE = FileName()


class InRange(click.FloatRange):
    """A number in a range; NaN is refused."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        found = super().convert(value, param, ctx)
        if found != found:
            self.fail(f"{value} is no number; give {self.min:g} to {self.max:g}.", param, ctx)
        return found


class Typed(ParamType):
    """A kind of values as a type of click."""

    def __init__(self, kind: Kind) -> None:
        self.kind, self.name = kind, kind.shown

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if not isinstance(value, str):
            return value
        try:
            return self.kind.read(value)
        except ValueError as e:
            self.fail(str(e), param, ctx)


def type_of(kind: Kind) -> Any:
    """Return the type of click for a kind of values; click's own types, with their messages, if there is one."""
    if isinstance(kind, File):
        return FILE
    if isinstance(kind, Number):
        return InRange(kind.low, kind.high)
    if isinstance(kind, Whole) and not kind.choices:
        return click.IntRange(kind.low, kind.high)
    if kind.name == "choice":
        return click.Choice(kind.choices)
    return str if type(kind) is Kind else Typed(kind)


def option_of(field: Field) -> click.Parameter:
    """Return the option or argument of a field."""
    facts: Json = {"required": field.required}
    if field.kind is FLAG:
        facts |= {"is_flag": True}
    else:
        facts |= {"type": type_of(field.kind), "metavar": field.shown or field.kind.shown or None}
    if not field.flags:
        return click.Argument([field.name], nargs=-1 if field.many else 1, **facts)
    if field.alone is not None:
        facts |= {"is_flag": False, "flag_value": field.alone}
    if field.default is not None and not field.many and field.kind is not FLAG:
        facts |= {"default": field.default}
    names = [field.name, *field.flags]
    return click.Option(names, help=field.help, multiple=field.many, show_default=field.tells_default, **facts)


def method_option(p: Parameter, owners: list[str], every: bool) -> ParameterOption:
    """Return the option of a method's parameter; its text is parsed later by the method."""
    unit = f" {p.unit}" if p.unit and p.kind == "int" else ""
    default = "" if p.default is None else f" Default: {p.default}{unit}."
    only = "" if every else f" ({', '.join(owners)})"
    text = f"{p.help[:1].upper()}{p.help[1:]}.{default}{only}"
    names = [p.name, "--" + p.name.replace("_", "-")]
    return ParameterOption(names, metavar="|".join(filter(None, (*p.choices, KINDS[p.kind].shown))), help=text)


def parameters_of(verb: str, slug: str | None = None) -> list[click.Parameter]:
    """Return arguments and options of a verb, or those of one method; arguments first, to be reported missing first."""
    fields, number = fields_of_verb(verb), len(methods_for(verb))
    offered = parameters_of_verb(verb, slug).values()
    own = [method_option(p, owners, slug is not None or len(owners) == number) for p, owners in offered]
    debug = click.Option(["--debug"], is_flag=True, expose_value=False, hidden=True)
    return [*map(option_of, sorted(fields, key=lambda f: bool(f.flags))), *own, debug]


def request_of(verb: str, given: Json) -> Request:
    """Return the request of the values of all options of a verb."""
    if (document := given.get("document")) is not None:  # what it sets where nothing else is given
        settings, usual = preset(document), {"method": AUTO_METHOD}
        if given["method"] not in (AUTO_METHOD, settings["method"]):
            raise ParameterError(f"--as {document} sets --method {settings['method']}; drop one of them.")
        given = given | {name: text for name, text in settings.items() if given.get(name) == usual.get(name)}
    values = parameter_values(verb, given.get("method", AUTO_METHOD), given)
    fields = {f.name: given[f.name] for f in fields_of_verb(verb) if f.name in given}
    return Request(verb, **fields, parameters=values)


MOST_USED = ("patch",)
"""Parameters of methods that help lists beside the method; the others have a group of their own."""

MEANT = dict.fromkeys(("--tileable", "--seamless", "--tiling", "--tile"), "--wrap both")
"""Usual words for an option -> its name here."""

WIDEST = 26  # characters: a longer list of values gives way to a name
WHOLE = f"{__name__}.whole"
SENTENCE = re.compile(r"(?<=[^.]\.) |; automatic:")

Rows = list[tuple[str, str]]


Does = Callable[[Request, Report], None]


class HelpfulCommand(click.Command):
    """A command with the fields of a verb, which calls `does` with the request; `told` is its help text.

    Its help is short; --help-all lists everything, `intarsia methods METHOD` the parameters of a method.
    """

    def __init__(self, verb: str, does: Does, told: str | None = None, epilog: str | None = None) -> None:
        def carry_out(**given: Any) -> None:
            request = request_of(verb, given)
            report = Report(request.as_json, request.progress, request.quiet)
            callers.call(request.called)
            if request.with_parent:
                callers.end_with_parent(CANCEL.set, request.files)
            with allowing(request.max_pixels):
                check_stdout(request, report)
                does(request, report)

        super().__init__(verb, callback=carry_out, help=told or does.__doc__, epilog=epilog)

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        whole = click.Option(
            ["--help-all"], is_flag=True, is_eager=True, expose_value=False, callback=_tell_all,
            help="Show all options and exit.",
        )  # fmt: skip
        return [*super().get_params(ctx), whole]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse with the options of the named method, else with all; suggest the option for usual words."""
        args = now_called(args)
        slug, known = _named(args), self.params
        self.params = parameters_of(str(self.name), slug)
        try:
            return super().parse_args(ctx, list(args))
        except click.NoSuchOption as e:
            meant = MEANT.get(e.option_name, "")
            if meant.partition(" ")[0] in {name for p in self.params for name in p.opts}:
                line = f"No such option '{e.option_name}'. Did you mean '{meant}'?"
                raise click.NoSuchOption(e.option_name, line, ctx=ctx) from None
            if slug is None:
                raise
            self.params = parameters_of(str(self.name))  # another method may have it
            return super().parse_args(ctx, args)
        finally:
            if not ctx.resilient_parsing:  # else they are read after this
                self.params = known

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        sections = self._sections(ctx, WHOLE in ctx.meta)
        wide = max((len(names) for _, rows in sections for names, _ in rows if len(names) <= WIDEST), default=0)
        for heading, rows in sections:
            if rows:
                with formatter.section(heading):
                    formatter.write_dl([(names.ljust(wide), said) for names, said in rows], col_max=WIDEST)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        super().format_epilog(ctx, formatter)
        if WHOLE in ctx.meta:
            return
        said = f"`{ctx.command_path} --help-all` tells of all options"
        if any(isinstance(p, ParameterOption) for p in self.params):
            said += ", `intarsia methods METHOD` of the parameters of a method"
        formatter.write_paragraph()
        formatter.write_text(f"{said}.")

    def _sections(self, ctx: click.Context, whole: bool) -> list[tuple[str, Rows]]:
        """Return the options under their headings: the usual ones with a sentence each, or all."""
        options = {str(p.name): p for p in self.params if isinstance(p, click.Option) and not p.hidden}
        of_methods = [n for n, o in options.items() if isinstance(o, ParameterOption)]
        sections = []
        for heading in HEADINGS:
            fields = [f for f in FIELDS if f.heading == heading and f.name in options and f.name not in of_methods]
            named = [f.name for f in fields if whole or not f.rare or options[f.name].required]
            if "method" in named and not whole:
                named[1:1] = [n for n in MOST_USED if n in of_methods]
            sections.append((heading, [_row(ctx, options[n], whole) for n in named]))
        rows = [_row(ctx, options[f], whole) for f in of_methods] if whole else []
        helps = [record for p in self.get_params(ctx)[len(self.params) :] if (record := p.get_help_record(ctx))]
        return [*sections, ("Parameters of methods", rows), ("Help", helps if whole else [])]


WAS = {f"--{old}".replace("_", "-"): f"--{new}".replace("_", "-") for old, new in RENAMED.items()}


def now_called(args: list[str]) -> list[str]:
    """Return the words of a command with options of version 0.1 under the names that they have now, and say so."""
    flags = [word.partition("=")[0] for word in args]
    for flag in dict.fromkeys(flag for flag in flags if flag in WAS):
        callers.say(f"{flag} is called {WAS[flag]} now.")
    return [WAS.get(flag, flag) + word[len(flag) :] for flag, word in zip(flags, args, strict=True)]


def _named(args: list[str]) -> str | None:
    """Return the method that the words of a command name; None for `auto` and with --help-all."""
    found = re.findall(r"^(?:-m\n?|--method[\n=])(.*)$", "\n".join(args), re.MULTILINE)
    return found[0] if len(found) == 1 and found != [AUTO_METHOD] and "--help-all" not in args else None


def read_argv(words: list[str]) -> Request:
    """Return the request of the words of a command, without carrying it out."""
    verb, *rest = words
    command = click.Command(verb, params=parameters_of(verb))
    with command.make_context(verb, rest) as ctx:
        return request_of(verb, ctx.params)


def _row(ctx: click.Context, option: click.Option, whole: bool) -> tuple[str, str]:
    """Return an option and its help: all of it, or the first sentence."""
    record = option.get_help_record(ctx)
    assert record is not None
    names, said = record
    if whole:
        return names, said
    if len(names) > WIDEST and " [" in names:
        names = f"{names.partition(' [')[0]} {str(option.name).upper()}"
    return names, SENTENCE.split(option.help or "")[0].rstrip(".") + "."


def _tell_all(ctx: click.Context, param: click.Parameter, value: Any) -> None:
    """Print the help of all options, and exit."""
    if value and not ctx.resilient_parsing:
        ctx.meta[WHOLE] = True
        click.echo(ctx.get_help(), color=ctx.color)
        ctx.exit()


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
"""Verb -> its help, and the text below the options."""


def command_of(verb: str) -> click.Command:
    """Return the command of a verb."""
    return HelpfulCommand(verb, carry_out, *TOLD[verb])


def carry_out(request: Request, report: Report) -> None:
    """Carry out a request, or only plan it."""
    _ = request.chosen  # a method that cannot be is refused before anything is read
    if request.many is not None and request.out and "{seed}" not in request.out:
        raise ParameterError(f"-o {request.out}: all seeds would write one file; put {{seed}} into the name.")

    from .batch import Batch

    batch = Batch.plan(request, report)
    enable_collection()
    batch.tell_plan() if request.dry_run else batch.carry_out()


def check_stdout(request: Request, report: Report) -> None:
    """Raise an error if a picture cannot go to the standard output."""
    if request.out != "-":
        return
    if report.as_json:
        raise ParameterError("--json and -o - both want the standard output; write the picture to a file.")
    if sys.stdout is None:
        raise ResourceError("-o -: the standard output is closed; name a file.")
    if sys.stdout.isatty():
        raise ParameterError("-o - would print a picture on the terminal; redirect it, or name a file.")
