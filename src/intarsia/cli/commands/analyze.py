"""``intarsia analyze``: lattice, elements and illumination of an exemplar. Imports nothing heavy before the work."""

from __future__ import annotations

from ...foundation.params import written
from ...request import Json, Request
from .. import Report, print_lines
from ..verbs import HelpfulCommand

SHOWN = 3  # candidates that are printed where the confidence is small
SMALL = 0.1


def look(request: Request, report: Report) -> None:
    """Tell by which steps EXEMPLAR repeats, how large its elements are, how it is lit, and how to grow it.

    \b
    intarsia analyze weave.png
    intarsia analyze weave.png --crop 0,0,256,256
    intarsia analyze *.png --several --json
    """
    from ...tasks.exemplar_analysis import analyze
    from ..exemplars import Inputs, sets_of

    sets, results = sets_of(request, report), []
    shelves = [Inputs([one], request, report) for one in sets]
    for shelf in shelves[: len(sets) * (len(sets) > 1)]:
        _ = shelf.exemplars  # what cannot be read is refused before the first is worked on
        shelf.forget()
    for number, (one, shelf) in enumerate(zip(sets, shelves, strict=True)):
        with report.watching(1):
            answer = analyze(shelf.exemplars[0]).as_dict()
        shelf.forget()
        first = next(iter(one.values()))
        answer["suggested"]["flatten"] |= request.flatten
        results.append({"file": first, **answer})
        if not (report.as_json or report.quiet):
            print_lines(([""] if number else []) + _page(first, answer))
    report.result(results[0] if len(results) == 1 else {"results": results})


def _page(path: str, answer: Json) -> list[str]:
    """Return the answer as lines for a person."""
    width, height = answer["exemplar"]["size"]
    lattice, light = answer["lattice"], answer["light"]
    lines = [f"{path}: {width}x{height} px"]
    if lattice is None:
        lines += [f"lattice      none. {answer['reason']}"]
    else:
        lines += [f"lattice      {_vectors(lattice)}; {_shape(lattice)}"]
        lines += [f"             confidence {lattice['confidence']:.2f}"]
        lines += [f"             {reason}" for reason in lattice["reasons"]]
    if lattice is None or lattice["confidence"] < SMALL:
        for n, one in enumerate(answer["candidates"][:SHOWN], 1):
            lines += [f"candidate {n}  {_vectors(one)}; confidence {one['confidence']:.2f}. {one['reasons'][-1]}"]
    if answer["straightened"] is not None:
        lines += [f"courses      {_bent(answer['straightened'])}"]
    if answer["elements"]["found"]:
        seen = answer["elements"]
        lines += [f"elements     about {answer['feature_size']} px ({seen['size'][0]} wide, {seen['size'][1]} high)"]
    else:
        lines += [f"elements     not seen; {answer['feature_size']} px is a guess"]
    lines += _segments(answer["segments"])
    share = f"{100 * light['share']:.0f} % of the differences between its parts, {light['factor']:.1f} times brighter"
    lines += [f"light        {'a strong slope: ' + share if light['strong'] else 'no strong slope'}"]
    lines += [f"suggested    {' '.join(_options(answer['suggested']))}"]
    return lines + [f"             {why}" for why in answer["suggested"]["why"]]


def _segments(seen: Json) -> list[str]:
    """Return lines on segments, groups, the chosen one, and patch and boundary zone with their rule."""
    groups, chosen = seen["groups"], seen["chosen"]
    first = f"segments     {seen['count']} in {len(groups)} group{'s' * (len(groups) != 1)}; "
    if chosen is None:
        first += "none is chosen"
    else:
        mine = groups[chosen]
        first += f"group {chosen} is chosen: {mine['segments']} of them, {100 * mine['share']:.0f} % of the picture"
    size = f"patch {seen['patch']} px, boundary zone {seen['zone']} px, by rule {seen['rule']}"
    return [first, f"             {size}: {seen['why'][:1].lower()}{seen['why'][1:]}"]


def _vectors(one: Json) -> str:
    return " and ".join(f"{x:.2f},{y:.2f}" for x, y in one["vectors"]) + " px"


def _bent(one: Json) -> str:
    """Return a line on courses that are not straight, and what straightening does."""
    ways = [f"converge by {100 * one['converging']:.0f} %"] if one["converging"] >= 0.01 else []
    ways += [f"slant by {100 * abs(one['slant']):.0f} %"] if abs(one["slant"]) >= 0.005 else []
    return (
        f"{', '.join(ways) or 'bow'}, up to {one['off']:.0f} px off; laid straight (straighten=on) they repeat by "
        f"{_vectors(one)}, confidence {one['confidence']:.2f}"
    )


def _shape(one: Json) -> str:
    periods, angles = one["periods"], one["angles"]
    if len(periods) == 1:
        return f"rows {periods[0]:.2f} px apart, across {angles[0]:.1f} degrees; nothing returns along them"
    between = abs(angles[0] - angles[1]) % 180
    return f"periods {periods[0]:.2f} and {periods[1]:.2f} px, {between:.1f} degrees apart"


def _options(suggested: Json) -> list[str]:
    """Return the suggestion as options of grow."""
    words = ["--method", suggested["method"]]
    for name, value in suggested["parameters"].items():
        words += [f"--{name.replace('_', '-')}", f'"{written(value)}"' if name == "lattice" else str(value)]
    return words + ["--flatten"] * suggested["flatten"]


command = HelpfulCommand("analyze", look)
