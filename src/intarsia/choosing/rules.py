"""The table of rules of automatic choice; the first rule that holds decides.

A rule triggers only the measurements that it needs, so in a picture with a lattice no stones are searched. To add a
method, add one line to RULES, above the general ones: name, condition, method, parameters, and the reason in a
sentence. The table of rules in docs/auto.md is generated from this one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from ..foundation import Record
from ..foundation.geometry import Wrap
from ..lattice import vectors_of
from ..lattice.decision import Lattice
from .facts import JOINTED, ONE_PICTURE, OUTLINED, STEPPED, Facts

VAST = 1 << 24  # px: largest output of graph cuts; 4096 x 4096 px take two minutes, six with a lattice, below 1 GB


class ChoiceRule(NamedTuple):
    """One line of the table.

    ``holds`` is the condition and ``when`` the same in words, for the documentation; ``parameters`` returns the
    parameters of the method that the rule decides (vectors as (x, y)), ``why`` the reasons in sentences.
    """

    name: str
    method: str
    when: str
    holds: Callable[[Facts], bool]
    parameters: Callable[[Facts], Record]
    why: Callable[[Facts], tuple[str, ...]]


def _nothing(f: Facts) -> Record:
    return {}


def _goes_on(f: Facts) -> bool:
    """Whether a picture with a 2-D lattice is extended; holes, whose rim is 0, may lie beside its lattice."""
    canvas = f.canvas
    begun = canvas.start is not None and canvas.rim != 0 and canvas.guide is None and len(f.exemplars) == 1
    return begun and canvas.height * canvas.width <= VAST and f.two is not None


def _closes(f: Facts) -> bool:
    """Whether a picture is made tileable: the start map has holes along its wrapped borders, and a rim may change."""
    canvas = f.canvas
    if canvas.start is None or canvas.guide is not None or not canvas.rim or canvas.wrap is Wrap.NONE:
        return False
    holes = canvas.start.holes
    meet = [holes[[0, -1]]] * canvas.wrap.y + [holes[:, [0, -1]]] * canvas.wrap.x
    return all(bool(border.all()) for border in meet)


def _by(lattice: Lattice | None, **more: Any) -> Record:
    """Return the vectors of a lattice as a parameter, and what else is given."""
    assert lattice is not None
    return {"lattice": vectors_of(lattice), **more}


def _lattice(f: Facts) -> Record:
    return _by(f.lattice)


def _lattice_aligned(f: Facts) -> bool:
    """Whether elements follow a lattice, and graph-cut patches are to be aligned to it.

    Not on endless or vast canvases. Not if clear joints (`Facts.joints`) between outlined elements (`Facts.outlines`)
    separate its periods: then blocks of whole periods are placed, and all periods are used equally often; but on a
    periodic canvas, on which blocks do not always close, patches are aligned even so. Nor if the lattice is only loose
    and there are courses of stones: these are placed by their courses.
    """
    canvas = f.canvas
    if canvas.endless or canvas.height * canvas.width > VAST or f.about is None:
        return False
    if canvas.wrap is Wrap.NONE and f.joints <= JOINTED and f.outlines >= OUTLINED:
        return False
    return f.lattice is not None or f.masonry is None


def _free(f: Facts) -> bool:
    """Whether it has no lattice, and the canvas is small enough for graph cuts."""
    return f.lattice is None and f.canvas.height * f.canvas.width <= VAST


def _size(f: Facts) -> str:
    size = f.element.size
    return f"its elements are about {size} px large" if f.element.found else "the size of its elements is not seen"


def _stones(f: Facts) -> tuple[str, ...]:
    assert f.masonry is not None
    return (
        "It repeats by no lattice.",
        f"{f.masonry.told}: stones are laid whole, each in a course about as high as it is.",
    )


def _differ(f: Facts) -> str:
    return f"It repeats by a lattice, and its periods differ by {100 * f.variation:.0f} % of its contrast."


RULES: tuple[ChoiceRule, ...] = (
    ChoiceRule(
        "closing", "graphcut", "all of the canvas is filled already but the borders, which are to continue in each "
        "other, and what lies beside them may change",
        _closes, lambda f: {"evenness": 0.0},  # nearly all of it is shown once, as it lies
        lambda f: ("Across the borders patches are cut in whose seams are free to run around its elements.",),
    ),
    ChoiceRule(
        "begun-lattice", "graphcut", "part of the canvas is filled already, its rim may change, the exemplar has a "
        f"lattice of two vectors, and the canvas at most {VAST >> 20} million px",
        _goes_on, lambda f: _by(f.two, evenness=STEPPED),
        lambda f: (_differ(f), "What is there goes on by patches of free shape, whole steps of it apart."),
    ),
    ChoiceRule(
        "begun", "image-quilting", "part of the canvas is filled already",
        lambda f: f.canvas.start is not None, _nothing,
        lambda f: ("What is there goes on, by patches of the size of its elements.",),
    ),
    ChoiceRule(
        "transfer", "parallel-controllable", "a picture to look like, and one exemplar",
        lambda f: f.canvas.guide is not None and not f.canvas.guide.is_labels and len(f.exemplars) == 1,
        _nothing, lambda f: ("Pixels that follow the tones of the picture, closer than patches can.",),
    ),
    ChoiceRule(
        "guided", "graphcut", "a guide says what is where",
        lambda f: f.canvas.guide is not None, _nothing,
        lambda f: ("Patches of free shape that follow what was painted.",),
    ),
    ChoiceRule(
        "several", "image-quilting", "more than one exemplar",
        lambda f: len(f.exemplars) > 1, _nothing,
        lambda f: ("Patches of all exemplars, of the size of their elements.",),
    ),
    ChoiceRule(
        "one-colour", "repeat", "all of it has one colour",
        lambda f: f.constant, _nothing, lambda f: ("All of it has one colour.",),
    ),
    ChoiceRule(
        "bent-courses", "near-regular", "courses that converge or bow, with a surer lattice once they are straight",
        lambda f: f.straight is not None, lambda f: _by(f.straight and f.straight[1], straighten="on"),
        lambda f: ("Its courses converge or bow; laid straight they repeat by a lattice, and are grown straight.",),
    ),
    ChoiceRule(
        "equal-periods", "best-tile", f"a lattice of two vectors, and periods that differ by less than {ONE_PICTURE}",
        lambda f: f.two is not None and f.variation < ONE_PICTURE, _lattice,
        lambda f: (_differ(f), "So one of them is enough."),
    ),
    ChoiceRule(
        "in-step", "graphcut", "a lattice of two vectors, or one that its elements lie about other than stones "
        f"between lines, and a canvas of at most {VAST >> 20} million px; where that does not wrap, no clear joints of "
        "outlined periods",
        _lattice_aligned, lambda f: _by(f.about, evenness=STEPPED),
        lambda f: (
            _differ(f) if f.two is not None else "Its elements lie about a lattice, though it does not repeat by it.",
            "Patches of free shape, whole steps of it apart, keep in step and go around what crosses.",
        ),
    ),
    ChoiceRule(
        "periods", "near-regular", "a lattice of two vectors, and a canvas that does not wrap",
        lambda f: f.two is not None and f.canvas.wrap is Wrap.NONE, _lattice,
        lambda f: (_differ(f), "Each of them is used."),
    ),
    ChoiceRule(
        "rows", "near-regular", "a lattice of one vector",
        lambda f: f.two is None and f.lattice is not None, _lattice,
        lambda f: ("Its rows lie one pitch apart, and nothing returns along them.", "Whole rows are kept."),
    ),
    ChoiceRule(
        "courses", "near-regular", "no lattice, and lines that run across it between courses of "
        "stones that are told apart",
        lambda f: f.lattice is None and f.masonry is not None, lambda f: {"course_heights": "unequal"}, _stones,
    ),
    ChoiceRule(
        "elements", "graphcut", f"no lattice, and a canvas of at most {VAST >> 20} million px",
        _free,
        _nothing,
        lambda f: (
            "It repeats by no lattice.",
            f"Patches cut around its elements suit it: {_size(f)}.",
        ),
    ),
    ChoiceRule(
        "patches", "image-quilting", "everything else",
        lambda f: True, _nothing,
        lambda f: (
            "Its lattice is left aside, as it was asked." if f.lattice is not None
            else "It repeats by no lattice, and patches of free shape would take many minutes." if not _free(f)
            else "It repeats by no lattice.",
            f"Patches of the size of its elements suit it: {_size(f)}.",
        ),
    ),
    ChoiceRule(
        "endless", "parallel-controllable", "windows of an endless texture are asked for, and it has no lattice",
        lambda f: True, _nothing,
        lambda f: ("Any window of it can be made alone, from coarse to fine, in pieces of every size.",),
    ),
)  # fmt: skip
"""The first rule that holds decides; if its method fails, those of later rules that hold are used in turn."""
