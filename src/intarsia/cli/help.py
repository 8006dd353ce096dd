"""Help that fits a screen: the options that most need, in groups; --help-all tells of all. Imports nothing heavy."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import click

from ..choosing.auto import AUTO_METHOD
from ..disk.limits import allowing
from ..methods.base import method_class
from ..params import parameters
from ..request.field import HEADINGS
from ..request.request import FIELDS, Request
from .options import ParameterOption, method_option, parameters_of, request_of
from .report import Report

MOST_USED = ("patch",)
"""Parameters of methods that stand beside the method; the others have a group of their own."""

MEANT = dict.fromkeys(("--tileable", "--seamless", "--tiling", "--tile"), "--wrap both")
"""What people call an option that has another name here."""

WIDEST = 26  # characters: a longer list of values gives way to a name
WHOLE, METHOD = f"{__name__}.whole", f"{__name__}.method"
SENTENCE = re.compile(r"(?<=[^.]\.) |; automatic:")

Rows = list[tuple[str, str]]


Does = Callable[[Request, Report], None]


class HelpfulCommand(click.Command):
    """A command of the fields that a verb has, which `does` what a request asks for; `told` is what help says of it.

    Its help is short; -m METHOD --help tells of a method's parameters, --help-all of everything.
    """

    def __init__(self, verb: str, does: Does, told: str | None = None, epilog: str | None = None) -> None:
        def carry_out(**given: Any) -> None:
            request = request_of(verb, given)
            with allowing(request.max_pixels):
                does(request, Report(request.as_json, request.progress, request.quiet))

        told = told or does.__doc__
        super().__init__(verb, callback=carry_out, params=parameters_of(verb), help=told, epilog=epilog)

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        whole = click.Option(
            ["--help-all"], is_flag=True, is_eager=True, expose_value=False, callback=_tell_all,
            help="Show all options and exit.",
        )  # fmt: skip
        return [*super().get_params(ctx), whole]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Note which method the help is about, wherever on the line it is named; lead from usual words to options."""
        if not ctx.resilient_parsing and set(args) & set(ctx.help_option_names):
            given, _, _ = self.make_parser(ctx).parse_args(list(args))
            option = next((p for p in self.params if p.name == "method"), None)
            if option is not None and given.get("method") not in (None, AUTO_METHOD):
                ctx.meta[METHOD] = option.type.convert(given["method"], option, ctx)
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as e:
            meant = MEANT.get(e.option_name, "")
            if meant.partition(" ")[0] in {name for p in self.params for name in p.opts}:
                line = f"No such option '{e.option_name}'. Did you mean '{meant}'?"
                raise click.NoSuchOption(e.option_name, line, ctx=ctx) from None
            raise

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        if METHOD not in ctx.meta:
            super().format_help_text(ctx, formatter)
            return
        cls = method_class(ctx.meta[METHOD])
        formatter.write_paragraph()
        with formatter.indentation():
            none = "" if parameters(cls) else " It has no parameters."
            formatter.write_text(f"{cls.slug}: {cls.summary} ({cls.paper}).{none}")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        slug = ctx.meta.get(METHOD)
        sections = [self._of_method(slug)] if slug is not None else self._sections(ctx, WHOLE in ctx.meta)
        wide = max((len(names) for _, rows in sections for names, _ in rows if len(names) <= WIDEST), default=0)
        for heading, rows in sections:
            if rows:
                with formatter.section(heading):
                    formatter.write_dl([(names.ljust(wide), said) for names, said in rows], col_max=WIDEST)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        if METHOD not in ctx.meta:
            super().format_epilog(ctx, formatter)
        if WHOLE in ctx.meta:
            return
        name, said = ctx.command_path, "`{} --help-all` tells of all options."
        if METHOD not in ctx.meta and any(isinstance(p, ParameterOption) for p in self.params):
            said = "`{0} -m METHOD --help` tells of the parameters of a method, `{0} --help-all` of all options."
        formatter.write_paragraph()
        formatter.write_text(said.format(name))

    def _sections(self, ctx: click.Context, whole: bool) -> list[tuple[str, Rows]]:
        """The options under their headings: the usual ones with a sentence each, or all of them."""
        options = {str(p.name): p for p in self.params if isinstance(p, click.Option) and not p.hidden}
        of_methods = [n for n, o in options.items() if isinstance(o, ParameterOption)]
        sections = []
        for heading in HEADINGS:
            names = [f.name for f in FIELDS if f.heading == heading and (whole or not f.rare)]
            named = [n for n in names if n in options and n not in of_methods]
            if "method" in named and not whole:
                named[1:1] = [n for n in MOST_USED if n in of_methods]
            sections.append((heading, [_row(ctx, options[n], whole) for n in named]))
        rows = [_row(ctx, options[f], whole) for f in of_methods] if whole else []
        helps = [record for p in self.get_params(ctx)[len(self.params) :] if (record := p.get_help_record(ctx))]
        return [*sections, ("Parameters of methods", rows), ("Help", helps if whole else [])]

    def _of_method(self, slug: str) -> tuple[str, Rows]:
        known = {p.name for p in self.params if isinstance(p, ParameterOption)}
        found = [method_option(p, [slug], every=True) for p in parameters(method_class(slug)) if p.name in known]
        return f"Parameters of {slug}", [(f"{o.opts[0]} {o.metavar}", o.help or "") for o in found]


def read_argv(words: list[str]) -> Request:
    """Return the request that the words of a command say, without doing anything of it."""
    verb, *rest = words
    command = click.Command(verb, params=parameters_of(verb))
    with command.make_context(verb, rest) as ctx:
        return request_of(verb, ctx.params)


def _row(ctx: click.Context, option: click.Option, whole: bool) -> tuple[str, str]:
    """An option and what it does: all of it, or the first sentence alone."""
    record = option.get_help_record(ctx)
    assert record is not None
    names, said = record
    if whole:
        return names, said
    if len(names) > WIDEST and " [" in names:
        names = f"{names.partition(' [')[0]} {str(option.name).upper()}"
    return names, SENTENCE.split(option.help or "")[0].rstrip(".") + "."


def _tell_all(ctx: click.Context, param: click.Parameter, value: Any) -> None:
    """Tell of all options, and end."""
    if value and not ctx.resilient_parsing:
        ctx.meta[WHOLE] = True
        click.echo(ctx.get_help(), color=ctx.color)
        ctx.exit()
