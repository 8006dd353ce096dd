"""Quality score of a synthesised texture against its exemplar: a weighted sum of perceptual parts, 0 to 100.

Each part is normalised between an anchor for a true continuation and one for a bad result.

    found = ia.score("stones.png", "grown.png")
    found.total, found.parts["joins"].normalised, found.parts["joins"].measured

The formula, with the weights of :data:`~intarsia.judging.parts.PARTS` (docs/score.md says how they were found):

    normalised = 1 - (measured - good) / (bad - good), clipped to 0..1
    total = 100 * normalised "texture" * max(0, 1 - sum over the other parts of weight * visible * sqrt(1 - normalised))

``visible`` is 1, but for parts that measure repetition the grain of the exemplar, as repeats are not seen if every
window recurs in it anyway. The root makes the first flaws count more than further ones. "texture" is 1 if the output
has the exemplar's texture, and 0 if it has another.

Costs of joins are also returned locally.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from ..analysis import block_sums, factor_for
from ..analysis.features import features
from ..foundation import InputError
from ..foundation.arrays import Array, Int16, Pair
from ..foundation.geometry import Wrap
from ..model import Exemplar, Exemplars
from ..model.sourcemap import SourceMap
from .parts import PARTS, TEXTURE, Part, measured, sources_of
from .sources import STEP, Reference, Sources
from .windows import SIDE, block_means

CORNER = 512  # px, reduced: along an axis longer than 2 CORNER + AROUND only the first and last CORNER px are judged
WORDS = ((90, "clean"), (65, "some {}"), (40, "clear {}"), (0, "heavy {}"))
"""The least total of each verdict; chosen so that no output that a human grader called broken is "clean"
(docs/score.md)."""
AROUND = 32  # px, reduced, by which outputs are continued below and to the right along periodic axes

Pictures = Sequence[Int16]


class PartScore(NamedTuple):
    """One part of a score: its definition, the measured number, and the anchors at which it is 1 (good) and 0 (bad)."""

    part: Part
    measured: float
    good: float
    bad: float

    @property
    def normalised(self) -> float:
        """The normalised score of the part: 1 at the good anchor, 0 at the bad one."""
        return min(1.0, max(0.0, (self.bad - self.measured) / (self.bad - self.good)))


@dataclass(frozen=True)
class Score:
    """Quality of an output: ``total`` from 0 to 100, and its parts by name; higher is better.

    Attributes
    ----------
    parts : dict of str to PartScore
        The measured number of each part, its anchors and its normalised score.
    grain : float
        0 to 1: how rarely windows of the exemplar recur in it, the factor of losses by repetition.
    """

    parts: dict[str, PartScore]
    grain: float

    def __repr__(self) -> str:
        lost = {name: round(100 * self.loss(name)) for name in self.parts}
        less = ", ".join(f"{name} -{n}" for name, n in lost.items() if n)
        return f"<score: {self.total:.0f} of 100{less and ': ' + less}>"

    @property
    def total(self) -> float:
        """The total score: 100 for a true continuation, 0 at worst."""
        return max(0.0, 100 * (1 - sum(self.loss(name) for name in self.parts)))

    def loss(self, name: str) -> float:
        """Return what a part subtracts from the total, as a fraction of 1.

        "texture" subtracts its share of what the other parts leave.
        """
        one = self.parts[name]
        if one.part is TEXTURE:
            return (1 - one.normalised) * max(0.0, 1 - sum(self.loss(other) for other in self.parts if other != name))
        return one.part.weight * (self.grain if one.part.grainy else 1.0) * float((1 - one.normalised) ** 0.5)

    @property
    def ranked(self) -> list[str]:
        """The names of the parts, the largest loss first."""
        return sorted(self.parts, key=lambda name: -self.loss(name))

    @property
    def verdict(self) -> str:
        """The total in words (WORDS), with the flaw of the largest loss, such as "some cuts"."""
        if self.parts[TEXTURE.name].normalised < 0.5:
            return "not this texture"
        word = next(word for least, word in WORDS if self.total >= least)
        return word.format(self.parts[self.ranked[0]].part.flaw)

    def as_dict(self) -> dict[str, Any]:
        """Return the score for JSON; "worth" is the normalised score, and losses are of 100."""
        return {"total": round(self.total, 2), "verdict": self.verdict, "grain": round(self.grain, 3), "parts": {
            name: {
                "worth": round(one.normalised, 4), "measured": round(one.measured, 3), "unit": one.part.unit,
                "good": round(one.good, 3), "bad": round(one.bad, 3), "loss": round(100 * self.loss(name), 2),
                "weight": one.part.weight,
            } for name, one in self.parts.items()
        }}  # fmt: skip


class JudgedPart(NamedTuple):
    """A judged part of an output: its first row and column, px, and the sources of its windows, one for each size."""

    begin: Pair
    sources: tuple[Sources, ...]


@dataclass(frozen=True, eq=False)
class Judged:
    """A score, and the judged parts of the output, which is reduced `factor` times, as its exemplars are."""

    score: Score
    reference: Reference
    looks: tuple[JudgedPart, ...]
    factor: int


def judge(exemplars: Exemplars, output: Exemplar, wrap: Wrap = Wrap.NONE) -> Judged:
    """Judge a picture by its base plane; InputError if its channels differ from the exemplars'."""
    first, base = exemplars[0].base, output.base
    if (base.kind, base.channels) != (first.kind, first.channels):
        raise InputError(
            f"{output.name} has {base.channels} channels of {base.kind.value}, {exemplars[0].name} {first.channels} of "
            f"{first.kind.value}; give two pictures of one make-up."
        )
    alone = [Exemplar({"base": e.base}, e.usable, e.toroidal, e.name) for e in (*exemplars, output)]
    *pictures, mine = features(alone).pictures
    return _judged(reference_scales(pictures, exemplars), mine, wrap)


