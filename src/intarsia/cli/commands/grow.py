"""``intarsia grow``: a larger, tileable texture from an example. Imports nothing heavy before the work starts."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import click

from ...arguments import FEATHER, MOST_PASSES, SAMPLES
from ...choosing.auto import AUTO_METHOD
from ...errors import ParameterError, ResourceError
from ...geometry import Wrap
from ...levelling import Finish, Levelling
from ...methods.base import METHODS
from ..choosing import BY, EXPLAIN, TRIALS, chosen_of
from ..exits import begun
from ..help import HelpfulCommand
from ..options import (
    EXEMPLARS,
    MAGNIFY,
    Command,
    Opt,
    Union,
    common,
    gathered,
    input_options,
    named_target_options,
    offered,
    opt,
    report_options,
    work_options,
)
from ..pictures import named_pictures
from ..report import Report
from ..request import Inputs, Targets, Wish, Work
from ..values import Size

METHOD = opt(
    "method", "--method", "-m", type=click.Choice([AUTO_METHOD, *METHODS]), default=AUTO_METHOD, show_default=True,
    help="One of `intarsia methods`; auto chooses. It goes by what the exemplar is like.",
)  # fmt: skip
JOINS = (
    opt(
        "feather", "--feather", type=click.IntRange(0, FEATHER), metavar="PX",
        help="Soften seams over so many px; 0 copies exactly. By default as the method means it.",
    ),
    opt(
        "mixing", "--mixing", type=click.Choice(["mean", "variance", "source"]),
        help="How pieces mix within the feather: in linear light, keeping contrast, or as stored.",
    ),
    opt(
        "level", "--level", type=click.IntRange(0, FEATHER), metavar="PX",
        help="Even out steps of light and colour at seams. So far to either side; 0 leaves them. By default 96 where "
        "the method is chosen, 0 where it is named.",
    ),
)  # fmt: skip
OWN = (
    opt(
        "size", "--size", "-s", type=Size(), metavar="WIDTHxHEIGHT",
        help="Size in px; by default twice the exemplar. One number is a square.",
    ),
    METHOD,
    TRIALS,
    BY,
    EXPLAIN,
    opt(
        "wrap", "--wrap", type=click.Choice([w.value for w in Wrap]), default=Wrap.NONE.value, show_default=True,
        is_flag=False, flag_value=Wrap.BOTH.value,
        help="Axes along which the output tiles. It continues in itself there; without a value along both.",
    ),
    *JOINS,
    opt(
        "repair", "--repair", type=click.IntRange(0, MOST_PASSES), default=0, metavar="N",
        help="Look for the worst seams N times and mend them. They are covered anew where that helps; 4 is much. "
        "Default: 0.",
    ),
)  # fmt: skip

UNION, PARAMETERS = offered(METHODS, *OWN)


def finish_of(level: int | None) -> tuple[Finish, ...] | None:
    """Understand --level; None leaves things as they are."""
    return None if level is None else (Levelling(level),) if level else ()


def wish_of(
    method: str, explain: bool, feather: int | None, mixing: str | None, union: Union = UNION, **given: Any
) -> Wish:
    """Understand the options on method and canvas; `union` are the parameters of methods that the command knows."""
    size, wrap, trials = given.pop("size", None), given.pop("wrap", "none"), given.pop("trials", None)
    by = given.pop("by", None)
    finish, repair, labels = finish_of(given.pop("level", None)), given.pop("repair", 0), given.pop("labels", None)
    if explain and method != AUTO_METHOD:
        raise ParameterError("--explain belongs to --method auto; name that, or drop it.")
    pictures = named_pictures(given, (p for p, _ in union.values()))
    return Wish(
        chosen_of(method, trials, by, given, union), size, wrap, feather, mixing, labels=labels, explain=explain,
        finish=finish, repair=repair, pictures=pictures,
    )  # fmt: skip


Options = Callable[[Command], Command]
"""A decorator that adds options to a command."""


def growing(
    name: str, done: str, pictures: Options, *asked: Options, epilog: str, files: tuple[Opt, ...] = ()
) -> Callable[[Callable[..., Wish]], click.Command]:
    """Return a decorator that makes a command of what returns a wish: what is wished for is planned, then done.

    `done` says how results are called that no name is given for, such as grown; `files` are written besides.
    """

    def decorate(wished: Callable[..., Wish]) -> click.Command:
        def command(
            inputs: Inputs, targets: Targets, work: Work, report: Report, threads: int | None, **given: Any
        ) -> None:
            carry_out(inputs, targets, wished(**given), work, report, threads)

        command.__doc__ = wished.__doc__
        whole: Command = command
        written = named_target_options(done, files)
        for add in (report_options, common, work_options, pictures, written, *reversed(asked)):
            whole = add(whole)
        return click.command(name=name, cls=HelpfulCommand, epilog=epilog)(whole)

    return decorate


@growing(
    "grow", "grown", input_options(EXEMPLARS, MAGNIFY), gathered(*OWN, *PARAMETERS, into="wish", make=wish_of),
    epilog=f"Built-in exemplars: {', '.join('sample:' + s for s in SAMPLES)}. OUT may hold {{stem}}, {{seed}}, "
    "{method}, {w} and {h}: with {stem} every exemplar makes an output of its own.",
)  # fmt: skip
def command(wish: Wish) -> Wish:
    """Grow a larger texture from EXEMPLARs: pictures, or sets of planes.

    \b
    intarsia grow brick.png -o wall.png --size 2048x1024 --wrap both
    intarsia grow albedo.png --map normal=n.png --map height=h.exr -o out.png
    intarsia grow *.jpg -o "big/{stem}_{seed}.png" --seeds 1..3 --sheet sheet.png
    intarsia grow materials/ -o grown/ --size 2048 --wrap both
    """
    return wish


def carry_out(inputs: Inputs, targets: Targets, wish: Wish, work: Work, report: Report, threads: int | None) -> None:
    """Do what was asked for, or only plan it: what grow, extend, heal and paint have in common."""
    check_stdout(targets, report)
    if work.many is not None and targets.out and "{seed}" not in targets.out:
        raise ParameterError(f"-o {targets.out}: all seeds would write one file; put {{seed}} into the name.")

    if targets.into_folder(inputs.files):
        from ..materials import Materials

        materials = Materials.plan(inputs, targets, wish, work, report)
        begun()
        materials.tell_plan() if work.dry_run else materials.carry_out(threads)
        return

    from ..batch import Batch

    batch = Batch.plan(inputs, targets, wish, work.seeds, report)
    if work.sheet is not None:
        batch.add_sheet(work.sheet)
    begun()
    if work.dry_run:
        batch.tell_plan()
    else:
        batch.carry_out(threads)


def check_stdout(targets: Targets, report: Report) -> None:
    """Refuse what would mix a picture with other things on the standard output."""
    if not targets.to_stdout:
        return
    if report.as_json:
        raise ParameterError("--json and -o - both want the standard output; write the picture to a file.")
    if sys.stdout is None:
        raise ResourceError("-o -: the standard output is closed; name a file.")
    if sys.stdout.isatty():
        raise ParameterError("-o - would print a picture on the terminal; redirect it, or name a file.")
