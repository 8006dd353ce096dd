"""Feature vectors for matching: every exemplar as an int16 picture, normalised to the range of all exemplars.

Matching does not use pixel values themselves: 8-bit, 16-bit and float planes of equal content give the same features
and the same map. All steps are integer arithmetic, or single IEEE operations, so equal on every machine.

Float planes are counted in a unit that is common to all exemplars, and outliers are clipped: heights may be in metres,
millimetres or shares of 1, and mark holes by -1e30, without loss of contrast elsewhere. No 8-bit picture is clipped.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np

from ..foundation import InputError, ParameterError, lazy
from ..foundation.arrays import Array, Int16, Int32, Mask, Pair, UInt8
from ..foundation.filters import moving_sums
from ..foundation.geometry import ISOMETRIES
from ..model import Exemplar, Exemplars, resized
from ..model.image import Kind, Plane
from ..rendering import WHITE, Unit, code_shares, code_values, enlarged, has_own_unit, inner_range
from . import block_sums, scaled_variances

if TYPE_CHECKING:
    from . import oriented_energy
    from .oriented_energy import CourseLines, Outlines
else:  # imported where outlines and courses are used
    oriented_energy = lazy("intarsia.analysis.oriented_energy")

MOST_SPREAD = 256  # largest ratio of the full range to the inner range, of 998 of 1000 values, without clipping


def as_integers(planes: Sequence[Plane], usable: Sequence[Mask | None]) -> tuple[list[Int32], int]:
    """Return planes of one name as comparable whole numbers (H, W, C), and the whole number of the value 0.

    Floats are counted in units of their own size, taken from their usable pixels (masks are those of the base, and
    may be a multiple or fraction of a plane's size). If they hold nothing but whole codes of 16 bits within 0 to 1,
    those are returned, as for integers.
    """
    unit = WHITE
    if any(map(has_own_unit, planes)):
        masks = [... if m is None else resized(m, (p.height, p.width)) for m, p in zip(usable, planes, strict=True)]
        colours = planes[0].channels - planes[0].alpha
        each = [code_shares(p.samples[..., :colours])[m].ravel() for p, m in zip(planes, masks, strict=True)]
        seen = np.concatenate(each)
        if seen.size:
            unit = Unit.of(seen)
        finer = unit.bits - unit.exponent
        if not unit.origin and 0 <= finer - unit.bits <= 16 and (unit.count(seen) == WHITE.count(seen) << finer).all():
            unit = WHITE
    return [code_values(p, unit) for p in planes], int(unit.count(np.zeros(1))[0])


def robust_range(values: Sequence[Array]) -> Pair:
    """Return least and greatest of whole numbers, clipped if there are far outliers.

    The inner range leaves out one of a thousand values at either end. If the full range is more than MOST_SPREAD times
    as large, the inner range is returned, extended by its own length on both sides.
    """
    low, high = _extremes(values)
    if high - low <= MOST_SPREAD:
        return low, high
    least, most = map(int, inner_range(np.concatenate([v.ravel() for v in values])))
    within = most - least
    if 0 < within * MOST_SPREAD < high - low:
        return max(low, least - within), min(high, most + within)
    return low, high


def _extremes(values: Sequence[Array]) -> Pair:
    return min(int(v.min()) for v in values), max(int(v.max()) for v in values)


RANGE = 1023  # largest feature of the base plane: 10 bits
LUMINANCE = (0.30, 0.59, 0.11)  # weights of red, green and blue (Robinson 2004)
MAX_LABELS = 16  # labels of a plane that get a channel each; more are compared as numbers
FARTHEST = 256 * RANGE  # largest absolute feature of the value 0, so that sums of its squares stay exact


def labels_of(planes: list[Plane]) -> Int32 | None:
    """Return the labels that occur in planes; None for other kinds, or if there are more than MAX_LABELS."""
    if planes[0].kind is not Kind.LABEL or planes[0].channels > 1:
        return None
    names = np.unique(np.concatenate([np.unique(code_values(p)) for p in planes]))
    return names if len(names) <= MAX_LABELS else None


def values_of(codes: Int32, plane: Plane, labels: Int32 | None = None) -> Int32:
    """Return code values of a plane: colours premultiplied by opacity, `labels` as one channel each."""
    if labels is not None:
        return np.asarray(codes == labels, dtype=np.int32) * 65535
    if plane.alpha:
        alpha = codes[:, :, -1:].astype(np.int64)
        premultiplied = codes[:, :, :-1] * alpha // 65535
        return np.concatenate([premultiplied, alpha], axis=2).astype(np.int32)
    return codes


def at_base_size(values: Int32, exemplar: Exemplar) -> Int32:
    """Return values of a plane at the size of the base plane: averaged over blocks, or enlarged."""
    s = values.shape[0] // exemplar.height
    if s > 1:
        return np.asarray(block_sums(values, s) // (s * s), np.int32)
    return enlarged(values, exemplar.height // values.shape[0])


def normalised(
    values: list[Int32], exemplars: Exemplars, plane: Plane, zero: int
) -> tuple[list[Int32], Int32, bool]:
    """Return pictures normalised to 0 .. RANGE over all exemplars; normal maps to -RANGE/2 .. RANGE/2 around flat.

    Also returns what becomes of a pixel of value 0, whose code is `zero`, (1, 1, C), and True for a normal map.
    """
    black = np.zeros((1, 1, values[0].shape[2]), np.int32)
    usable = [v for v in _usable(values, exemplars) if v.size]
    if plane.kind is Kind.NORMAL:
        signed = _extremes(usable)[0] < 0
        middle = 0 if signed else 65535  # twice the value of a zero component
        twice = [2 * v.astype(np.int64) - middle for v in values]
        if plane.meta.get("normals") == "dx":  # as if green pointed up, which `posed` assumes
            for v in twice:
                v[..., 1] *= -1
        span = 131070 if signed else 65535
        return [np.asarray(v * RANGE // (2 * span), np.int32) for v in twice], black, True
    low, high = _extremes(usable) if plane.kind is Kind.LABEL else robust_range(usable)
    span = max(high - low, 1)
    shifted = [np.clip(v, low, high).astype(np.int64) - low for v in values]
    if plane.kind is not Kind.LABEL:
        black += min(max(((zero - low) * 2 * RANGE + span) // (2 * span), -FARTHEST), FARTHEST)
    return [np.asarray((v * (2 * RANGE) + span) // (2 * span), np.int32) for v in shifted], black, False


def weighted(values: list[Int32], plane: Plane, weights: tuple[float, ...] | None) -> list[Int32]:
    if plane.kind is Kind.LABEL:
        return values
    factors = [math.sqrt(share) for share in channel_shares(plane, weights, values[0].shape[2])]
    return [np.stack([multiplied(v[:, :, c], f) for c, f in enumerate(factors)], axis=2) for v in values]


def channel_shares(plane: Plane, weights: tuple[float, ...] | None, count: int) -> list[float]:
    """Return the weights of `count` channels of a base plane, relative to the largest.

    A single weight is that of all colours. Raise ParameterError for another number of weights."""
    colours = plane.channels - plane.alpha
    if weights is None:
        weights = LUMINANCE if colours == 3 and plane.kind is Kind.COLOUR else (1.0,) * colours
    if len(weights) == 1:
        weights *= colours
    if len(weights) not in (colours, count):
        raise ParameterError(f"channel_weights: {len(weights)} numbers for {count} channels; give {colours} of them.")
    weights = (*weights, max(weights))[:count]
    return [w / max(weights) for w in weights]


def multiplied(values: Int32, factor: float) -> Int32:
    scale = round(factor * 65536)
    return np.asarray((values.astype(np.int64) * scale + 32768) >> 16, dtype=np.int32)


def _usable(values: Sequence[Array], exemplars: Exemplars) -> list[Array]:
    """Return the usable pixels of each picture, (n, C), without a copy if all are usable."""
    both = zip(values, exemplars, strict=True)
    return [v.reshape(-1, v.shape[2]) if e.usable is None else v[e.usable] for v, e in both]


def variance_of(values: Sequence[Array], exemplars: Exemplars) -> float:
    """Return the sum of the channels' variances; from integer sums, so equal on every machine."""
    flat = np.concatenate(_usable(values, exemplars))
    return float(sum(scaled_variances(flat))) / len(flat) ** 2


OTHER_PLANES = 0.5  # variance of every further plane of weight 1, relative to the base plane
OUTLINES, SLOW = 0.5, 0.3  # at weight 1: deviation of outlines over that of colour; factor of slow colour
SLOW_REACH = 20  # slow colour is averaged three times over squares of radius 1/20 of the shorter side

T = TypeVar("T")


@dataclass(frozen=True)
class Features:
    """Features of exemplars: int16 pictures (H, W, C), comparable with one another.

    ``normals``: the first of three channels of each normal map, whose vectors turn with the piece;
    ``black``: the features of a pixel of value 0; ``base``: number of channels of the base plane, which come first;
    ``structure``: number of channels at the end that are used in the search, and not in costs of seams.
    """

    pictures: tuple[Int16, ...]
    normals: tuple[int, ...] = ()
    black: tuple[int, ...] = ()
    base: int = 0
    structure: int = 0
    _memo: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    def brightness(self, feats: Int16, known: UInt8) -> int:
        """Return the sum of a window's squared differences from black over known pixels, in the base channels."""
        above = (feats[:, :, : self.base].astype(np.int64) - self.black[: self.base]) * known[:, :, None]
        return int((above * above).sum())

    def memo(self, key: Any, make: Callable[[], T]) -> T:
        """Return the value cached for these pictures under `key`, which `make` computes at first use."""
        if key not in self._memo:
            self._memo[key] = make()
        value: T = self._memo[key]
        return value

    @property
    def level(self) -> Int16:
        """The first picture without the x and y of normals, which differ in sign on the two sides of a joint."""
        return np.delete(self.pictures[0], [k + axis for k in self.normals for axis in (0, 1)], axis=2)

    def posed(self, number: int, pose: int) -> Int16:
        """Return picture `number` in isometry `pose`."""
        return in_isometry(self.pictures[number], pose, self.normals)


def in_isometry(picture: Array, pose: int, normals: tuple[int, ...] = ()) -> Array:
    """Return features (H, W, ..., C) transformed by isometry `pose`; `normals` as in :class:`Features`."""
    picture = transformed(picture, pose)
    if pose and normals:
        picture = picture.copy()
        (a, b), (c, d) = ISOMETRIES[pose].j
        for k in normals:  # rows point down, the green channel up; the turned gradient is J^T n
            x, y = picture[..., k].copy(), picture[..., k + 1].copy()
            picture[..., k] = d * x - b * y
            picture[..., k + 1] = a * y - c * x
    return np.ascontiguousarray(picture)


def transformed(array: Array, pose: int) -> Array:
    """Return a view of an array (H, W, ...) in isometry `pose`, 0 to 7 (Multrus 2003, 4.1.1)."""
    (a, b), (c, d) = ISOMETRIES[pose].j
    return (np.swapaxes(array, 0, 1) if b else array)[:: a + c, :: b + d]


def features(
    exemplars: Exemplars, weights: tuple[float, ...] | None = None, structure: float = 0.0
) -> Features:
    """Return the features of the exemplars, cached.

    `weights` are those of the channels of the base plane (:func:`channel_shares`); weights of planes are properties of
    the exemplars. A positive `structure` appends, for the search only, the distance of each pixel to outlines, and the
    colours of the base plane averaged over about a tenth of the exemplar ("slow colour"): 1 gives the distance half
    the standard deviation of colour, and multiplies slow colours by 0.3.

    Raises
    ------
    InputError
        where the exemplars differ in their planes or channels.
    ParameterError
        where the number of weights is not the number of channels.
    """
    key = ("features", weights, structure, tuple(e.digest for e in exemplars))
    return exemplars[0].memo(key, lambda: (
        _with_structure(features(exemplars, weights), exemplars, structure) if structure
        else _features(exemplars, weights)
    ))  # fmt: skip


def outlines(plain: Features, exemplars: Exemplars) -> list[Outlines]:
    """Return the outlines in the base planes of exemplars, cached."""
    return plain.memo("outlines", lambda: [
        oriented_energy.outlines_of(p[..., : plain.base], e.usable, e.toroidal)
        for p, e in zip(plain.pictures, exemplars, strict=True)
    ])  # fmt: skip


def course_lines(plain: Features, exemplar: Exemplar) -> CourseLines | None:
    """Return the lines between the courses of the single exemplar that features are of; None if it has none."""
    return plain.memo("courses", lambda: oriented_energy.course_lines_of(
        outlines(plain, [exemplar])[0], plain.pictures[0].shape
    ))  # fmt: skip


def _with_structure(plain: Features, exemplars: Exemplars, weight: float) -> Features:
    """Return features with the structure channels of the base plane appended."""
    base = [p[..., : plain.base] for p in plain.pictures]
    known = zip(outlines(plain, exemplars), base, exemplars, strict=True)
    far = [oriented_energy.outline_distance(found, p.shape, e.toroidal)[..., None] for found, p, e in known]
    share = min(
        weight * OUTLINES * math.sqrt(variance_of(base, exemplars) / max(variance_of(far, exemplars), 1.0)), RANGE / 8
    )
    more = []
    for distance, colour, e in zip(far, base, exemplars, strict=True):
        slow = multiplied(_blurred(colour, e, max(1, min(colour.shape[:2]) // SLOW_REACH)), weight * SLOW)
        more.append(np.concatenate([multiplied(distance, share), slow], axis=2))
    pictures = tuple(
        np.concatenate([p, np.clip(m, -2 * RANGE, 2 * RANGE).astype(np.int16)], axis=2)
        for p, m in zip(plain.pictures, more, strict=True)
    )
    slopes = tuple(k + 1 + plain.pictures[0].shape[2] for k in plain.normals if k < plain.base)
    black = plain.black + (0,) * (plain.base + 1)
    return replace(
        plain, pictures=pictures, normals=plain.normals + slopes, black=black, structure=plain.base + 1, _memo={}
    )


def _blurred(picture: Int16, exemplar: Exemplar, radius: int) -> Int32:
    """Return a picture less its mean, averaged three times over squares of 2 radius + 1 px, in whole numbers."""
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
    weights_of = {name: math.sqrt(exemplars[0].weight(name)) for name in layout}
    most = max(1.0, *weights_of.values())  # weights are relative to the largest, so that no plane exceeds the range
    stacks: list[list[Int32]] = []  # planes, of every exemplar
    normals, black = list[int](), list[int]()
    base_variance, channels, base = 0.0, 0, 0
    for name, own in weights_of.items():
        planes = [e.planes[name] for e in exemplars]
        labels = labels_of(planes)
        codes, nothing = as_integers(planes, [e.usable for e in exemplars])
        values = [at_base_size(values_of(c, p, labels), e) for c, p, e in zip(codes, planes, exemplars, strict=True)]
        scaled, zero, signed = normalised(values, exemplars, planes[0], nothing)
        if not stacks:
            *scaled, last = weighted([*scaled, zero], planes[0], weights)
            base_variance = variance_of(scaled, exemplars)
            if own != most:
                *scaled, last = (multiplied(s, own / most) for s in (*scaled, last))
            black, base = last.ravel().tolist(), last.size
        else:
            black += [0] * scaled[0].shape[2]
            share = math.sqrt(min(1.0, OTHER_PLANES * base_variance / max(variance_of(scaled, exemplars), 1.0)))
            scaled = [multiplied(s, share * own / most) for s in scaled]
        if signed:
            normals.append(channels)
        channels += scaled[0].shape[2]
        stacks.append(scaled)
    pictures = []
    for e, *stack in zip(exemplars, *stacks, strict=True):
        picture = np.concatenate(stack, axis=2).astype(np.int16)
        if e.usable is not None and e.usable.any():  # if none is usable, a start map is matched
            picture[~e.usable] = 0
        pictures.append(picture)
    return Features(tuple(pictures), tuple(normals), tuple(black), base)


def _layout(exemplar: Exemplar) -> dict[str, tuple[Kind, int, float]]:
    planes = exemplar.planes
    return {n: (planes[n].kind, planes[n].channels, exemplar.weight(n)) for n in exemplar.compared}


def contrast(feats: Features, exemplars: Exemplars) -> float:
    """Return the sum of the variances of all channels of features."""
    return variance_of(feats.pictures, exemplars)
