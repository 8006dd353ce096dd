"""Visualisations: overlays of lattices and segments on exemplars, contact sheets, and the pictures of a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw

from .. import files
from ..analysis.features import features
from ..foundation import ndimage
from ..foundation.arrays import Array, Mask, Pair, UInt8
from ..foundation.geometry import UNIT, Wrap
from ..judging import local_join_costs
from ..lattice.decision import Lattice
from ..model import Exemplar
from ..model.image import Plane
from ..regular.block_grid import phase_of
from ..segments import Segments, segments
from .scoring import Outcome

Pixels = UInt8


def colours(words: str) -> Pixels:
    """Return colours given as hexadecimal numbers, such as "ffe100 00e1ff", as (n, 3)."""
    return np.frombuffer(bytes.fromhex(words), np.uint8).reshape(-1, 3)


PAPER = "#808080"  # under transparent pixels and between exemplars
YELLOW, CYAN, WHITE, DARK = "#ffe100", "#00e1ff", "#ffffff", "#303030"

THIN, BROAD, POINT = 2, 4, 3  # px: width of a lattice line, and of its dark outline; radius of a point

GROUPS = colours("56b4e9 009e73 cc79a7 0072b2 e69f00 785ef0 808080")
CHOSEN, LINE, FAINT_LINE = colours("d55e00 ffff5a 141414")
GROUND = 40  # gray value, of 255, of unusable pixels

THUMBNAIL, GAP, SHEET = 256, 8, "#404040"  # contact sheet: side of its pictures and gap between them, px; its ground

LARGE, BESIDE = 1024, 768  # px: longest side of the output in a report, and of its other pictures
SMALL = 256  # px: outputs up to this size are repeated three times along each closed axis, others twice
APART = 12  # px between exemplars
FULL = 2.0  # cost of joins that is drawn fully red, relative to the bad anchor of the part joins
MANY = 6.0  # use of a pixel, relative to the mean, that is drawn white
PALE = 0.45  # contrast, 0 to 1, of the gray picture under the cost of joins

HEAT = (0.0, 0.5, 1.0), colours("ffd666 f06e28 b00020")
USES = (0.0, 0.2, 0.36, 0.6, 0.85, 1.0), colours("12142c 422668 9e3c68 ec743e fcc85a ffffd6")
TINTS = colours("5682a8 c4945c 6e9e78 b06668 8878ac ccb878 5c98a0 a08876 786c60 be8cac 94aa62 5c6484")


# Drawing tools


def to_rgb(plane: Plane) -> Pixels:
    """Return a plane as 8-bit RGB (H, W, 3) for display, transparent pixels over gray."""
    seen = Image.fromarray(files.preview(plane).pixels).convert("RGBA")
    paper = Image.new("RGBA", seen.size, PAPER)
    return np.asarray(Image.alpha_composite(paper, seen).convert("RGB"))


def thumbnail(plane: Plane, most: int) -> Pixels:
    """Return a plane as 8-bit RGB (h, w, 3), reduced to at most `most` px a side."""
    picture = Image.fromarray(to_rgb(plane))
    picture.thumbnail((most, most))
    return np.asarray(picture)


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
    picture = Image.fromarray(cells.astype(np.float32))
    return np.asarray(picture.resize((shape[1], shape[0]), Image.Resampling.BILINEAR))


def pieces(numbers: Array, step: int) -> Pixels:
    """Return the labelled pieces of a map in flat colours with darker borders: RGB of every `step`th pixel."""
    mixed = (np.arange(int(numbers.max()) + 1, dtype=np.uint32) * np.uint32(2654435761)) >> np.uint32(16)
    seen = numbers[::step, ::step]
    out: Pixels = TINTS[(mixed % np.uint32(len(TINTS)))[seen]]
    edge = borders(seen)
    out[edge] = out[edge] * 3 // 5
    return out


# Overlays on an exemplar


def lattice_lines(exemplar: Exemplar, lattice: Lattice) -> Plane:
    """Return the exemplar with the lines of a lattice and, as white points, its lattice points, 8-bit RGB.

    The lines run where methods cut blocks of whole periods. Yellow lines run along the second vector, cyan ones along
    the first; the lines of a 1-D lattice, all yellow, are perpendicular to its vector.
    """
    picture = Image.fromarray(to_rgb(exemplar.base))
    draw = ImageDraw.Draw(picture)
    first, *other = np.array(lattice.vectors) / UNIT
    second = other[0] if other else np.array((-first[1], first[0]))
    cell = (lattice.vectors[0], lattice.vectors[1] if other else None)
    origin = np.array(phase_of(features([exemplar]).pictures[0], cell)) - 0.5  # the middle of a pixel is a whole number
    corners = np.array([(y, x) for y in (0, exemplar.height) for x in (0, exemplar.width)]) - origin
    numbers = corners @ np.linalg.inv((first, second))  # the corners in the basis of the lattice
    low, high = np.floor(numbers.min(axis=0)).astype(int) - 1, np.ceil(numbers.max(axis=0)).astype(int) + 1

    def at(a: float, b: float) -> tuple[float, float]:
        y, x = origin + a * first + b * second
        return x, y

    lines = [(at(n, low[1]), at(n, high[1]), YELLOW) for n in range(low[0], high[0] + 1)]
    lines += [(at(low[0], n), at(high[0], n), CYAN) for n in range(low[1], high[1] + 1) if other]
    for begin, end, _ in lines:
        draw.line((begin, end), DARK, BROAD)
    for begin, end, colour in lines:
        draw.line((begin, end), colour, THIN)
    if other:
        for a, b in np.ndindex(*(high - low + 1)):
            draw.circle(at(low[0] + a, low[1] + b), POINT, WHITE)
    return Plane(np.asarray(picture))


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
    rows = math.ceil(len(pictures) / columns)
    high, wide = (max(p.shape[axis] for p in pictures) + GAP for axis in (0, 1))
    sheet = Image.new("RGB", (columns * wide + GAP, rows * high + GAP), SHEET)
    for number, picture in enumerate(pictures):
        row, column = divmod(number, columns)
        sheet.paste(Image.fromarray(picture), (column * wide + GAP, row * high + GAP))
    return Plane(np.asarray(sheet))


# Pictures of a report


class ReportPicture(NamedTuple):
    """A picture (H, W, 3), 8 bit, with its name, its title and a caption (``says``)."""

    name: str
    title: str
    says: str
    pixels: Pixels


def pictures_of(outcome: Outcome) -> list[ReportPicture]:
    """Return all pictures of a report: of the output first, then of the exemplars."""
    size, smap = outcome.output.shape, outcome.map
    whole, shown = thumbnail(outcome.output, LARGE), [thumbnail(e.base, BESIDE) for e in outcome.exemplars]
    what = f"{size[1]} x {size[0]} px" + (", shown smaller" if max(size) > LARGE else "")
    out = [ReportPicture("output", "The output", what, whole)]
    if outcome.wrap is not Wrap.NONE:
        out.append(_repeated(whole, outcome.wrap, size))
    out.append(_joins(outcome, size))
    if smap is not None:
        numbers = smap.pieces()
        count, drawn = int(numbers.max()) + 1, pieces(numbers, -(-max(numbers.shape) // BESIDE))
        said = f"{count} piece{'s' * (count > 1)}, each a part of an exemplar that goes on unbroken"
        out.append(ReportPicture("pieces", "The pieces", said, drawn))
    names = ", ".join(f"{e.name}, {e.width} x {e.height} px" for e in outcome.exemplars)
    out.append(ReportPicture("exemplar", "The exemplar" + "s" * (len(shown) > 1), names, _in_a_row(shown)))
    if smap is not None:
        out.append(_usage(outcome, smap.usage(), shown))
    return out


def _in_a_row(pictures: Sequence[Pixels]) -> Pixels:
    """Return pictures side by side."""
    size = sum(p.shape[1] + APART for p in pictures) - APART, max(len(p) for p in pictures)
    row, left = Image.new("RGB", size, PAPER), 0
    for picture in pictures:
        row.paste(Image.fromarray(picture), (left, 0))
        left += picture.shape[1] + APART
    return np.asarray(row)


def _repeated(picture: Pixels, wrap: Wrap, size: Pair) -> ReportPicture:
    times = 3 if max(size) <= SMALL else 2
    down, across = (times if closed else 1 for closed in wrap.closed)
    many = thumbnail(Plane(np.tile(picture, (down, across, 1))), LARGE)
    return ReportPicture("repeat", f"Repeated {across} x {down}", "How it continues in itself", many)


def heat(outcome: Outcome, size: Pair, shape: tuple[int, ...]) -> Array:
    """Return the local cost of joins of an output of `size`, enlarged to `shape`: 0 to 1, the position on HEAT.

    FULL times the bad anchor of the part joins is 1.
    """
    cost, worst = local_join_costs(outcome.judged, size), outcome.score.parts["joins"]
    return np.clip(stretched(cost, shape) * 100 / (FULL * worst.bad), 0, 1)


def _joins(outcome: Outcome, size: Pair) -> ReportPicture:
    picture = thumbnail(outcome.output, BESIDE)
    over = heat(outcome, size, picture.shape)
    opaque = over[..., None] ** 0.6
    gray = picture.astype(np.float32).mean(axis=2, keepdims=True)
    pale = PALE * gray + (1 - PALE) * 226
    pixels = pale * (1 - opaque) + ramp(HEAT, over) * opaque
    said = "The redder, the more changes where another piece of the exemplar begins"
    return ReportPicture("joins", "Where joins cost", said, pixels.astype(np.uint8))


def _usage(outcome: Outcome, counts: Sequence[Array], shown: Sequence[Pixels]) -> ReportPicture:
    usable = sum(int(e.free.sum()) for e in outcome.exemplars) / outcome.times**2
    mean = sum(int(c.sum()) for c in counts) / max(usable, 1)
    parts = []
    for picture, count, e in zip(shown, counts, outcome.exemplars, strict=True):
        light = 0.6 + 0.4 * picture.astype(np.float32).mean(axis=2, keepdims=True) / 255
        drawn = (usage_colours(_fitted(count, picture.shape) / mean) * light).astype(np.uint8)
        if e.usable is not None:
            drawn[~_fitted(e.usable, picture.shape)] = colours(PAPER[1:])
        parts.append(drawn)
    said = f"Dark is not shown, red as often as the mean, white {MANY:.0f} times as often or more"
    return ReportPicture("usage", "How often it is shown", said, _in_a_row(parts))


def usage_colours(times: Array) -> Array:
    """Return the colours of use counts relative to the mean, on a logarithmic scale: white for MANY or more."""
    return ramp(USES, np.log1p(np.minimum(times, MANY)) / np.log1p(MANY))


def _fitted(values: Array, shape: tuple[int, ...]) -> Array:
    """Return values resampled to the shape of a picture, nearest neighbour."""
    rows, columns = ((np.arange(n) * m) // n for n, m in zip(shape[:2], values.shape, strict=True))
    return values[np.ix_(rows, columns)]
