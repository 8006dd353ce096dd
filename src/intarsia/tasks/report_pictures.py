"""The pictures of a report: the output, how it repeats, where its joins cost, what it shows too often, its pieces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import files
from ..arrays import Array
from ..geometry import Wrap
from ..image import Plane
from ..judging.places import OFTEN, Often, Spot, damaged_at, joins_at, too_often, usage_of
from ..rendering.mixing import averaged
from .outcome import Outcome
from .overlays import CYAN, YELLOW

Pixels = NDArray[np.uint8]

LARGE, BESIDE = 1024, 768  # px: longest side of the output, and of the pictures beside it
SMALL = 256  # px: outputs up to this size are repeated three times along each closed axis, others twice
GAP = 12  # px between exemplars
PAPER = 128  # under what is transparent, and between exemplars
MAGENTA = (255.0, 90.0, 230.0)
RINGS = (YELLOW, CYAN, MAGENTA)
RING, RIM = 1.6, 3.2  # px: half the width of a ring, and of the dark rim around it
FULL = 2.0  # times the worst mean that joins can have: shown as fully red
MANY = 6.0  # times the mean: shown as brightest
PALE = 0.45  # how much of the picture is left under joins

HEAT = ((0.0, (255, 214, 102)), (0.5, (240, 110, 40)), (1.0, (176, 0, 32)))
USES = (
    (0.0, (18, 20, 44)), (0.2, (66, 38, 104)), (0.36, (158, 60, 104)),
    (0.6, (236, 116, 62)), (0.85, (252, 200, 90)), (1.0, (255, 255, 214)),
)  # fmt: skip
TINTS = np.array([
    (86, 130, 168), (196, 148, 92), (110, 158, 120), (176, 102, 104), (136, 120, 172), (204, 184, 120),
    (92, 152, 160), (160, 136, 118), (120, 108, 96), (190, 140, 172), (148, 170, 98), (92, 100, 132),
], np.uint8)  # fmt: skip


class Drawn(NamedTuple):
    """A picture with its name, and a sentence on what is to be seen."""

    name: str
    title: str
    says: str
    pixels: Pixels


def pictures_of(outcome: Outcome) -> list[Drawn]:
    """Draw all pictures of a report; those of the exemplars come last."""
    size = (outcome.output.height, outcome.output.width)
    often = too_often(outcome.judged, outcome.sizes, size)
    whole, beside = looked(outcome.output, LARGE), looked(outcome.output, BESIDE)
    shown = [looked(e.base, BESIDE) for e in outcome.exemplars]
    what = f"{size[1]} x {size[0]} px" + (", shown smaller" if max(size) > LARGE else "")
    out = [Drawn("output", "The output", what, whole)]
    if outcome.wrap is not Wrap.NONE:
        out.append(_repeated(whole, outcome.wrap, size))
    out += [_joins(outcome, beside, size), _damaged(outcome, beside, size), _too_often(beside, size, often)]
    if outcome.map is not None:
        out.append(_pieces(outcome, size))
    names = ", ".join(f"{e.name}, {e.width} x {e.height} px" for e in outcome.exemplars)
    out.append(Drawn("exemplar", "The exemplar" + "s" * (len(shown) > 1), names, in_a_row(shown)))
    out.append(_usage(outcome, shown))
    if often:
        rings = [
            ringed(p, e.width, [(RINGS[n], [o.place]) for n, o in enumerate(often) if o.number == k])
            for k, (p, e) in enumerate(zip(shown, outcome.exemplars, strict=True))
        ]
        said = "The places that the rings in the output show"
        out.append(Drawn("sources", "What is shown too often", said, in_a_row(rings)))
    return out


def looked(plane: Plane, most: int) -> Pixels:
    """A plane as 8-bit RGB (H, W, 3) of at most so many px a side, averaged in blocks; transparent over gray."""
    seen = files.preview(plane)
    n = -(-max(seen.height, seen.width) // most)
    n = min(n, seen.height, seen.width)
    if n > 1:
        height, width = (side - side % n for side in (seen.height, seen.width))
        seen = seen.like(averaged(seen.like(seen.samples[:height, :width]), n))
    pixels = seen.samples
    if seen.alpha:
        opacity = pixels[:, :, -1:].astype(np.uint32)
        pixels = ((pixels[:, :, :-1] * opacity + PAPER * (255 - opacity) + 127) // 255).astype(np.uint8)
    colours = pixels[:, :, :3] if pixels.shape[2] >= 3 else pixels[:, :, [0, 0, 0]]
    return np.ascontiguousarray(colours[:most, :most])


def in_a_row(pictures: Sequence[Pixels]) -> Pixels:
    """Lay pictures side by side."""
    if len(pictures) == 1:
        return pictures[0]
    high = max(len(p) for p in pictures)
    parts = [np.pad(p, ((0, high - len(p)), (0, GAP), (0, 0)), constant_values=PAPER) for p in pictures]
    return np.concatenate(parts, axis=1)[:, :-GAP]


def _repeated(picture: Pixels, wrap: Wrap, size: tuple[int, int]) -> Drawn:
    times = 3 if max(size) <= SMALL else 2
    down, across = (times if closed else 1 for closed in (wrap.y, wrap.x))
    n = -(-max(picture.shape[0] * down, picture.shape[1] * across) // LARGE)
    if min(picture.shape[:2]) >= n > 1:
        picture = looked(Plane(picture), -(-max(picture.shape[:2]) // n))
    said = "How it continues in itself"
    return Drawn("repeat", f"Repeated {across} x {down}", said, np.tile(picture, (down, across, 1)))


def _joins(outcome: Outcome, picture: Pixels, size: tuple[int, int]) -> Drawn:
    cost, worst = joins_at(outcome.judged, size), outcome.score.parts["joins"]
    over = np.clip(stretched(cost, picture.shape) * 100 / (FULL * worst.bad), 0, 1)[..., None]
    gray = picture.astype(np.float32).mean(axis=2, keepdims=True)
    pale = PALE * gray + (1 - PALE) * 226
    pixels = pale * (1 - over**0.6) + ramp(HEAT, over[..., 0]) * over**0.6
    said = "The redder, the more changes where another piece of the exemplar begins"
    return Drawn("joins", "Where joins cost", said, pixels.astype(np.uint8))


def _damaged(outcome: Outcome, picture: Pixels, size: tuple[int, int]) -> Drawn:
    outlines, share = damaged_at(outcome.judged, size)
    rows, columns = (np.arange(n) * m // n for n, m in zip(picture.shape[:2], outlines.shape, strict=True))
    pixels = (picture * (1 - PALE / 2) + PALE / 2 * 226).astype(np.uint8)
    pixels[outlines[np.ix_(rows, columns)]] = MAGENTA
    said = f"Outlined: {share:.0f} of 100 segments, cut, merged or of two colours, are like none of the exemplar"
    return Drawn("damaged", "Damaged elements", said, pixels)


def stretched(cells: Array, shape: tuple[int, ...]) -> Array:
    """Numbers (rows, columns) as large as a picture, smooth between the middles of what each stands for."""
    for axis in (0, 1):
        length = cells.shape[axis]
        at = np.clip((np.arange(shape[axis]) + 0.5) / shape[axis] * length - 0.5, 0, length - 1)
        low = np.minimum(at.astype(np.int64), max(length - 2, 0))
        share = (at - low).reshape((-1, 1) if axis == 0 else (1, -1))
        cells = np.take(cells, low, axis) * (1 - share) + np.take(cells, np.minimum(low + 1, length - 1), axis) * share
    return cells.astype(np.float32)


def ramp(colours: Sequence[tuple[float, tuple[int, int, int]]], value: Array) -> Array:
    """Give numbers of 0 to 1 the colours between those of a scale: one more axis, RGB as floats."""
    table = np.linspace(0, 1, 256)
    at = [where for where, _ in colours]
    scale = np.stack([np.interp(table, at, [c[k] for _, c in colours]) for k in range(3)], axis=1).astype(np.float32)
    return np.asarray(scale[(value * 255).astype(np.int64)])


def _too_often(picture: Pixels, size: tuple[int, int], often: Sequence[Often]) -> Drawn:
    if not often:
        said = f"No place of the exemplar is shown {OFTEN:g} times as often as the mean"
        return Drawn("often", "Nothing is shown too often", said, picture)
    parts = [f"{len(o.spots)} times the same place, {o.times:.1f} times the mean" for o in often]
    pixels = ringed(picture, size[1], [(RINGS[n], o.spots) for n, o in enumerate(often)])
    return Drawn("often", "Shown too often", "; ".join(parts), pixels)


def ringed(picture: Pixels, width: int, rings: Sequence[tuple[tuple[float, ...], Sequence[Spot]]]) -> Pixels:
    """Draw rings around spots of a picture that is `width` px wide where they are counted."""
    out, scale = picture.copy(), picture.shape[1] / width
    for colour, spots in reversed(rings):
        for spot in spots:
            y, x, radius = spot.y * scale, spot.x * scale, max(spot.radius * scale, 4.0)
            far = radius + RIM + 1
            box = tuple(
                slice(max(0, int(m - far)), max(0, min(n, int(m + far) + 2)))
                for m, n in zip((y, x), out.shape[:2], strict=True)
            )
            rows, columns = (np.arange(s.start, s.stop) + 0.5 for s in box)
            off = np.abs(np.hypot(rows[:, None] - y, columns[None] - x) - radius)[..., None]
            rim, core = 0.75 * np.clip(RIM - off, 0, 1), np.clip(RING + 0.5 - off, 0, 1)
            out[box] = out[box] * (1 - rim) * (1 - core) + np.array(colour) * core
    return out


def _pieces(outcome: Outcome, size: tuple[int, int]) -> Drawn:
    assert outcome.map is not None
    numbers = outcome.map.pieces()
    count = int(numbers.max()) + 1
    mixed = (np.arange(count, dtype=np.uint32) * np.uint32(2654435761)) >> np.uint32(16)
    pixels = TINTS[(mixed % np.uint32(len(TINTS))).astype(np.int64)[numbers]]
    step = -(-max(numbers.shape) // BESIDE)
    pixels, numbers = pixels[::step, ::step], numbers[::step, ::step]
    edge = np.zeros(numbers.shape, bool)
    edge[:-1] |= numbers[:-1] != numbers[1:]
    edge[:, :-1] |= numbers[:, :-1] != numbers[:, 1:]
    pixels[edge] = pixels[edge] * 3 // 5
    said = f"{count} piece{'s' * (count > 1)}, each a part of an exemplar that goes on unbroken"
    return Drawn("pieces", "The pieces", said, np.ascontiguousarray(pixels))


def _usage(outcome: Outcome, shown: Sequence[Pixels]) -> Drawn:
    said, smap = f"Dark is not shown, red as often as the mean, white {MANY:.0f} times as often or more", outcome.map
    n = outcome.times
    if smap is not None and [(s.height * n, s.width * n) for s in smap.sources] == outcome.sizes:
        counts: list[Any] = list(smap.usage())
        free = [None if e.usable is None else e.usable[::n, ::n] for e in outcome.exemplars]
        pixels = sum(c.size if u is None else int(u.sum()) for c, u in zip(counts, free, strict=True))
        mean = sum(int(c.sum()) for c in counts) / max(pixels, 1)
        often = [c / max(mean, 1e-9) for c in counts]
    else:
        often = usage_of(outcome.judged, outcome.sizes)
        said += "; as far as windows tell, without the map"
    parts = []
    for picture, share, e in zip(shown, often, outcome.exemplars, strict=True):
        value = np.log1p(np.minimum(_fitted(share, picture.shape), MANY)) / np.log1p(MANY)
        light = 0.6 + 0.4 * picture.astype(np.float32).mean(axis=2, keepdims=True) / 255
        drawn = (ramp(USES, value) * light).astype(np.uint8)
        if e.usable is not None:
            drawn[~_fitted(e.usable, picture.shape)] = PAPER
        parts.append(drawn)
    return Drawn("usage", "How often it is shown", said, in_a_row(parts))


def _fitted(values: Array, shape: tuple[int, ...]) -> Array:
    """Values of pixels as large as a picture of them: the nearest of each."""
    rows, columns = ((np.arange(n) * m) // n for n, m in zip(shape[:2], values.shape, strict=True))
    return values[np.ix_(rows, columns)]


def thumbnail_of(outcome: Outcome, most: int = 384) -> Pixels:
    """The output, small."""
    return looked(outcome.output, most)
