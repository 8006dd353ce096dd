"""``intarsia score``: the quality of an output compared with its exemplar. Imports nothing heavy before the work."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from ...foundation import InputError
from ...request import Request
from .. import Report, print_lines
from ..verbs import HelpfulCommand

if TYPE_CHECKING:
    from ...judging import Score
    from ...tasks.scoring import Outcome


def judge(request: Request, report: Report) -> None:
    """Tell how good OUTPUT is, grown from EXEMPLAR: 0 to 100, and what speaks against it.

    \b
    intarsia score stones.png grown.png
    intarsia score stones.png grown.png --map grown.npz --json
    intarsia score stones.png grown.png --gate total=60 --gate joins=0.5 --report grown.html

    What is measured, and how far it agrees with people, stands in docs/score.md.
    """
    assert request.output is not None
    from ... import files
    from ...model.sourcemap import SourceMap
    from ...tasks.scoring import check_gates, gated, misses, outcome_of
    from ..exemplars import Inputs, sets_of, stem_of
    from ..outputs import check_all, filled_name

    check_gates(request.gates)
    sets, page, output, saved = sets_of(request, report), request.page, request.output, request.saved
    if page is not None:
        page = filled_name(page, {"stem": stem_of(sets[0])})
        check_all([page], request.force, set())
    smap = None if saved is None else SourceMap.load(saved)
    exemplars, made = Inputs(sets, request, report).exemplars, files.read(output, alpha=request.alpha)
    outcome = outcome_of(exemplars, made, map=smap, wrap=request.wrap)
    found = outcome.score
    if page is not None:
        outcome = outcome.but(name=output, missed=misses(found, request.gates))
        _tell(outcome, page, request.force)
    more = {"energy": outcome.energy, "report": page}
    told = {name: value for name, value in more.items() if value is not None}
    report.result({"file": output, **found.as_dict(), **told})
    if not (report.as_json or report.quiet):
        print_lines(_in_words(output, found))
    gated(found, request.gates, output)


def _tell(outcome: Outcome, page: str, force: bool) -> None:
    """Write the report, with the recipe that the output carries."""
    from ... import files
    from ..outputs import Staging, write_page

    recipe = None
    if outcome.name != "-":
        with suppress(InputError):  # damaged, or of another program: not what was asked
            recipe = files.read_recipe(outcome.name)
    with Staging(force) as staging:
        write_page(staging, page, outcome if recipe is None else outcome.but(recipe=recipe))
        staging.commit()


def _in_words(output: str, found: Score) -> list[str]:
    """Return the score as lines; what takes most from it comes first."""
    lines = [f"{output}: {found.total:.0f} of 100, {found.verdict}"]
    for name in found.ranked:
        one = found.parts[name]
        lost, seen = f"-{100 * found.loss(name):.0f}", f"{one.measured:7.1f} {one.part.unit:6}"
        lines.append(f"  {name:9} {seen} worth {one.normalised:.2f} {lost:>4}  {one.part.says}")
    return lines


command = HelpfulCommand("score", judge)
