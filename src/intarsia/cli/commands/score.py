"""``intarsia score``: how good an output is by its exemplar. Imports nothing heavy before the work."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import click

from ...errors import InputError
from ..exits import say
from ..options import EXEMPLARS, FILE, gathered, input_options, opt
from ..report import Report
from ..request import Inputs
from ..values import Gate

if TYPE_CHECKING:
    from ...judging.score import Score


class Judging(NamedTuple):
    """What is known of the output beside its pixels, and what it must reach."""

    saved: str | None
    wrap: str | None
    gates: tuple[tuple[str, float], ...]


JUDGING = (
    opt(
        "saved", "--map", type=FILE, metavar="FILE.npz",
        help="The map that was saved with --save-map: it tells of copies and cuts, too.",
    ),
    opt(
        "wrap", "--wrap", type=click.Choice(("none", "x", "y", "both")),
        help="Where the output should continue across its borders; by default as its map does.",
    ),
    opt(
        "gates", "--gate", multiple=True, type=Gate(),
        help="Exit with 4 where the total (0 to 100) or the worth of a part (0 to 1) is less; once for each.",
    ),
)  # fmt: skip


@click.command(name="score")
@input_options(EXEMPLARS, without=("maps", "packed", "weights"))
@click.argument("output", type=FILE, metavar="OUTPUT")
@gathered(*JUDGING, into="judging", make=Judging)
@gathered(
    opt("as_json", "--json", is_flag=True, help="Print the score as a JSON object on stdout."),
    opt("quiet", "--quiet", "-q", is_flag=True, help="Print nothing; the exit code tells of the gates."),
    into="report", make=Report,
)  # fmt: skip
@click.option("--debug", is_flag=True, expose_value=False, hidden=True)
def command(inputs: Inputs, output: str, judging: Judging, report: Report) -> None:
    """Tell how good OUTPUT is, grown from EXEMPLAR: 0 to 100, and what speaks against it.

    \b
    intarsia score stones.png grown.png
    intarsia score stones.png grown.png --map grown.npz --json
    intarsia score stones.png grown.png --gate total=60 --gate joins=0.5

    What is measured, and how far it agrees with people, stands in docs/score.md.
    """
    inputs.check_standard_input(output)
    from ... import files
    from ...sourcemap import SourceMap
    from ...tasks.scoring import check_gates, gated, score
    from ..exemplars import Shelf, sets_of

    check_gates(judging.gates)
    sets = sets_of(inputs, report)
    smap = None
    if judging.saved is not None:
        if judging.saved == "-":
            raise InputError("a map is read from a file; give --map the name of a .npz.")
        smap = SourceMap.load(judging.saved)
    exemplars = Shelf([sets], inputs, report).get(0)
    found = score(exemplars, files.read(output, alpha=inputs.alpha), map=smap, wrap=judging.wrap)
    if report.as_json:
        report.result({"file": output, **found.as_dict()})
    elif not report.quiet:
        say(_page(output, found))
    gated(found, judging.gates, output)


def _page(output: str, found: Score) -> list[str]:
    """The score in words: what takes most from it comes first."""
    lines = [f"{output}: {found.total:.0f} of 100"]
    for name, one in sorted(found.parts.items(), key=lambda item: -found.loss(item[0])):
        lost = f"-{100 * found.loss(name):.0f}" if one.part.weight else ""
        seen = f"{one.measured:7.1f} {one.part.unit:6}"
        lines.append(f"  {name:9} {seen} worth {one.worth:.2f} {lost:>4}  {one.part.says}")
    return lines
