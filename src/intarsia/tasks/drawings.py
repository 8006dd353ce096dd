"""Visualisations: overlays of lattices and segments on exemplars, contact sheets, and the pictures of a report."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from .. import files
from ..analysis.features import features
from ..foundation import ndimage
from ..foundation.arrays import Array, Mask, Pair, UInt8
from ..foundation.geometry import UNIT, Wrap
from ..judging import OFTEN, Circle, Overused, local_join_costs, overused_places, usage_of
from ..lattice.decision import Lattice
from ..model import Exemplar
from ..model.image import Plane
from ..regular.block_grid import phase_of
from ..rendering.blending import averaged
from ..segments import Segments, segments
from .scoring import Outcome

Pixels = UInt8


def colours(words: str) -> Pixels:
    """Return colours given as hexadecimal numbers, such as "ffe100 00e1ff", as (n, 3)."""
    return np.frombuffer(bytes.fromhex(words), np.uint8).reshape(-1, 3)


PAPER = 128  # gray value, of 255, under transparent pixels and between exemplars
YELLOW, CYAN, MAGENTA, WHITE = colours("ffe100 00e1ff ff5ae6 ffffff")

CORE, EDGE, POINT = 0.6, 1.7, 2.2  # px: half the width of a lattice line, of its dark outline; radius of a point
SHADE = 0.6  # opacity of the outline of a line

GROUPS = colours("56b4e9 009e73 cc79a7 0072b2 e69f00 785ef0 808080")
CHOSEN, LINE, FAINT_LINE = colours("d55e00 ffff5a 141414")
GROUND = 40  # gray value, of 255, of unusable pixels

THUMBNAIL, GAP, SHEET = 256, 8, 64  # contact sheet: side of its pictures and gap between them, px; its gray value

LARGE, BESIDE = 1024, 768  # px: longest side of the output in a report, and of its other pictures
SMALL = 256  # px: outputs up to this size are repeated three times along each closed axis, others twice
APART = 12  # px between exemplars
RINGS = YELLOW, CYAN, MAGENTA
RING, RIM = 1.6, 3.2  # px: half the width of a ring, and of its dark outline
FULL = 2.0  # cost of joins that is drawn fully red, relative to the bad anchor of the part joins
MANY = 6.0  # use of a pixel, relative to the mean, that is drawn white
PALE = 0.45  # contrast, 0 to 1, of the gray picture under the cost of joins

HEAT = (0.0, 0.5, 1.0), colours("ffd666 f06e28 b00020")
USES = (0.0, 0.2, 0.36, 0.6, 0.85, 1.0), colours("12142c 422668 9e3c68 ec743e fcc85a ffffd6")
TINTS = colours("5682a8 c4945c 6e9e78 b06668 8878ac ccb878 5c98a0 a08876 786c60 be8cac 94aa62 5c6484")


# Drawing tools


def to_rgb(plane: Plane) -> Pixels:
    """Return a plane as 8-bit RGB (H, W, 3) for display, transparent pixels over gray."""
    seen = files.preview(plane)
    pixels = seen.samples
    if seen.alpha:
        opacity = pixels[:, :, -1:].astype(np.uint32)
        pixels = ((pixels[:, :, :-1] * opacity + PAPER * (255 - opacity) + 127) // 255).astype(np.uint8)
    return np.ascontiguousarray(pixels[:, :, :3] if pixels.shape[2] >= 3 else pixels[:, :, [0, 0, 0]])


def thumbnail(plane: Plane, most: int) -> Pixels:
    """Return a plane as 8-bit RGB (h, w, 3) of at most `most` px a side, averaged in square blocks."""
    seen = files.preview(plane)
    n = min(-(-max(seen.shape) // most), *seen.shape)
    if n > 1:
        height, width = (side - side % n for side in seen.shape)
        seen = seen.like(averaged(seen.like(seen.samples[:height, :width]), n))
    return np.ascontiguousarray(to_rgb(seen)[:most, :most])


def borders(numbers: Array) -> Mask:
    """Return a mask of the pixels whose right or lower neighbour has another number."""
    edge = np.zeros(numbers.shape, bool)
    edge[:-1] |= numbers[:-1] != numbers[1:]
    edge[:, :-1] |= numbers[:, :-1] != numbers[:, 1:]
    return edge


def ramp(scale: tuple[Sequence[float], Pixels], value: Array) -> Array:
    """Return numbers from 0 to 1 mapped to a colour scale: float32, with one more axis for RGB of 0 to 255.

    `scale`: positions from 0 to 1, ascending, and the colour at each.
    """
    at, ends = scale
    table = np.stack([np.interp(np.linspace(0, 1, 256), at, c) for c in ends.T], axis=1).astype(np.float32)
    return np.asarray(table[(value * 255).astype(np.int64)])


def stretched(cells: Array, shape: tuple[int, ...]) -> Array:
    """Return numbers of cells (rows, columns) enlarged to a picture by bilinear interpolation."""
    times = [n / m for n, m in zip(shape[:2], cells.shape, strict=True)]
    return np.asarray(ndimage.zoom(cells.astype(np.float32), times, order=1, mode="nearest", grid_mode=True))


def pieces(numbers: Array, step: int) -> Pixels:
    """Return the labelled pieces of a map in flat colours with darker borders: RGB of every `step`th pixel."""
    mixed = (np.arange(int(numbers.max()) + 1, dtype=np.uint32) * np.uint32(2654435761)) >> np.uint32(16)
    seen = numbers[::step, ::step]
    out: Pixels = TINTS[(mixed % np.uint32(len(TINTS)))[seen]]
    edge = borders(seen)
    out[edge] = out[edge] * 3 // 5
    return out


def _lined(picture: Array, distance: Array, colour: Array, core: float, rim: float, shade: float) -> Array:
    """Return a picture with an antialiased line at distance 0 px: a dark outline under the colour."""
    dark, line = shade * np.clip(rim - distance, 0, 1)[..., None], np.clip(core + 0.5 - distance, 0, 1)[..., None]
    return picture * (1 - dark) * (1 - line) + colour * line


# Overlays on an exemplar


def lattice_lines(exemplar: Exemplar, lattice: Lattice) -> Plane:
    """Return the exemplar with the lines of a lattice and, as white points, its lattice points, 8-bit RGB.

    The lines run where methods cut blocks of whole periods. Yellow lines run along the second vector, cyan ones along
    the first; the lines of a 1-D lattice, all yellow, are perpendicular to its vector.
    """
    picture: Array = to_rgb(exemplar.base)
    cell = (lattice.vectors[0], lattice.vectors[1] if len(lattice.vectors) == 2 else None)
    phase = phase_of(features([exemplar]).pictures[0], cell)
    y, x = np.mgrid[: exemplar.height, : exemplar.width] + 0.5 - np.reshape(phase, (2, 1, 1))
    for distance, colour in _marks(y, x, cell):
        picture = _lined(picture, distance, colour, CORE, EDGE + 0.5, SHADE)
    return Plane(np.clip(np.rint(picture), 0, 255).astype(np.uint8))


def _marks(y: Array, x: Array, cell: tuple[Any, Any]) -> Iterator[tuple[Array, Array]]:
    """Yield the distance of every place (y, x), in px, to each set of lines and to the points of a lattice; its colour.

    `cell`: the lattice vectors (rows, columns) in 1/256 px, the second None for a 1-D lattice.
    """
    p, q = np.array(cell[0]) / UNIT
    if cell[1] is None:
        yield _off((y * p + x * q) / np.hypot(p, q) ** 2) * np.hypot(p, q), YELLOW
        return
    r, s = np.array(cell[1]) / UNIT
    area = p * s - q * r
    first, second = (y * s - x * r) / area, (x * p - y * q) / area
    yield _off(first) * abs(area) / np.hypot(r, s), YELLOW
    yield _off(second) * abs(area) / np.hypot(p, q), CYAN
    a, b = first - np.floor(first), second - np.floor(second)
    corners = [np.hypot((a - i) * p + (b - j) * r, (a - i) * q + (b - j) * s) for i in (0, 1) for j in (0, 1)]
    yield np.maximum(np.min(corners, axis=0) - POINT, 0.0), WHITE


def _off(share: Array) -> Array:
    """Return the distance of numbers to the nearest integer."""
    return np.asarray(np.abs(share - np.rint(share)))


def segment_overlay(exemplar: Exemplar, found: Segments | None = None) -> Pixels:
    """Return the segments of an exemplar drawn over it: (H, W, 3), 8 bit.

    The chosen group keeps its brightness under a tint of orange and has yellow borders; the others are dimmed, each
    group with its own tint and dark borders. Unusable pixels are dark gray.

    Parameters
    ----------
    exemplar : Exemplar
        Its base plane is shown.
    found : Segments, optional
        Default: :func:`segments` of the exemplar.
    """
    found = segments(exemplar) if found is None else found
    picture = to_rgb(exemplar.base).astype(np.int32)
    group = found.group_map
    tints = GROUPS[np.arange(int(group.max(initial=0)) + 1) % len(GROUPS)].astype(np.int32)
    if found.chosen is not None:
        tints[found.chosen] = CHOSEN
    mine = group == (-2 if found.chosen is None else found.chosen)
    out = np.where(mine[..., None], (3 * picture + tints[group]) // 4, (2 * picture + tints[group]) // 5)
    out[group < 0] = GROUND
    edge = borders(found.labels)
    around = ndimage.binary_dilation(mine)  # a border belongs to the chosen group if either side does
    out[edge & ~around] = FAINT_LINE
    out[edge & around] = LINE
    return out.astype(np.uint8)


# Contact sheets


def contact_sheet(pictures: Sequence[Pixels]) -> Plane:
    """Return small pictures arranged in rows, in their order."""
    columns = math.ceil(math.sqrt(len(pictures)))
    high, wide = (max(p.shape[axis] for p in pictures) + GAP for axis in (0, 1))
    out = np.full((-(-len(pictures) // columns) * high + GAP, columns * wide + GAP, 3), SHEET, np.uint8)
    for number, picture in enumerate(pictures):
        y, x = (GAP + n * step for n, step in zip(divmod(number, columns), (high, wide), strict=True))
        out[y : y + picture.shape[0], x : x + picture.shape[1]] = picture
    return Plane(out)


# Pictures of a report


class ReportPicture(NamedTuple):
    """A picture (H, W, 3), 8 bit, with its name, its title and a caption (``says``)."""

    name: str
    title: str
    says: str
    pixels: Pixels


def pictures_of(outcome: Outcome) -> list[ReportPicture]:
    """Return all pictures of a report; those of the exemplars come last."""
    size = outcome.output.shape
    often = overused_places(outcome.judged, outcome.sizes, size)
    whole, beside = thumbnail(outcome.output, LARGE), thumbnail(outcome.output, BESIDE)
    shown = [thumbnail(e.base, BESIDE) for e in outcome.exemplars]
    what = f"{size[1]} x {size[0]} px" + (", shown smaller" if max(size) > LARGE else "")
    out = [ReportPicture("output", "The output", what, whole)]
    if outcome.wrap is not Wrap.NONE:
        out.append(_repeated(whole, outcome.wrap, size))
    out += [_joins(outcome, beside, size), _too_often(beside, size, often)]
    if outcome.map is not None:
        numbers = outcome.map.pieces()
        count, drawn = int(numbers.max()) + 1, pieces(numbers, -(-max(numbers.shape) // BESIDE))
        said = f"{count} piece{'s' * (count > 1)}, each a part of an exemplar that goes on unbroken"
        out.append(ReportPicture("pieces", "The pieces", said, drawn))
    names = ", ".join(f"{e.name}, {e.width} x {e.height} px" for e in outcome.exemplars)
    out.append(ReportPicture("exemplar", "The exemplar" + "s" * (len(shown) > 1), names, _in_a_row(shown)))
    out.append(_usage(outcome, shown))
    if often:
        rings = [
            _ringed(p, e.width, [(RINGS[n], [o.place]) for n, o in enumerate(often) if o.number == k])
            for k, (p, e) in enumerate(zip(shown, outcome.exemplars, strict=True))
        ]
        said = "The places that the rings in the output show"
        out.append(ReportPicture("sources", "What is shown too often", said, _in_a_row(rings)))
    return out


def _in_a_row(pictures: Sequence[Pixels]) -> Pixels:
    """Return pictures side by side."""
    high = max(len(p) for p in pictures)
    parts = [np.pad(p, ((0, high - len(p)), (0, APART), (0, 0)), constant_values=PAPER) for p in pictures]
    return np.concatenate(parts, axis=1)[:, :-APART]


def _repeated(picture: Pixels, wrap: Wrap, size: Pair) -> ReportPicture:
    times = 3 if max(size) <= SMALL else 2
    down, across = (times if closed else 1 for closed in wrap.closed)
    n = -(-max(picture.shape[0] * down, picture.shape[1] * across) // LARGE)
    if min(picture.shape[:2]) >= n > 1:
        picture = thumbnail(Plane(picture), -(-max(picture.shape[:2]) // n))
    said = "How it continues in itself"
    return ReportPicture("repeat", f"Repeated {across} x {down}", said, np.tile(picture, (down, across, 1)))


def heat(outcome: Outcome, size: Pair, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Return the local cost of joins of an output of `size`, enlarged to `shape`: position on HEAT, and opacity.

    Both are 0 to 1; FULL times the bad anchor of the part joins is 1.
    """
    cost, worst = local_join_costs(outcome.judged, size), outcome.score.parts["joins"]
    over = np.clip(stretched(cost, shape) * 100 / (FULL * worst.bad), 0, 1)
    return over, over**0.6


