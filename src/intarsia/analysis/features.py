"""What methods compare: every exemplar as an int16 picture, stretched to the exemplars' own range.

Matching never touches the pixels themselves: 8-bit, 16-bit and float planes of equal content give the same
features, and so the same map (law 13). All steps are integer arithmetic, or single IEEE operations.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

import numpy as np

from ..arrays import Array, Int16, Int32, UInt8
from ..errors import InputError
from ..exemplar import Exemplar, Exemplars
from ..geometry import ISOMETRIES
from ..image import Kind
from .oriented import HALF, Lines, Outlines, from_middle, lines_of, outline_distance, outlines_of
from .stretched import RANGE, at_base_size, counted, labels_of, stretched, times, values_of, variance_of, weighted
from .sums import moving_sums

OTHER_PLANES = 0.5  # variance of every further plane of weight 1, relative to the base plane
MOST_CONTEXT = 4.0  # faint surroundings are not blown up more than this
OUTLINES, SLOW = 0.5, 0.3  # how much outlines count, their spread over that of colour; slow colour is multiplied
SLOW_REACH = 20  # slow colour is averaged over three squares of twice this part of the shorter side

T = TypeVar("T")


@dataclass(frozen=True)
class Features:
    """The exemplars as int16 pictures (H, W, C), comparable with one another.

    ``normals`` names the first of three channels of each normal map, whose vectors turn with the piece;
    ``black`` is what a pixel of value 0 would be, channel by channel; the base plane has the first ``base``, and the
    last ``structure`` help to find what fits, but are not seen; courses, where they count, run along axis ``courses``.
    """

    pictures: tuple[Int16, ...]
    normals: tuple[int, ...] = ()
    black: tuple[int, ...] = ()
    base: int = 0
    structure: int = 0
    courses: int | None = None
    _memo: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    def brightness(self, feats: Int16, known: UInt8) -> int:
        """Sum of a window's squared features where it is known, counted from black."""
        above = (feats[:, :, : self.base].astype(np.int64) - self.black[: self.base]) * known[:, :, None]
        return int((above * above).sum())

    def memo(self, key: Any, make: Callable[[], T]) -> T:
        """Return what is known of these pictures under `key`, making it at the first asking."""
        if key not in self._memo:
            self._memo[key] = make()
        value: T = self._memo[key]
        return value

    @property
    def level(self) -> Int16:
        """The first picture without slopes, which face opposite ways on the two sides of a joint."""
        return np.delete(self.pictures[0], [k + axis for k in self.normals for axis in (0, 1)], axis=2)

    def posed(self, number: int, pose: int) -> Int16:
        """Return picture `number` as it looks when laid down in isometry `pose`."""
        return posed(self.pictures[number], pose, self.normals)


def posed(picture: Array, pose: int, normals: tuple[int, ...] = ()) -> Array:
    """Lay features (H, W, ..., C) down in an isometry; `normals` as in :class:`Features`."""
    picture = pose_array(picture, pose)
    if pose and normals:
        picture = picture.copy()
        (a, b), (c, d) = ISOMETRIES[pose].j
        for k in normals:  # rows point down, the green channel up; the turned gradient is J^T n
            x, y = picture[..., k].copy(), picture[..., k + 1].copy()
            picture[..., k] = d * x - b * y
            picture[..., k + 1] = a * y - c * x
    return np.ascontiguousarray(picture)


def pose_array(array: Array, pose: int) -> Array:
    """Lay an array (H, W, ...) down in one of the eight isometries (Multrus 2003, 4.1.1)."""
    swapped = np.swapaxes(array, 0, 1)
    return {
        0: array,
        1: array[:, ::-1],
        2: array[::-1],
        3: swapped,
        4: swapped[::-1, ::-1],
        5: swapped[::-1],
        6: array[::-1, ::-1],
        7: swapped[:, ::-1],
    }[pose]


