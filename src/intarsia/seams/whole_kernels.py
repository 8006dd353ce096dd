"""Which elements a map shows, where pieces of them meet, and what a cut does to them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Int64, Pair
from ..kernels.cuts import join
from ..kernels.jit import kernel
from ..kernels.pieces_of_maps import number_sets
from ..kernels.windows import canvas_place
from .energy_kernels import JOINT, source_at, spot

NEAR = 3  # px by which an element may be moved within itself before its halves count as strangers
DEEP = 12  # of 64: where two pieces meet so deep inside, no joint parts them
SLIVER = 2.0  # what is left of an element counts so much more than what is missing of it


class Shown(NamedTuple):
    """The pieces of elements that a map shows, from 1, with room for more."""

    element: Int64  # (n,)
    shift: Int64  # (n, 2): row and column of the canvas less those of the variant
    area: Int64  # (n,): px that are shown
    whole: Int64  # (n,): px that the canvas could show
    body: Int64  # (n,): the first of the pieces that meet inside


class Counts(NamedTuple):
    """Room to count in, all 0, and left so."""

    lost: Int64  # (pieces,)
    got: Int64  # (elements,)
    on: Int64  # (elements,): the piece beside a cut that goes on in it
    ids: Int64  # (pieces,)
    names: Int64  # (elements,)


@kernel
def number_pieces(grown: Any, pieces: Any, labels: Any, joined: Any, meets: Any) -> Pair:
    """Number the pieces of elements that a map shows: `joined` (H, W), 0 outside elements.

    `labels` (pixels of the variants,): elements. `meets` (m, 2): two pieces for each pair of pixels where they meet
    deep inside. Returns how many pieces, and how many such pairs.
    """
    variant, yx, wrap = grown
    inside, (h, w) = pieces.inside, variant.shape
    parent = joined.reshape(h * w)  # of each pixel one before it in its piece, until all are numbered
    for y in range(h):
        for x in range(w):
            here = source_at(grown, pieces, y, x)
            parent[y * w + x] = y * w + x if here >= 0 and labels[here] > 0 else h * w
    for y in range(h):
        for x in range(w):
            here = source_at(grown, pieces, y, x)
            for k in range(2):
                b, a = canvas_place(y + k, h, wrap[0]), canvas_place(x + 1 - k, w, wrap[1])
                if parent[y * w + x] == h * w or b < 0 or a < 0 or variant[b, a] != variant[y, x]:
                    continue
                there = source_at(grown, pieces, b, a)
                down, right = yx[b, a, 0] - yx[y, x, 0] - k, yx[b, a, 1] - yx[y, x, 1] - 1 + k
                if labels[there] == labels[here] and abs(down) <= NEAR and abs(right) <= NEAR:
                    join(parent, y * w + x, b * w + a)
    count, n = number_sets(parent), 0
    for y in range(h):
        for x in range(w):
            for k in range(2):
                b, a = canvas_place(y + k, h, wrap[0]), canvas_place(x + 1 - k, w, wrap[1])
                if joined[y, x] == 0 or b < 0 or a < 0 or joined[b, a] == 0 or joined[b, a] == joined[y, x]:
                    continue
                one = inside[source_at(grown, pieces, y, x)]
                two = inside[source_at(grown, pieces, b, a)]
                if DEEP <= one < JOINT and DEEP <= two < JOINT and n < len(meets):
                    meets[n, 0], meets[n, 1] = joined[y, x], joined[b, a]
                    n += 1
    return count, n


@kernel
def fits(joined: Any, wrap: Any, shown: Any, which: Any, masks: Any, out: Any) -> int:
    """Lay every element over a body, as it covers the body best and the others least.

    `which`: the body, its px, and its middle. `masks`: those of elements (flat), and boxes (n, 7): where the mask of an
    element begins, its rows, columns, px, the row and column of its middle, its number. Written are `out` (n, 4): what
    is missed and clipped, the element, first row and column on the canvas; returns how many. Elements of less than
    half, or more than 2.2 times the size are left out.
    """
    h, w = joined.shape
    (body, size, middle), (flat, boxes) = which, masks
    reach = max(3, int(np.sqrt(float(size))) // 4)
    n = 0
    for e in range(len(boxes)):
        begin, rows, columns, area, cy, cx, number = boxes[e]
        if 2 * area < size or 10 * area > 22 * size:
            continue
        best, by, bx = 1 << 60, 0, 0
        for dy in range(-reach, reach + 1, max(2, reach // 2)):
            for dx in range(-reach, reach + 1, max(2, reach // 2)):
                top, left = middle[0] - cy + dy, middle[1] - cx + dx
                cover, clip = 0, 0
                for i in range(0, rows, 2):
                    y = canvas_place(top + i, h, wrap[0])
                    for j in range(0, columns, 2):
                        x = canvas_place(left + j, w, wrap[1])
                        if y >= 0 and x >= 0 and flat[begin + i * columns + j]:
                            piece = joined[y, x]
                            if piece > 0 and shown.body[piece] == body:
                                cover += 1
                            elif piece > 0:
                                clip += 1
                score = 2 * (size // 4 - cover) + clip
                if score < best:
                    best, by, bx = score, top, left
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = best, number, by, bx
        n += 1
    return n


@kernel
def _damage(area: int, whole: int, sure: float) -> float:
    """How much it hurts to see so many px of an element: nothing if it is whole, or not there."""
    part = min(SLIVER * area, float(whole - area))
    damage: float = sure * max(part, 0.0) / np.sqrt(float(max(whole, 1)))
    return damage


@kernel
def _goes_on(size: Pair, shown: Any, piece: int, element: int, down: int, right: int) -> bool:
    """Whether a piece shows an element about where it would be shown, once round the canvas or not."""
    near = (shown.shift[piece, 0] - down + NEAR) % size[0] <= 2 * NEAR
    near = near and (shown.shift[piece, 1] - right + NEAR) % size[1] <= 2 * NEAR
    same: bool = shown.element[piece] == element and near
    return same


@kernel
def hurt(joined: Any, pieces: Any, labels: Any, known: Any, shown: Any, cut: Any, take: Any, counts: Any) -> float:
    """Return by how much the damage of elements grows if the px of `take` (rows, columns) are cut in; negative: falls.

    `cut`: first row and column of the window, variant, row and column shown there, and of how many px each one counts.
    `known`: (px, sureness) of the elements.
    """
    (y0, x0, v, r0, c0, step), (whole, sure) = cut, known
    h, w = joined.shape
    unit, n, m = step * step, 0, 0
    lost, got, on, ids, names = counts
    for i in range(take.shape[0]):
        for j in range(take.shape[1]):
            piece = joined[(y0 + i * step) % h, (x0 + j * step) % w]
            at = spot(pieces, v, r0 + i * step, c0 + j * step)
            element = labels[at] if at >= 0 else 0
            if take[i, j]:
                if piece > 0:
                    if lost[piece] == 0:
                        ids[n] = piece
                        n += 1
                    lost[piece] += unit
                if element > 0:
                    if got[element] == 0:
                        names[m] = element
                        m += 1
                    got[element] += unit
            elif piece > 0 and element > 0 and _goes_on((h, w), shown, piece, element, y0 - r0, x0 - c0):
                on[element] = piece
    total = 0.0
    for k in range(n):
        p = ids[k]
        e = shown.element[p]
        more = got[e] if on[e] == p else 0
        total += _damage(shown.area[p] - lost[p] + more, shown.whole[p], sure[e])
        total -= _damage(shown.area[p], shown.whole[p], sure[e])
    for k in range(m):
        e = names[k]
        p = on[e]
        if p == 0:
            total += _damage(got[e], whole[e], sure[e])
        elif lost[p] == 0:
            total += _damage(shown.area[p] + got[e], shown.whole[p], sure[e])
            total -= _damage(shown.area[p], shown.whole[p], sure[e])
    for k in range(n):
        on[shown.element[ids[k]]] = 0
        lost[ids[k]] = 0
    for k in range(m):
        got[names[k]] = on[names[k]] = 0
    on[:] = 0
    return total


@kernel
def renew(joined: Any, pieces: Any, labels: Any, known: Any, shown: Any, cut: Any, take: Any, count: int) -> int:
    """Number the pieces again after a cut was pasted: `shown` has `count` of them; returns how many it has now."""
    (y0, x0, v, r0, c0, _), whole = cut, known[0]
    h, w = joined.shape
    on = np.zeros(len(whole), np.int64)
    for i in range(take.shape[0]):
        for j in range(take.shape[1]):
            piece = joined[(y0 + i) % h, (x0 + j) % w]
            if piece == 0:
                continue
            if take[i, j]:
                shown.area[piece] -= 1
            else:
                element = shown.element[piece]
                if _goes_on((h, w), shown, piece, element, y0 - r0, x0 - c0):
                    on[element] = piece
    for i in range(take.shape[0]):
        for j in range(take.shape[1]):
            if not take[i, j]:
                continue
            element = labels[spot(pieces, v, r0 + i, c0 + j)]
            if element > 0 and on[element] == 0:
                on[element] = count
                shown.element[count], shown.whole[count], shown.area[count] = element, whole[element], 0
                shown.shift[count, 0], shown.shift[count, 1], shown.body[count] = y0 - r0, x0 - c0, count
                count += 1
            piece = on[element] if element > 0 else 0
            joined[(y0 + i) % h, (x0 + j) % w] = piece
            if piece > 0:
                shown.area[piece] += 1
    return count
