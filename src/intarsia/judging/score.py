"""How good an output is, as people would say: parts between an anchor that is good and one that is bad, and their sum.

    found = ia.score("stones.png", "grown.png")
    found.total, found.parts["joins"].worth, found.parts["joins"].measured

The formula, with the weights of :data:`~intarsia.judging.parts.PARTS` (docs/score.md says how they were found):

    worth of a part = 1 - (measured - good) / (bad - good), held between 0 and 1
    total = 100 * worth of "texture" * (1 - sum of weight * visible * sqrt(1 - worth)), at least 0

``visible`` is 1, and for what is shown too often the grain of the exemplar: where every window returns, repeats are
not seen. The root makes a first flaw count more than the tenth. "texture" is worth 1 where the output is of the
exemplar's texture, and nothing where it is of another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import features
from ..analysis.reduction import block_sums, factor_for
from ..errors import InputError
from ..exemplar import Exemplar
from ..geometry import Wrap
from ..sourcemap import SourceMap
from .parts import PARTS, TEXTURE, Part, measured, sources_of
from .reference import Reference
from .sources import Sources
from .windows import smaller

WORK_SIDE = 512  # px: larger exemplars, and what is grown from them, are looked at on reduced copies
CORNER = 512  # px: of an output of more than twice as much a side, its corners are looked at, so large each
WORDS = ((90, "clean"), (65, "some {}"), (40, "clear {}"), (0, "heavy {}"))
"""The least total of each word: nothing that a grader called broken is clean (docs/score.md)."""
AROUND = 32  # px: an output that wraps is looked at so far beyond its borders

Pictures = Sequence[NDArray[np.int16]]


@dataclass(frozen=True)
class Worth:
    """One part of a score: what it is, the number that was measured, and the numbers that are worth 1 and 0."""

    part: Part
    measured: float
    good: float
    bad: float

    @property
    def worth(self) -> float:
        """1 for a true continuation, 0 for what is worth nothing."""
        return min(1.0, max(0.0, (self.bad - self.measured) / (self.bad - self.good)))


@dataclass(frozen=True)
class Score:
    """How good an output is: ``total`` from 0 to 100, and its parts by name; more is better.

    ``grain`` says how little the exemplar repeats itself, 0 to 1.
    """

    parts: dict[str, Worth]
    grain: float

    def __repr__(self) -> str:
        lost = {name: round(100 * self.loss(name)) for name in self.parts}
        less = ", ".join(f"{name} -{n}" for name, n in lost.items() if n)
        return f"<score: {self.total:.0f} of 100{less and ': ' + less}>"

    @property
    def total(self) -> float:
        """The one number: 100 for a true continuation, 0 where nothing is right."""
        return max(0.0, 100 * (1 - sum(self.loss(name) for name in self.parts)))

    def loss(self, name: str) -> float:
        """How much one part takes from the total, of 1; another texture takes of what the others leave."""
        one = self.parts[name]
        if one.part is TEXTURE:
            return (1 - one.worth) * max(0.0, 1 - sum(self.loss(other) for other in self.parts if other != name))
        return one.part.weight * (self.grain if one.part.grainy else 1.0) * float((1 - one.worth) ** 0.5)

    @property
    def ranked(self) -> list[str]:
        """The names of the parts, what takes most first."""
        return sorted(self.parts, key=lambda name: -self.loss(name))

    @property
    def verdict(self) -> str:
        """The total in words, with what takes most from it."""
        if self.parts[TEXTURE.name].worth < 0.5:
            return "not this texture"
        word = next(word for least, word in WORDS if self.total >= least)
        return word.format(self.parts[self.ranked[0]].part.flaw)

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON."""
        return {"total": round(self.total, 2), "verdict": self.verdict, "grain": round(self.grain, 3), "parts": {
            name: {
                "worth": round(one.worth, 4), "measured": round(one.measured, 3), "unit": one.part.unit,
                "good": round(one.good, 3), "bad": round(one.bad, 3), "loss": round(100 * self.loss(name), 2),
                "weight": one.part.weight,
            } for name, one in self.parts.items()
        }}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Look:
    """A part of an output that was looked at: row and column where it begins, in px, and what its windows show."""

    begin: tuple[int, int]
    sources: tuple[Sources, ...]


@dataclass(frozen=True, eq=False)
class Judged:
    """A score, and what was seen when it was found: parts of the output, reduced `factor` times as the exemplars."""

    score: Score
    looks: tuple[Look, ...]
    factor: int

    @property
    def alone(self) -> Judged:
        """The score, without what was seen."""
        return Judged(self.score, (), self.factor)