def features(
    exemplars: Exemplars, weights: tuple[float, ...] | None = None, context: tuple[float, int] = (0.0, 0),
    structure: float = 0.0, courses: float = 0.0,
) -> Features:  # fmt: skip
    """Return the features of the exemplars; `weights` count the channels of the base plane, their own the planes.

    `context` (weight, radius px) appends the same channels averaged over their surroundings: what an exemplar
    pixel has around it is then known even where the output around it is not. Weight 1 gives them the variance
    of the others. `structure` appends how far each pixel lies from outlines, and the colours of the base plane averaged
    over a tenth of the exemplar: 1 gives outlines half of the spread of colour, and multiplies slow colours by 0.3.
    `courses` appends, where lines run across all exemplars, how far each pixel lies from the middle of its course: 1
    gives it the spread of colour.

    Raises
    ------
    InputError
        where the exemplars differ in their planes or channels.
    ParameterError
        where the number of weights is not the number of channels.
    """
    key = ("features", weights, context, structure, courses, tuple(e.digest for e in exemplars))
    return exemplars[0].memo(key, lambda: _made(exemplars, weights, context, structure, courses))


def _made(
    exemplars: Exemplars, weights: tuple[float, ...] | None, context: tuple[float, int], structure: float,
    courses: float,
) -> Features:  # fmt: skip
    if courses:
        lines = course_lines(features(exemplars, weights), exemplars)
        before = features(exemplars, weights, context, structure)
        return _with_courses(before, exemplars, lines, courses) if lines else before
    plain = features(exemplars, weights) if structure or context[0] else _features(exemplars, weights)
    around = _with_context(plain, exemplars, *context)
    return _with_structure(around, plain, exemplars, structure) if structure else around


def outlines(plain: Features, exemplars: Exemplars) -> list[Outlines]:
    """Return the outlines in the base planes of exemplars, looked for once."""
    return plain.memo("outlines", lambda: [
        outlines_of(p[..., : plain.base], e.usable, e.toroidal) for p, e in zip(plain.pictures, exemplars, strict=True)
    ])  # fmt: skip


def course_lines(plain: Features, exemplars: Exemplars) -> list[Lines]:
    """Return the lines between the courses of exemplars, of all along the same axis; empty where one has none."""

    def looked() -> list[Lines]:
        found: list[Lines] = []
        for outlined, picture, e in zip(outlines(plain, exemplars), plain.pictures, exemplars, strict=True):
            lines = lines_of(outlined, picture.shape, e.toroidal)
            if lines is None or (found and lines.axis != found[0].axis):
                return []
            found.append(lines)
        return found

    return plain.memo("courses", looked)


def _with_courses(feats: Features, exemplars: Exemplars, lines: list[Lines], weight: float) -> Features:
    """Append the channel of courses to features."""
    each = zip(lines, feats.pictures, exemplars, strict=True)
    far = [from_middle(one, p.shape, e.toroidal)[..., None] for one, p, e in each]
    own = variance_of([p[..., : feats.base].astype(np.int32) for p in feats.pictures], exemplars)
    share = min(weight * math.sqrt(own / max(variance_of(far, exemplars), 1.0)), 2 * RANGE / HALF)
    pictures = [np.concatenate([p, times(f, share).astype(np.int16)], axis=2)
                for p, f in zip(feats.pictures, far, strict=True)]  # fmt: skip
    black, axis = (*feats.black, 0), lines[0].axis
    return Features(tuple(pictures), feats.normals, black, feats.base, feats.structure + 1, axis)