def score_map(exemplars: Exemplars, smap: SourceMap) -> Score:
    """Return the score of a map without holes, rendered in feature space without feathering."""
    feats = features(exemplars)
    pictures = [p[..., : feats.base] for p in feats.pictures]
    known = feats.memo("judging", lambda: reference_scales(pictures, exemplars))  # several maps of the same are judged
    return _judged(known, render_features(pictures, smap), smap.wrap).score


def render_features(pictures: Pictures, smap: SourceMap) -> Int16:
    """Return a map rendered in feature space (H, W, C), without feathering."""
    if smap.which is None:
        return np.asarray(pictures[0][smap.yx[..., 0], smap.yx[..., 1]])
    out = np.zeros((*smap.shape, pictures[0].shape[2]), np.int16)
    for number, picture in enumerate(pictures):
        at = smap.which == number
        out[at] = picture[smap.yx[at, 0], smap.yx[at, 1]]
    return out


class ReferenceScales(NamedTuple):
    """Measurements of exemplars for all outputs: reduction factor, reference windows, bad anchors from random tiles."""

    factor: int
    reference: Reference
    worst: dict[str, float]

    def reduced(self, output: Int16) -> Int16:
        """Return an output reduced `factor` times and clipped to the range of the exemplars' features, per channel.

        Within that range distances of windows are exact in float32.
        """
        pictures = self.reference.pictures
        low, high = (f([f(p.reshape(-1, p.shape[2]), axis=0) for p in pictures], axis=0) for f in (np.min, np.max))
        return np.asarray(np.clip(block_means(output, self.factor), low, high), np.int16)


def reference_scales(pictures: Pictures, exemplars: Exemplars) -> ReferenceScales:
    """Return the measurements of exemplars, given the features of their base planes (H, W, C)."""
    factor = max(factor_for(p.shape) for p in pictures)  # large ones are reduced
    masks = (e.usable for e in exemplars)
    reference = Reference(
        tuple(np.asarray(block_means(p, factor), np.int16) for p in pictures),
        tuple(None if m is None else block_sums(m, factor) == factor * factor for m in masks),
    )
    by_tiles = [part for part in PARTS if part.bad is None]
    tiles = reference.tiles
    return ReferenceScales(factor, reference, measured(reference, tiles, sources_of(reference, tiles), by_tiles))


def _judged(known: ReferenceScales, output: Int16, wrap: Wrap) -> Judged:
    factor, reference, worst = known
    looks, told_by = list[JudgedPart](), list[dict[str, float]]()
    for (y, x), picture in _corners(known.reduced(output), wrap):
        sources = tuple(sources_of(reference, picture))
        looks.append(JudgedPart((y * factor, x * factor), sources))
        told_by.append(measured(reference, picture, sources))
    parts = {}
    for part in PARTS:
        bad = worst[part.name] if part.bad is None else part.bad
        seen = sum(one[part.name] for one in told_by) / len(told_by)
        parts[part.name] = PartScore(part, seen, part.good, max(bad, part.good + part.least))
    return Judged(Score(parts, reference.grain), reference, tuple(looks), factor)


def _corners(output: Int16, wrap: Wrap) -> list[tuple[Pair, Int16]]:
    """Return the parts of a reduced output that are judged, and the first pixel of each.

    All of it, continued by AROUND px along periodic axes; only the two ends of axes that are too long.
    """
    around = [(0, AROUND if closed else 0) for closed in wrap.closed]
    output = np.pad(output, (*around, (0, 0)), "wrap")
    short = 2 * CORNER + AROUND
    spans = ([slice(n)] if n <= short else [slice(CORNER), slice(n - CORNER, n)] for n in output.shape[:2])
    return [((rows.start or 0, columns.start or 0), output[rows, columns]) for rows, columns in product(*spans)]


SIZES = 2  # joins are located by windows of so many sizes, the smallest ones


def local_join_costs(judged: Judged, size: Pair) -> Array:
    """Return the local cost of joins in an output of `size`, 0 to 1, where 1 is the distance of unrelated windows.

    One number for each square of 8 px of the reduced output: (rows, columns). What was not judged has the cost of the
    nearest place that was.
    """
    rows, columns = (-(-n // (STEP * judged.factor)) for n in size)
    total, count = np.zeros((rows, columns)), np.zeros((rows, columns), np.int64)
    for look in judged.looks:
        top, left = (at // (STEP * judged.factor) for at in look.begin)
        for sources in look.sources[:SIZES]:
            right, below = sources.join_costs / 1024
            y, x = (at + SIDE * sources.level.windows.factor // (2 * STEP) for at in (top, left))
            for change in (right[:, 1:], below[1:]):  # the first have no predecessor
                high, wide = min(change.shape[0], rows - y), min(change.shape[1], columns - x)
                total[y : y + high, x : x + wide] += change[:high, :wide]
                count[y : y + high, x : x + wide] += 1
    known = [np.flatnonzero(count.any(axis=1 - axis)) for axis in (0, 1)]
    if not count.any():
        return total
    rim = (np.clip(np.arange(n), at[0], at[-1]) for n, at in zip(total.shape, known, strict=True))
    return np.asarray((total / np.maximum(count, 1))[np.ix_(*rim)])