def judge(exemplars: Sequence[Exemplar], output: Exemplar, wrap: Wrap = Wrap.NONE) -> Judged:
    """Judge a picture by its base plane; InputError where that has other channels than the exemplars'."""
    first, base = exemplars[0].base, output.base
    if (base.kind, base.channels) != (first.kind, first.channels):
        raise InputError(
            f"{output.name} has {base.channels} channels of {base.kind.value}, {exemplars[0].name} {first.channels} of "
            f"{first.kind.value}; give two pictures of one make-up."
        )
    alone = [Exemplar({"base": e.base}, e.usable, e.toroidal, e.name) for e in (*exemplars, output)]
    *pictures, mine = features(alone).pictures
    return _judged(known_of(pictures, exemplars), mine, wrap)


def score_map(exemplars: Sequence[Exemplar], smap: SourceMap) -> Score:
    """Judge a map without holes by the pixels that it shows, not mixed at its cuts."""
    feats = features(exemplars)
    pictures = [p[..., : feats.base] for p in feats.pictures]
    known = feats.memo("judging", lambda: known_of(pictures, exemplars))  # several maps of the same are judged
    return _judged(known, drawn(pictures, smap), smap.wrap).score


def drawn(pictures: Pictures, smap: SourceMap) -> NDArray[np.int16]:
    """Return the output in features (H, W, C): every pixel as its exemplar has it."""
    if smap.which is None:
        return np.asarray(pictures[0][smap.yx[..., 0], smap.yx[..., 1]])
    out = np.zeros((smap.height, smap.width, pictures[0].shape[2]), np.int16)
    for number, picture in enumerate(pictures):
        at = smap.which == number
        out[at] = picture[smap.yx[at, 0], smap.yx[at, 1]]
    return out


class Known(NamedTuple):
    """What is measured of exemplars once for all outputs: reduced `factor` times, and what their tiles measure."""

    factor: int
    reference: Reference
    worst: dict[str, float]

    def reduced(self, output: NDArray[np.int16]) -> NDArray[np.int16]:
        """An output as the exemplars are looked at, held in their range, for which distances are exact."""
        pictures = self.reference.pictures
        low, high = (f([f(p.reshape(-1, p.shape[2]), axis=0) for p in pictures], axis=0) for f in (np.min, np.max))
        return np.asarray(np.clip(smaller(output, self.factor), low, high), np.int16)


def known_of(pictures: Pictures, exemplars: Sequence[Exemplar]) -> Known:
    """Measure exemplars by the features of their base planes (H, W, C)."""
    factor = max(factor_for(p.shape, WORK_SIDE) for p in pictures)
    masks = (e.usable for e in exemplars)
    reference = Reference(
        tuple(np.asarray(smaller(p, factor), np.int16) for p in pictures),
        tuple(None if m is None else block_sums(m, factor) == factor * factor for m in masks),
    )
    by_tiles = [part for part in PARTS if part.bad is None]
    tiles = reference.tiles
    return Known(factor, reference, measured(reference, tiles, sources_of(reference, tiles), by_tiles))


def _judged(known: Known, output: NDArray[np.int16], wrap: Wrap) -> Judged:
    factor, reference, worst = known
    looks, told_by = list[Look](), list[dict[str, float]]()
    for (y, x), picture in _corners(known.reduced(output), wrap):
        sources = tuple(sources_of(reference, picture))
        looks.append(Look((y * factor, x * factor), sources))
        told_by.append(measured(reference, picture, sources))
    parts = {}
    for part in PARTS:
        bad = worst[part.name] if part.bad is None else part.bad
        seen = sum(one[part.name] for one in told_by) / len(told_by)
        parts[part.name] = Worth(part, seen, part.good, max(bad, part.good + part.least))
    return Judged(Score(parts, reference.grain), tuple(looks), factor)


def _corners(output: NDArray[np.int16], wrap: Wrap) -> list[tuple[tuple[int, int], NDArray[np.int16]]]:
    """The output, a little beyond where it wraps, or the corners of a large one; and where each begins."""
    around = [(0, AROUND if closed else 0) for closed in (wrap.y, wrap.x)]
    output = np.pad(output, (*around, (0, 0)), "wrap")
    short = 2 * CORNER + AROUND
    ends = ([slice(n)] if n <= short else [slice(CORNER), slice(n - CORNER, n)] for n in output.shape[:2])
    spans = list(ends)
    return [
        ((rows.start or 0, columns.start or 0), output[rows, columns]) for rows in spans[0] for columns in spans[1]
    ]