def _joins(outcome: Outcome, picture: Pixels, size: Pair) -> ReportPicture:
    over, opaque = heat(outcome, size, picture.shape)
    gray = picture.astype(np.float32).mean(axis=2, keepdims=True)
    pale = PALE * gray + (1 - PALE) * 226
    pixels = pale * (1 - opaque[..., None]) + ramp(HEAT, over) * opaque[..., None]
    said = "The redder, the more changes where another piece of the exemplar begins"
    return ReportPicture("joins", "Where joins cost", said, pixels.astype(np.uint8))


def _too_often(picture: Pixels, size: Pair, often: Sequence[Overused]) -> ReportPicture:
    if not often:
        said = f"No place of the exemplar is shown {OFTEN:g} times as often as the mean"
        return ReportPicture("often", "Nothing is shown too often", said, picture)
    parts = [f"{len(o.occurrences)} times the same place, {o.times:.1f} times the mean" for o in often]
    pixels = _ringed(picture, size[1], [(RINGS[n], o.occurrences) for n, o in enumerate(often)])
    return ReportPicture("often", "Shown too often", "; ".join(parts), pixels)


def _ringed(picture: Pixels, width: int, rings: Sequence[tuple[Array, Sequence[Circle]]]) -> Pixels:
    """Return a picture with rings around circles, which are given in px of a picture of `width` px."""
    out, scale = picture.copy(), picture.shape[1] / width
    for colour, spots in reversed(rings):
        for spot in spots:
            y, x, radius = spot.y * scale, spot.x * scale, max(spot.radius * scale, 4.0)
            far = radius + RIM + 1
            top, left = max(0, int(y - far)), max(0, int(x - far))
            part = out[top : max(0, int(y + far) + 2), left : max(0, int(x + far) + 2)]
            rows, columns = np.ogrid[top : top + part.shape[0], left : left + part.shape[1]]
            off = np.abs(np.hypot(rows + 0.5 - y, columns + 0.5 - x) - radius)
            part[:] = _lined(part, off, colour, RING, RIM, 0.75)
    return out


def _usage(outcome: Outcome, shown: Sequence[Pixels]) -> ReportPicture:
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
        light = 0.6 + 0.4 * picture.astype(np.float32).mean(axis=2, keepdims=True) / 255
        drawn = (usage_colours(_fitted(share, picture.shape)) * light).astype(np.uint8)
        if e.usable is not None:
            drawn[~_fitted(e.usable, picture.shape)] = PAPER
        parts.append(drawn)
    return ReportPicture("usage", "How often it is shown", said, _in_a_row(parts))


def usage_colours(times: Array) -> Array:
    """Return the colours of use counts relative to the mean, on a logarithmic scale: white for MANY or more."""
    return ramp(USES, np.log1p(np.minimum(times, MANY)) / np.log1p(MANY))


def _fitted(values: Array, shape: tuple[int, ...]) -> Array:
    """Return values resampled to the shape of a picture, nearest neighbour."""
    rows, columns = ((np.arange(n) * m) // n for n, m in zip(shape[:2], values.shape, strict=True))
    return values[np.ix_(rows, columns)]
