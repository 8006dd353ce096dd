"""Damaged elements of a map, covered by whole ones.

A cut through a stone is not mended by another cut: the patch has to be another. So elements of the exemplar are known
(`segments/wholes.py`), and a body of the map that is made of parts of several, or of too little of one, is covered by a
whole element that has about its size: one of the exemplar, laid where it covers the body best and its neighbours least;
or the one that shows in part, completed; or the body dissolves in what goes on beside it. The element must be taken,
what is around it may be, by maximum flow; seams are dear deep inside elements, and cheap where a joint is shown. It
stays where less damage is seen than before, and seams do not become dearer in proportion.

Source: seams and cut of Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003; that whole shapes
are laid, where they fit, is after Dischler, Maritaud, Levy and Ghazanfarpour, "Texture Particles", Eurographics 2002.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..analysis.features import pose_array
from ..arrays import Array, Int32, Mask, Pair
from ..exemplar import Exemplar
from ..geometry import apart, widened
from ..kernels.cuts import SeamPrice
from ..kernels.pieces_of_maps import boxes_of_parts
from ..lazy import ndimage
from ..patches.growing_map import Pick
from ..run import Run
from ..search.candidates import PosedExemplars
from ..segments.wholes import Wholes, wholes
from . import whole_kernels as kernels
from .graphcut import Box, Cut, GraphcutGrowth, laid_out
from .whole_kernels import Counts, Shown

RING = 4  # px: so far around an element its joint is wanted
RIM = 5  # px: elements so near the exemplar's border may not be whole


@dataclass(frozen=True, eq=False)
class Element:
    """A whole element of a variant: where its mask begins, the mask, and around it the joint that is wanted."""

    variant: int
    at: Pair
    mask: Mask
    ring: Mask
    whole: bool

    @property
    def side(self) -> float:
        """Root of its area, px."""
        return math.sqrt(int(self.mask.sum()))


class Elements:
    """All elements of posed exemplars, from 1."""

    def __init__(self, variants: PosedExemplars, found: list[Wholes]) -> None:
        self.all = list[Element]()
        labels, sure, boxes, masks, begin = [], [0.0], [], [], 0
        for v in range(len(variants)):
            mine, shape = found[int(variants.exemplar[v])], variants.picture(v).shape[:2]
            names = pose_array(mine.labels, int(variants.pose[v]))
            pad = [(0, n - m) for n, m in zip(shape, names.shape, strict=True)]
            labels.append(np.pad(np.where(names > 0, names + len(self.all), 0), pad).ravel())
            ends = np.zeros((int(names.max(initial=0)), 5), np.int64)
            boxes_of_parts(np.ascontiguousarray(names), (False, False), ends)
            for k, (top, left, height, width) in enumerate(ends[:, :4].tolist(), 1):
                part = np.s_[top : top + height, left : left + width]
                element = _element(v, names, part, names[part] == k)
                if element.whole:
                    y, x = (int(at.mean()) for at in np.nonzero(element.mask))
                    boxes.append((begin, *element.mask.shape, int(element.mask.sum()), y, x, len(self.all) + 1))
                    masks.append(element.mask.ravel())
                    begin += element.mask.size
                self.all.append(element)
            sure += mine.sure[1:].tolist()
        self.labels = np.concatenate(labels).astype(np.int32)
        self.inside = laid_out(variants, [mine.inside for mine in found])
        every = np.array([0, *(int(e.mask.sum()) for e in self.all)], np.int64)
        self.known = every, np.array(sure)
        self.boxes = np.array(boxes, np.int64).reshape(-1, 7)
        self.masks = np.concatenate(masks) if masks else np.zeros(0, bool)

    def __getitem__(self, number: int) -> Element:
        return self.all[number - 1]


def _element(v: int, names: Array, part: tuple[slice, ...], mask: Mask) -> Element:
    (h, w), n = names.shape, RING
    off = [part[0].start < RIM, part[1].start < RIM, part[0].stop > h - RIM, part[1].stop > w - RIM]
    big = np.pad(mask, n)
    ring = ndimage.binary_dilation(big, iterations=n) & ~big
    y, x = np.nonzero(ring)
    y, x = y + part[0].start - n, x + part[1].start - n
    free = (y >= 0) & (x >= 0) & (y < h) & (x < w)
    free[free] = names[y[free], x[free]] == 0
    ring[ring] = free
    return Element(v, (part[0].start, part[1].start), mask, ring, not any(off))


MUST = 1 << 24  # what it costs to leave what must be taken
STRIP = 256  # rows of the canvas that are looked at together: nothing larger is held besides the map


# What is weighed how: chosen by eye on 13 textures:
INSIDE = 64  # of 64 knees: what a seam through the middle of an element costs, each side
OUTLINED = 51  # of 64: how much less a seam costs that shows a joint
HURT = 3.0  # knees: what damage costs, for each px of the root of an element's area
USAGE = 0.7  # knees: what it costs, for the same, to show an element twice as often as others
DAMAGED = 0.12  # of a body: so much of its elements is missing, or too much there
LEAST = 40  # px: smaller bodies are no elements
TRIES = 6  # elements laid over a body
BESIDE = 2  # pieces beside it that may go on in its place
APART = 1.3  # of the root of its area: the same element is not laid so near
PAD = 0.4  # of the root of an element's area, and 6 px: so far around it the cut may run
JOINT = 1.0  # knees, for each px of an element's joint: so much it is wanted
FEWEST = 6  # elements: of fewer there is no choice
ROUGH = 2  # px from one to the next where candidates are compared


class Candidate(NamedTuple):
    """A patch over a box, and what leaving each px costs; the element that it lays, 0: none."""

    box: Box
    pick: Pick
    wanted: Int32
    element: int


def make_whole(sewn: GraphcutGrowth, exemplars: list[Exemplar], rounds: int, run: Run) -> int:
    """Cover damaged elements of a full map, in so many rounds; returns how many patches were laid.

    A map of exemplars of which one has no elements stays as it is, byte for byte.
    """
    found = [wholes(e) for e in exemplars] if rounds else []
    known = [w for w in found if w is not None]
    if not rounds or len(known) < len(found):
        return 0
    elements = Elements(sewn.variants, known)
    if len(elements.boxes) < FEWEST:
        return 0
    work, laid = Mending(sewn, elements), 0
    for number in range(rounds):
        now = work.cover(run.part(number, rounds))
        laid += now
        if not now:
            break
    return laid


class Mending:
    """A full map whose damaged elements are covered."""

    def __init__(self, sewn: GraphcutGrowth, elements: Elements) -> None:
        self.sewn, self.elements = sewn, elements
        self.knee = sewn.growth.seam_price("sharp").knee
        sewn.pieces = sewn.pieces._replace(inside=elements.inside)
        sewn.price = SeamPrice(knee=self.knee, inside=INSIDE, outlined=OUTLINED)
        self.shape: Pair = (sewn.variant.shape[0], sewn.variant.shape[1])
        self.joined = np.zeros(self.shape, np.int32)

    def cover(self, run: Run) -> int:
        """Cover every damaged body once; returns how many patches were laid."""

        def promised(candidate: Candidate) -> float:
            return self._price(candidate, self._cut(candidate, ROUGH), ROUGH)

        self.number()
        laid = 0
        bodies = self._damaged()
        for number, (body, box) in enumerate(bodies):
            run.tick(number, len(bodies), self.sewn.growth.draft)
            mine = self.shown.body[self.joined[self.sewn.index(box)]] == body
            room = len(self.shown.area) - self.count > len(self.elements.known[0])
            if int(mine.sum()) * 4 < 3 * int(self.size[body]) or not room:
                continue  # covered in part since, or no room
            best = min(self._candidates(body, box, mine), key=promised, default=None)
            if best is not None:
                cut = self._cut(best, 1)
                if self._price(best, cut, 1) < 0:
                    self._lay(best, cut)
                    laid += 1
        self.sewn.note((0, 0, *self.shape))
        return laid

    def number(self) -> None:
        """Number the pieces of elements that the map shows, and join those that meet inside."""
        sewn, elements = self.sewn, self.elements
        meets = np.zeros((sewn.variant.size // 4, 2), np.int32)
        count, n = kernels.number_pieces(sewn.grown, sewn.pieces, elements.labels, self.joined, meets)
        self.count = int(count) + 1
        room = 4 * self.count + 2 * len(elements.known[0])
        zeros = np.zeros(room, np.int64)
        self.shown = Shown(zeros, np.zeros((room, 2), np.int64), zeros.copy(), zeros.copy(), np.arange(room))
        got, on, names = np.zeros((3, len(elements.known[0])), np.int64)
        self.counts = Counts(zeros.copy(), got, on, zeros.copy(), names)
        rows, columns = self.shape
        first = np.zeros(self.count, np.int64)
        for top in range((rows - 1) // STRIP * STRIP, -1, -STRIP):  # from the last pixel to the first, which stays
            strip = self.joined[top : top + STRIP]
            first[strip.ravel()[::-1]] = np.arange(top * columns, top * columns + strip.size)[::-1]
            self.shown.area[: self.count] += np.bincount(strip.ravel(), minlength=self.count)
        pieces, table = np.flatnonzero(self.shown.area[: self.count]), sewn.pieces.table
        y, x = np.divmod(first[pieces], columns)
        at, v = sewn.yx[y, x].astype(np.int64), sewn.variant[y, x]
        flat = table[v, 0] // sewn.pieces.channels + at[:, 0] * table[v, 3] + at[:, 1]
        self.shown.element[pieces] = np.where(pieces > 0, elements.labels[flat], 0)
        self.shown.shift[pieces] = np.stack([y, x], axis=1) - at
        self.shown.whole[:] = elements.known[0][self.shown.element]
        self._at_borders()
        pairs, often = np.unique(np.sort(meets[:n], axis=1), axis=0, return_counts=True)
        body = self.shown.body
        for a, b in pairs[often >= 3].tolist():
            while body[a] != a:
                a = body[a]
            while body[b] != b:
                b = body[b]
            body[max(a, b)] = min(a, b)
        for k in range(self.count):  # each follows an earlier one
            body[k] = body[body[k]]

    def _at_borders(self) -> None:
        """What borders of the canvas cut off is not missing."""
        rims = [np.take(self.joined, (0, -1), axis) for axis in (0, 1) if not self.sewn.wraps[axis]]
        for k in np.unique(np.concatenate([rim.ravel() for rim in rims])).tolist() if rims else ():
            if k:
                element = self.elements[int(self.shown.element[k])]
                y, x = (np.nonzero(element.mask)[a] + element.at[a] + int(self.shown.shift[k, a]) for a in (0, 1))
                inside = np.ones(len(y), bool)
                for axis, at in enumerate((y, x)):
                    if not self.sewn.wraps[axis]:
                        inside &= (at >= 0) & (at < self.shape[axis])
                self.shown.whole[k] = max(int(inside.sum()), 1)

    def _damaged(self) -> list[tuple[int, Box]]:
        """The damaged bodies and their boxes, those with the dearest seams first; of equal ones the largest."""
        body, bodies = np.empty(self.shape, np.int32), self.shown.body.astype(np.int32)
        self.size = np.zeros(len(self.shown.area), np.int64)
        for top in range(0, self.shape[0], STRIP):
            strip = body[top : top + STRIP]
            np.take(bodies, self.joined[top : top + STRIP], out=strip, mode="clip")
            self.size += np.bincount(strip.ravel(), minlength=len(self.size))
        missing = np.minimum(self.shown.area, self.shown.whole - self.shown.area)
        hidden = np.bincount(self.shown.body, np.maximum(missing, 0), len(self.size))
        out, boxes = [], np.empty((int(body.max()), 5), np.int64)
        boxes_of_parts(body, self.sewn.wraps, boxes)
        for k, (y, x, h, w, area) in enumerate(boxes.tolist(), 1):
            if not area or hidden[k] < DAMAGED * area or area < LEAST:
                continue
            if any(5 * side > 3 * n for side, n in zip((h, w), self.shape, strict=True)):
                continue  # all one
            around = self.sewn.index(widened((y, x, h, w), 2, self.shape, self.sewn.wraps))
            out.append((-int(self.sewn.prices[around].sum()), -area, -hidden[k], h, w, k, (y, x, h, w)))
        self.often: dict[int, list[Pair]] = {}
        for k in range(1, self.count):
            if 2 * self.shown.area[k] > self.shown.whole[k]:
                y, x = self.shown.shift[k].tolist()
                self.often.setdefault(int(self.shown.element[k]), []).append((y, x))
        self.usual = sum(map(len, self.often.values())) / len(self.elements.boxes)
        return [(k, box) for *_, k, box in sorted(out)]

    # ---- candidates

    def _candidates(self, body: int, box: Box, mine: Mask) -> list[Candidate]:
        places = list[tuple[int, int, int]]()
        pieces, area = np.unique(self.joined[self.sewn.index(box)][mine], return_counts=True)
        for k in np.argsort(-area, kind="stable")[:3].tolist():  # what shows in part, whole
            number = int(self.shown.element[pieces[k]])
            y, x = self.shown.shift[pieces[k]].tolist()
            if self.elements[number].whole:
                places.append((number, y + self.elements[number].at[0], x + self.elements[number].at[1]))
        places += self._others(body, box, mine)
        found = [self._laid(*place) for place in places] + self._beside(box, mine)
        return [c for c in found if c is not None]

    def _others(self, body: int, box: Box, mine: Mask) -> list[tuple[int, int, int]]:
        """The elements that cover a body best: number, first row and column on the canvas."""
        middle = np.array([box[axis] + int(at.mean()) for axis, at in enumerate(np.nonzero(mine))])
        out, places = np.empty((len(self.elements.boxes), 4), np.int64), list[tuple[int, int, int]]()
        which = body, int(self.size[body]), middle
        masks = self.elements.masks, self.elements.boxes
        count = kernels.fits(self.joined, self.sewn.wraps, self.shown, which, masks, out)
        for k in np.argsort(out[:count, 0], kind="stable").tolist():
            number, y, x = out[k, 1:].tolist()
            element = self.elements[number]
            near, at = APART * element.side, (y - element.at[0], x - element.at[1])
            others = (map(apart, at, other, self.shape, self.sewn.wraps) for other in self.often.get(number, ()))
            if all(max(gaps) >= near for gaps in others):
                places.append((number, y, x))
                if len(places) == TRIES:
                    break
        return places

    def _laid(self, number: int, top: int, left: int) -> Candidate | None:
        """An element laid at a place of the canvas, with its joint."""
        element = self.elements[number]
        pad, size = 6 + int(PAD * element.side), self.sewn.variants.table[element.variant, 1:3]
        low, high = list[int](), list[int]()
        for axis, first in enumerate((top, left)):
            a, b = first - pad, first + element.mask.shape[axis] + pad
            if not self.sewn.variants.toroidal[element.variant]:
                a, b = max(a, first - element.at[axis]), min(b, first - element.at[axis] + int(size[axis]))
            if not self.sewn.wraps[axis]:
                a, b = max(a, 0), min(b, self.shape[axis])
            if not 8 <= b - a <= self.shape[axis]:
                return None
            low.append(a)
            high.append(b)
        wanted = np.zeros((high[0] - low[0], high[1] - low[1]), np.int32)
        n = RING
        _over(wanted, element.ring, (top - n - low[0], left - n - low[1]), int(JOINT * self.knee))
        _over(wanted, element.mask, (top - low[0], left - low[1]), MUST)
        pick = (element.variant, element.at[0] + low[0] - top, element.at[1] + low[1] - left)
        return Candidate((low[0] % self.shape[0], low[1] % self.shape[1], *wanted.shape), pick, wanted, number)

    def _beside(self, box: Box, mine: Mask) -> list[Candidate]:
        """What the pieces beside a body would show in its place."""
        sewn, wide = self.sewn, widened(box, 5, self.shape, self.sewn.wraps)
        where, own = sewn.index(wide), np.zeros(wide[2:], bool)
        top, left = ((box[axis] - wide[axis]) % self.shape[axis] for axis in (0, 1))
        own[top : top + mine.shape[0], left : left + mine.shape[1]] = mine
        if min(own.shape) < 8:
            return []
        y, x = np.nonzero(ndimage.binary_dilation(own, iterations=2) & ~own)
        at, v = sewn.yx[where][y, x], sewn.variant[where][y, x]
        shifts, first, often = np.unique(
            np.stack([v, at[:, 0] - y, at[:, 1] - x], axis=1), axis=0, return_index=True, return_counts=True
        )
        out = []
        for k in np.lexsort((first, -often))[: BESIDE].tolist():
            variant, row, column = shifts[k].tolist()
            size = sewn.variants.table[variant, 1:3].tolist()
            (a, b), (c, d) = (0, 0), own.shape
            if not sewn.variants.toroidal[variant]:  # no further than the exemplar reaches
                a, b = max(a, -row), max(b, -column)
                c, d = min(c, size[0] - row), min(d, size[1] - column)
            if min(c - a, d - b) >= 8 and not (own.sum() - own[a:c, b:d].sum()):
                top, left = (wide[0] + a) % self.shape[0], (wide[1] + b) % self.shape[1]
                pick = (variant, row + a, column + b)
                out.append(Candidate((top, left, c - a, d - b), pick, own[a:c, b:d] * np.int32(MUST), 0))
        return out

    # ---- choosing

    def _cut(self, candidate: Candidate, step: int) -> Cut:
        wanted: Callable[[Box, Pick], Array] = lambda box, pick: candidate.wanted  # noqa: E731
        return self.sewn.cut(candidate.box, candidate.pick, 0, step, saved=wanted)

    def _price(self, candidate: Candidate, cut: Cut, step: int) -> float:
        """What seams, damage and repeats of an element cost more than before; negative: less."""
        sewn, where = self.sewn, (*cut.box[:2], *cut.pick, step)
        what = self.joined, sewn.pieces, self.elements.labels, self.elements.known, self.shown
        hurt = kernels.hurt(*what, where, cut.take, self.counts)
        price = cut.change * step + HURT * self.knee * hurt
        if candidate.element:
            more = max(len(self.often.get(candidate.element, ())) - self.usual, 0) / max(self.usual, 1)
            price += USAGE * self.knee * self.elements[candidate.element].side * more
        return float(price)

    def _lay(self, candidate: Candidate, cut: Cut) -> None:
        sewn, labels, known = self.sewn, self.elements.labels, self.elements.known
        sewn.paste(cut)
        at = (*cut.box[:2], *cut.pick, 1)
        self.count = int(kernels.renew(self.joined, sewn.pieces, labels, known, self.shown, at, cut.take, self.count))
        if candidate.element:
            shift = cut.box[0] - cut.pick[1], cut.box[1] - cut.pick[2]
            self.often.setdefault(candidate.element, []).append(shift)


def _over(wanted: Int32, mask: Mask, at: Pair, price: int) -> None:
    """Ask for what a mask holds, as far as it lies in `wanted`."""
    y, x = (max(a, 0) for a in at)
    part = mask[y - at[0] : wanted.shape[0] - at[0], x - at[1] : wanted.shape[1] - at[1]]
    here = wanted[y : y + part.shape[0], x : x + part.shape[1]]
    np.maximum(here, part * np.int32(price), out=here)
