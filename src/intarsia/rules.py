"""The rules by which a method is chosen, in one table: the first that holds leads.

A rule asks only for facts that it needs, so a picture with a lattice is never searched for grain. To add a method, add
one line to RULES, above the generalists: its name, what must hold, the method, its parameters, and the reason in a
sentence. The page docs/auto.md lists what stands here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .analysis.tile_layout import UNIT
from .measure import Facts

EQUAL = 0.15  # periods that differ less are one picture, repeated
FINE_SIDE = 12  # grain: segments of at most 1/12 of the shorter side,
FINE_ELEMENT = 0.55  # and of at most so much of what correlates
TURNED = (0, 5, 6, 7)  # a mirrored patch would lie beside its own picture in the mirror, which fits and shows
FEW_ELEMENTS = 3.0  # across the exemplar: with fewer, repeats show
FEW_PERIODS = 2.0
SMALL = 32  # px


@dataclass(frozen=True)
class Rule:
    """One line of the table.

    ``holds`` decides, ``parameters`` gives what the method is told (x before y), ``why`` says it in sentences.
    ``when`` is the condition in words, for the documentation.
    """

    name: str
    method: str
    when: str
    holds: Callable[[Facts], bool]
    parameters: Callable[[Facts], dict[str, Any]]
    why: Callable[[Facts], tuple[str, ...]]


def _nothing(f: Facts) -> dict[str, Any]:
    return {}


def _lattice(f: Facts) -> dict[str, Any]:
    assert f.lattice is not None
    return {"lattice": tuple((x / UNIT, y / UNIT) for y, x in f.lattice.vectors)}


def _straight_lattice(f: Facts) -> dict[str, Any]:
    assert f.straight is not None
    vectors = f.straight[1].vectors
    return {"lattice": tuple((x / UNIT, y / UNIT) for y, x in vectors), "straighten": "on"}


def _two(f: Facts) -> bool:
    return f.lattice is not None and f.lattice.kind == "2-D"


def _rows(f: Facts) -> bool:
    return f.lattice is not None and f.lattice.kind == "1-D"


def _fine(f: Facts) -> bool:
    return (
        f.lattice is None
        and not f.regions.two
        and FINE_SIDE * f.segment[0] <= f.side
        and f.segment[0] <= FINE_ELEMENT * f.element.size
    )


def _turns(f: Facts) -> tuple[int, ...]:
    """The turns that keep the look, the identity among them; only that one where turning would not help."""
    if f.lattice is not None or f.regions.two:
        return (0,)
    return tuple(p for p in TURNED if p in f.symmetry)


def _size(f: Facts) -> str:
    size = f.element.size
    return f"its elements are about {size} px large" if f.element.found else "the size of its elements is not seen"


def _differ(f: Facts) -> str:
    return f"It repeats by a lattice, and its periods differ by {100 * f.variation:.0f} % of its contrast."


def _goes_on(f: Facts) -> bool:
    """A picture of a lattice is extended; in holes, whose edges must stay, patches fit better than blocks."""
    canvas = f.canvas
    return canvas.start is not None and canvas.rim != 0 and canvas.guide is None and len(f.exemplars) == 1 and _two(f)


RULES: tuple[Rule, ...] = (
    Rule(
        "begun-lattice", "near-regular", "part of the canvas is filled already, its rim may change, and the exemplar "
        "has a lattice of two vectors",
        _goes_on, _lattice, lambda f: (_differ(f), "What is there goes on by its lattice."),
    ),
    Rule(
        "begun", "image-quilting", "part of the canvas is filled already",
        lambda f: f.canvas.start is not None, _nothing,
        lambda f: ("What is there goes on, by patches of the size of its elements.",),
    ),
    Rule(
        "guided", "image-quilting", "a guide says what is where",
        lambda f: f.canvas.guide is not None, _nothing, lambda f: ("Patches that follow what was painted.",),
    ),
    Rule(
        "several", "image-quilting", "more than one exemplar",
        lambda f: len(f.exemplars) > 1, _nothing,
        lambda f: ("Patches of all exemplars, of the size of their elements.",),
    ),
    Rule(
        "one-colour", "repeat", "all of it has one colour",
        lambda f: f.constant, _nothing, lambda f: ("All of it has one colour.",),
    ),
    Rule(
        "bent-courses", "near-regular", "courses that converge or bow, with a surer lattice once they are straight",
        lambda f: f.straight is not None, _straight_lattice,
        lambda f: ("Its courses converge or bow; laid straight they repeat by a lattice, and are grown straight.",),
    ),
    Rule(
        "equal-periods", "best-tile", f"a lattice of two vectors, and periods that differ by less than {EQUAL}",
        lambda f: _two(f) and f.variation < EQUAL, _lattice, lambda f: (_differ(f), "So one of them is enough."),
    ),
    Rule(
        "periods", "near-regular", "a lattice of two vectors",
        _two, _lattice, lambda f: (_differ(f), "Each of them is used."),
    ),
    Rule(
        "rows", "near-regular", "a lattice of one vector",
        _rows, _lattice,
        lambda f: ("Its rows lie one pitch apart, and nothing returns along them.", "Whole rows are kept."),
    ),
    # The place of `graphcut` (large elements, none of them to be cut) is here, above the generalists.
    Rule(
        "grain", "segment-based", "no lattice, and segments of at most 1/12 of the side and 0.55 of its elements",
        _fine, _nothing,
        lambda f: (
            "It repeats by no lattice.",
            f"Its grain of {f.segment[0]} px is far finer than its spots of {f.element.size} px: small patches mix it.",
        ),
    ),
    Rule(
        "turnable", "image-quilting", "no lattice, and it looks the same turned by a half or by quarters",
        lambda f: len(_turns(f)) > 1, lambda f: {"isometries": _turns(f)},
        lambda f: (
            "It repeats by no lattice.",
            f"Patches of the size of its elements suit it: {_size(f)}.",
            f"Turned by {'quarters' if len(_turns(f)) > 2 else 'a half'} it looks the same: patches may be, too.",
        ),
    ),
    Rule(
        "elements", "image-quilting", "everything else",
        lambda f: True, _nothing,
        lambda f: (
            "It repeats by no lattice." if f.lattice is None else "Its lattice is left aside, as it was asked.",
            f"Patches of the size of its elements suit it: {_size(f)}.",
        ),
    ),
)  # fmt: skip
"""First match leads; the methods of the later ones that hold are what remains if it cannot work."""


def warnings_of(f: Facts) -> tuple[str, ...]:
    """What no method can mend, in sentences that say what to do."""
    out: list[str] = []
    if f.side < SMALL:
        out.append(f"the exemplar is only {f.side} px on its shorter side; a larger one gives more to choose from.")
    if f.constant or f.canvas.start is not None or f.canvas.guide is not None:
        return tuple(out)
    if f.side >= SMALL and f.lattice is not None:
        longest = max((y * y + x * x) ** 0.5 for y, x in f.lattice.vectors) / UNIT
        if f.side < FEW_PERIODS * longest:
            out.append(f"the exemplar holds fewer than two periods of {longest:.0f} px; a larger one varies more.")
    elif f.side >= SMALL and f.across < FEW_ELEMENTS:
        out.append(
            f"the exemplar is {f.across:.1f} elements of {f.element.size} px across, so repeats will show; "
            "a larger exemplar varies more."
        )
    if f.regions.two:
        out.append(
            "the exemplar seems to show two textures side by side; crop it to one (--crop), or paint with both "
            "(intarsia paint)."
        )
    if f.light.strong and not f.exemplar.toroidal:
        out.append(
            f"{100 * f.light.share:.0f} % of what its parts differ by is one slope of light, {f.light.factor:.1f} "
            "times brighter on one side: flatten it (--flatten), if that is light and not the texture."
        )
    return tuple(out)