def _with_structure(feats: Features, plain: Features, exemplars: Exemplars, weight: float) -> Features:
    """Append the channels of structure that the base plane has to features."""
    base = [p[..., : plain.base] for p in plain.pictures]
    known = zip(outlines(plain, exemplars), base, exemplars, strict=True)
    far = [outline_distance(found, p.shape, e.toroidal)[..., None] for found, p, e in known]
    own = variance_of([b.astype(np.int32) for b in base], exemplars)
    share = min(weight * OUTLINES * math.sqrt(own / max(variance_of(far, exemplars), 1.0)), RANGE / 8)
    channels = feats.pictures[0].shape[2]
    pictures = []
    for picture, distance, colour, e in zip(feats.pictures, far, base, exemplars, strict=True):
        slow = times(_blurred(colour, e, max(1, min(picture.shape[:2]) // SLOW_REACH)), weight * SLOW)
        added = np.concatenate([times(distance, share), slow], axis=2)
        pictures.append(np.concatenate([picture, np.clip(added, -2 * RANGE, 2 * RANGE).astype(np.int16)], axis=2))
    normals = tuple(k + channels + 1 for k in plain.normals if k < plain.base)
    black = (*feats.black, *[0] * (plain.base + 1))
    return Features(tuple(pictures), (*feats.normals, *normals), black, feats.base, plain.base + 1)


def _with_context(plain: Features, exemplars: Exemplars, weight: float, radius: int) -> Features:
    if not weight:
        return plain
    blurred = [_blurred(p, e, radius) for p, e in zip(plain.pictures, exemplars, strict=True)]
    own = contrast(plain, exemplars)
    share = min(math.sqrt(weight * own / max(variance_of(blurred, exemplars), 1.0)), MOST_CONTEXT)
    pictures = [
        np.concatenate([p, np.clip(times(b, share), -2 * RANGE, 2 * RANGE).astype(np.int16)], axis=2)
        for p, b in zip(plain.pictures, blurred, strict=True)
    ]
    channels = plain.pictures[0].shape[2]
    normals = plain.normals + tuple(k + channels for k in plain.normals)
    return Features(tuple(pictures), normals, plain.black * 2, plain.base)


def _blurred(picture: Int16, exemplar: Exemplar, radius: int) -> Int32:
    """Average three times over squares of 2 radius + 1 px, in whole numbers, around the exemplar's mean."""
    mean = picture.reshape(-1, picture.shape[2]).astype(np.int64).sum(axis=0) // (picture.shape[0] * picture.shape[1])
    out = picture.astype(np.int64) - mean
    mode: Literal["wrap", "symmetric"] = "wrap" if exemplar.toroidal else "symmetric"
    for axis in (0, 1) * 3:
        r = min(radius, out.shape[axis])
        out = moving_sums(out, axis, r, mode) // (2 * r + 1)
    return np.asarray(out, np.int32)


def _features(exemplars: Exemplars, weights: tuple[float, ...] | None) -> Features:
    layout = _layout(exemplars[0])
    for e in exemplars[1:]:
        if _layout(e) != layout:
            raise InputError(
                f"{e.name} and {exemplars[0].name} differ in planes, channels, kind or weights; give exemplars of one "
                "make-up."
            )
    stacks: list[list[Int32]] = [[] for _ in exemplars]
    normals: list[int] = []
    base_variance, channels, base = 0.0, 0, 0
    weights_of = {name: math.sqrt(exemplars[0].weight(name)) for name in layout}
    most = max(1.0, *weights_of.values())  # so that no plane exceeds the range
    black: list[int] = []
    for number, name in enumerate(layout):
        labels = labels_of([e.planes[name] for e in exemplars])
        codes, nothing = counted([e.planes[name] for e in exemplars], [e.usable for e in exemplars])
        values = [
            at_base_size(values_of(c, e.planes[name], labels), e) for c, e in zip(codes, exemplars, strict=True)
        ]
        scaled, zero, signed = stretched(values, exemplars, exemplars[0].planes[name], nothing)
        if number == 0:
            *scaled, last = weighted([*scaled, zero], exemplars[0].base, weights)
            base_variance = variance_of(scaled, exemplars)
            if (own := weights_of[name] / most) != 1:
                *scaled, last = (times(s, own) for s in (*scaled, last))
            black, base = last.ravel().tolist(), last.size
        else:
            black += [0] * scaled[0].shape[2]
            share = math.sqrt(min(1.0, OTHER_PLANES * base_variance / max(variance_of(scaled, exemplars), 1.0)))
            scaled = [times(s, share * weights_of[name] / most) for s in scaled]
        if signed:
            normals.append(channels)
        channels += scaled[0].shape[2]
        for stack, s in zip(stacks, scaled, strict=True):
            stack.append(s)
    pictures = []
    for e, stack in zip(exemplars, stacks, strict=True):
        picture = np.concatenate(stack, axis=2).astype(np.int16)
        if e.usable is not None and e.usable.any():  # one wholly unusable lies under a start map: it is matched
            picture[~e.usable] = 0
        pictures.append(picture)
    return Features(tuple(pictures), tuple(normals), tuple(black), base)


def _layout(exemplar: Exemplar) -> dict[str, tuple[Kind, int, float]]:
    planes = exemplar.planes
    return {n: (planes[n].kind, planes[n].channels, exemplar.weight(n)) for n in exemplar.compared}


def contrast(feats: Features, exemplars: Exemplars) -> float:
    """Return how much the exemplars differ from their mean: the sum of the variances of all channels."""
    return variance_of([p.astype(np.int32) for p in feats.pictures], exemplars)
