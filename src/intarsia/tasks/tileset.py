"""Wang tiles by corners: a set of tiles for fields without end, in which every tile fits all its legal neighbours.

    tiles = ia.tileset("pebbles.png", 16)
    ia.write("pebbles_tiles.png", tiles.render())
    ia.write("ground.png", tiles.laid(tiles.rule.field(64, 64)))

Each of K colours of corners is a square of the exemplar. Each edge of a tile, which has a colour at either end, is a
strip that is grown between two such squares. Each tile is grown between its strips. What lies within `kept` px of an
edge, on either side of it, is the strip in all tiles that have the edge, so nothing changes where two of them meet.

Lagae and Dutré, "An Alternative for Wang Tiles: Colored Edges versus Colored Corners", ACM Transactions on Graphics
25(4), 2006. Departures: strips and insides are grown by graph cuts, so that elements stay whole; the atlas is a torus
of legal neighbours (:mod:`intarsia.materials.tile_rules`), so all insides are grown at once, and each counts what the
others show.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from ..analysis import valid_windows, window_sums, without_patch
from ..analysis.oriented_energy import CourseLines
from ..analysis.saliency import saliency_map
from ..choosing.facts import STEPPED, Facts
from ..foundation import InputError, ParameterError, called, size_of, whole
from ..foundation.arrays import Array, Int32, Pair
from ..foundation.blend import Blend
from ..foundation.geometry import UNIT, Wrap
from ..foundation.run import Run, below, check_seed, draw, run_of
from ..lattice import allowed_misfit, misfit, vectors_of
from ..lattice.decision import Lattice
from ..materials.tile_rules import TileRule, cycle
from ..methods.graphcut import Graphcut
from ..model import Exemplar
from ..model.canvas import Canvas
from ..model.image import Plane
from ..model.sourcemap import HOLE, SourceMap
from ..patches import index_of
from ..search import element_patch
from ..synthesis import ExemplarLike, Scene, Synthesis, as_exemplars, filled
from .tileable import unit_of

COLOURS = {16: 2, 81: 3}
"""Number of tiles -> colours of corners."""

LEAST_SIDE = 16  # px: least side of a tile and of the exemplar; of a corner 10 px are left
LARGEST = 16384  # px: largest side of an atlas; textures of usual graphics hardware have no more
USUAL = 256  # px: default side of a tile, or that of the exemplar if less, or ELEMENTS elements if more
ELEMENTS = 3
TIMES = 4  # a tile is at most so many times as long as the exemplar, as it would show all of it again and again
NEAR = 0.75, 1.34  # range of lengths, relative to the wanted one, among which one that suits the texture is searched
SURE = 0.25  # px: lengths count as equal if a lattice misses them by so much more than the best
# Width of the rim in which a cut may run, as a share of an element; at most a share of a tile. With half of an element
# corners fill small exemplars, with a fifth stones are cut.
RIM, MOST_RIM = 1 / 3, 1 / 8
KEPT = 8  # px: what stays of a strip on either side of an edge, at most; so many fit three levels of mipmaps
MOST_STEPS = 100  # steps of a lattice in each direction within which another corner is looked for
CALM = 4  # corners are drawn from the least salient 1/CALM of all places, as they are seen most often
STAGE = 2006  # keeps these random numbers apart from others


@dataclass(frozen=True, eq=False)
class TileSet:
    """Tiles that fit one another: the atlas, and the rule by which they are laid.

    Attributes
    ----------
    atlas : Synthesis
        All tiles beside each other, with the source map; it is periodic, and all of its neighbours are legal.
    rule : TileRule
        Colours of corners of all tiles, their size, and how a field chooses among them.
    kept : int
        px on either side of an edge that are equal in all tiles that have it.
    seed : int
        That was given.
    """

    atlas: Synthesis
    rule: TileRule
    kept: int
    seed: int

    def render(self, plane: str | None = None, run: Run | None = None) -> Plane:
        """Render the atlas of a plane, by default of the base, by exact copies; arguments as of a Synthesis."""
        return self.atlas.render(plane, run=run)

    def laid(self, field: Array, plane: str | None = None) -> Plane:
        """Return the picture of a field of tile numbers, (rows, columns), as ``rule.field`` returns them."""
        whole, n = self.render(plane), self.rule.side
        h, w = whole.height // n, whole.width // n
        parts = whole.samples.reshape(n, h, n, w, -1).swapaxes(1, 2).reshape(n * n, h, w, -1)
        return whole.like(parts[field].swapaxes(1, 2).reshape(field.shape[0] * h, field.shape[1] * w, -1))


@dataclass(frozen=True)
class TilePlan:
    """Measurements of the exemplar; colours of corners; the lattice, if it closes in a tile; lengths in px.

    ``size``: height and width of a tile; ``corner``, ``strip``: half the sides of a corner and half the width of a
    strip; ``rim``: where cuts may run; ``kept``: what they leave of a strip on either side of an edge.
    """

    facts: Facts
    colours: int
    lattice: Lattice | None
    size: Pair
    corner: int
    strip: int
    rim: int
    kept: int


def tileset(
    image: ExemplarLike,
    tiles: int = 16,
    *,
    size: int | Pair | None = None,
    seed: int = 0,
    run: Run | None = None,
) -> TileSet:
    """Grow a set of Wang tiles by corners, of which fields of any size are laid without a seam.

    Parameters
    ----------
    image : as for :func:`synthesize`
        A picture, or planes of one surface, which all follow one map. At least 16 px a side.
    tiles : {16, 81}
        How many: two or three colours of corners, default 16.
    size : int or (height, width), optional
        Of a tile in px, 16 to four times the exemplar. Default: about 256 px, or the exemplar if it is smaller, or
        three elements if they are larger; whole periods of a lattice, or whole courses.
    seed : int
        0 to 2**64 - 1, default 0; the same seed gives the same bytes.
    run : Run, optional
        Threads, progress, cancelling; gets a note if tiles hold no whole periods or courses.

    Returns
    -------
    TileSet
        The atlas, its source map, and the rule.

    Raises
    ------
    ParameterError
        for another number of tiles, or a size out of range.
    InputError
        if the exemplar cannot be read, or is too small.
    MethodError
        if a mask leaves no room for a corner.
    """
    run = run_of(run)
    return grown(planned(as_exemplars([image])[0], tiles, None if size is None else size_of(size), run), seed, run)


def planned(exemplar: Exemplar, tiles: int, size: Pair | None, run: Run) -> TilePlan:
    """Return the plan of a set of tiles of (height, width) px; None: the default. Arguments and errors of the task."""
    with suppress(ValueError):
        tiles = whole(tiles)
    if not isinstance(tiles, int) or tiles not in COLOURS:
        raise ParameterError(f"tiles={called(tiles)} is not allowed; give {' or '.join(map(str, COLOURS))}.")
    colours, unit = COLOURS[tiles], unit_of(exemplar)
    described = f"{exemplar.name} ({exemplar.width}x{exemplar.height} px)"
    if min(exemplar.shape) < LEAST_SIDE:
        raise InputError(f"{described} is too small for tiles; give {LEAST_SIDE} px a side.")
    facts = Facts([exemplar], Canvas(*exemplar.shape), run)
    found = size or usual_size(facts, colours, unit)
    asked, most = f"size={called(found[1])}x{called(found[0])}", LARGEST // colours**2
    for wrong, remedy in (
        (min(found) < LEAST_SIDE, f"give {LEAST_SIDE} px a side at least"),
        (max(found) > most, f"give at most {most} px, so that {tiles} tiles fit into a texture"),
        (max(found) > TIMES * min(exemplar.shape), f"{described} is too small for it; give {TIMES} times that at most"),
        (any(n % unit for n in found), f"it cuts pixels of a smaller plane; give multiples of {unit}"),
    ):
        if wrong:
            raise ParameterError(f"{asked} is not allowed for a tile: {remedy}.")
    lattice, lines, missed = facts.about or facts.lattice, facts.courses, ""
    if lattice is not None and not closes(lattice, found, colours):
        lattice, missed = None, "periods"
    if lattice is None and lines is not None:
        missed = "" if any(found[lines.axis] % n == 0 for n in heights_of(lines, unit)) else "courses"
    if missed:
        told = f"{exemplar.name}: no whole {missed} fill tiles of {found[1]}x{found[0]} px"
        run.notes.append(f"{told}, so some elements are cut.")
    rim = max(round(min(RIM * element_patch([exemplar]), MOST_RIM * min(*found, *exemplar.shape))), 1)
    kept = min(KEPT, rim // 2)
    return TilePlan(facts, colours, lattice, found, kept + 2 * rim, kept + rim, rim, kept)


def grown(plan: TilePlan, seed: int, run: Run) -> TileSet:
    """Grow the tiles of a plan: corners, strips, then all insides at once."""
    seed, rule = check_seed(seed), TileRule(plan.colours, *plan.size)
    squares = corners_of(plan, seed)
    strips = [_strip(plan, squares, axis, draw(seed, STAGE, 1 + axis), run.part(axis, 3)) for axis in (0, 1)]
    made = _filled(plan, *_frame(rule, plan, strips), Wrap.BOTH, draw(seed, STAGE, 3), run.part(2, 3))
    about = {"tiles": plan.colours**4, "size": [*plan.size[::-1]], "seed": seed}
    return TileSet(replace(made, recipe=made.recipe | {"tileset": about}), rule, plan.kept, seed)


def closes(lattice: Lattice, size: Pair, colours: int) -> bool:
    """Whether a lattice closes in tiles of (height, width) px, and around an atlas of them at as many periods."""
    far = max(misfit(lattice.vectors, n, axis) for axis, n in enumerate(size))
    shortest = min(math.hypot(*v) for v in lattice.vectors) / UNIT
    return far <= allowed_misfit(lattice.vectors) and 2 * far * colours**2 < shortest


def usual_size(facts: Facts, colours: int, unit: int) -> Pair:
    """Return the default size of a tile, (height, width), px: of whole periods or courses, if there are any."""
    exemplar, lattice, lines = facts.exemplar, facts.about or facts.lattice, facts.courses
    goal = max(min(USUAL, *exemplar.shape), min(ELEMENTS * element_patch([exemplar]), LARGEST // 9))
    goal = max(goal // unit * unit, LEAST_SIDE)
    among = range(math.ceil(NEAR[0] * goal / unit) * unit, int(NEAR[1] * goal), unit)
    if lattice is not None:
        misses = [{n: misfit(lattice.vectors, n, axis) for n in among} for axis in (0, 1)]
        good = [[n for n, miss in each.items() if miss <= min(each.values()) + SURE] for each in misses]
        height, width = (min(lengths, key=lambda n: abs(n - goal)) for lengths in good)
        if closes(lattice, (height, width), colours):
            return height, width
    out = [goal, goal]
    if lines is not None:
        whole = [[k * n for n in heights_of(lines, unit) if k * n in among] for k in range(1, TIMES + 1)]
        out[lines.axis] = min(next(filter(None, whole), [goal]), key=lambda n: abs(n - goal))
    return out[0], out[1]


def heights_of(lines: CourseLines, unit: int) -> list[int]:
    """Return the heights, px, of all runs of neighbouring courses, rounded down to multiples of `unit`."""
    ends = [0, *np.cumsum(lines.heights).tolist()]
    return sorted({(b - a) // unit * unit for a in ends for b in ends if b > a})


def corners_of(plan: TilePlan, seed: int) -> list[Int32]:
    """Return a square of the exemplar for each colour of corners: rows and columns of its pixels, (2c, 2c, 2) each.

    They are calm and far from each other, and whole steps of the lattice apart, or on the same course.
    """
    exemplar, side = plan.facts.exemplar, 2 * plan.corner
    salient = saliency_map(plan.facts.picture, exemplar.usable, exemplar.toroidal)
    free, load = valid_windows(exemplar.shape, exemplar.usable, False, (side, side)), window_sums(salient, (side, side))
    if not free.any():
        raise without_patch((side, side))
    grid = max(1, min(exemplar.shape) // 64)
    places = np.argwhere(free[::grid, ::grid]) * grid
    places = places if len(places) else np.argwhere(free)
    chosen: list[Array] = []
    for colour in range(plan.colours):
        apart = np.min([abs(places - at).max(axis=1) for at in chosen] or [np.zeros(len(places))], axis=0)
        calm = places[apart >= min(side, apart.max())]
        calm = calm[np.argsort(load[tuple(calm.T)], kind="stable")[: -(-len(calm) // CALM)]]
        chosen.append(calm[below(len(calm), draw(seed, STAGE, 0, colour))])
        if colour == 0:
            alike = _alike(plan, chosen[0], free.shape, grid)
            places = places if alike is None else alike[free[tuple(alike.T)]]
    at = np.moveaxis(np.indices((side, side), dtype=np.int32), 0, 2)
    return [at + np.asarray(first, np.int32) for first in chosen]


def _alike(plan: TilePlan, first: Array, shape: Pair, grid: int) -> Array | None:
    """Return the places whole steps of the lattice from `first`, or on its course, (n, 2); None: all are alike."""
    lines, steps = plan.facts.courses, list[Array]()
    if plan.lattice is not None:
        steps = [np.array(v) / UNIT for v in plan.lattice.vectors]
        if len(steps) == 1:
            steps.append(grid * steps[0][::-1] * (-1, 1) / math.hypot(*steps[0]))
    elif lines is not None:
        steps = [grid * np.eye(2)[1 - lines.axis]]
    found = np.array(first, float)[None]
    for step in steps:
        most = min(int(2 * max(shape) / math.hypot(*step)), MOST_STEPS)
        found = (found[:, None] + np.arange(-most, most + 1)[:, None] * step).reshape(-1, 2)
    found = np.rint(found).astype(int)
    return found[((found >= 0) & (found < shape)).all(axis=1)] if steps else None


def _strip(plan: TilePlan, squares: list[Int32], axis: int, seed: int, run: Run) -> Array:
    """Return the strips of all edges along an axis, end to end in a circle of corners: pixels of the exemplar."""
    line, side = cycle(len(squares)), 2 * plan.corner
    shape = [side, side]
    shape[axis] = len(line) * plan.size[axis]
    yx, there = np.zeros((*shape, 2), np.int32), np.zeros(shape, bool)
    for n, colour in enumerate(line):
        begin = n * plan.size[axis] - plan.corner
        at = index_of(*((begin, 0), (0, begin))[axis], (side, side), shape)
        yx[at], there[at] = squares[colour], True
    return _filled(plan, yx, there, (Wrap.Y, Wrap.X)[axis], seed, run).map.yx


def _frame(rule: TileRule, plan: TilePlan, strips: list[Array]) -> tuple[Array, Array]:
    """Return the start of the atlas: pixels of the exemplar (H, W, 2), and where there are any, the strips (H, W)."""
    line, shape = cycle(rule.colours), [rule.side * n for n in plan.size]
    numbers = {pair: n for n, pair in enumerate(zip(line, [*line[1:], line[0]], strict=True))}
    yx, there = np.zeros((*shape, 2), np.int32), np.zeros(shape, bool)
    for axis, strip in enumerate(strips):
        along, across = plan.size[axis], slice(plan.corner - plan.strip, plan.corner + plan.strip)
        ends = np.stack([rule.corners, np.roll(rule.corners, -1, axis)], axis=2)
        for place in np.ndindex(rule.corners.shape):
            n, (y, x) = numbers[tuple(ends[place].tolist())], np.multiply(place, plan.size).tolist()
            part = slice(n * along, (n + 1) * along)
            if axis == 0:
                at, shown = index_of(y, x - plan.strip, (along, 2 * plan.strip), shape), strip[part, across]
            else:
                at, shown = index_of(y - plan.strip, x, (2 * plan.strip, along), shape), strip[across, part]
            yx[at], there[at] = shown, True
    return yx, there


def _filled(plan: TilePlan, yx: Array, there: Array, wrap: Wrap, seed: int, run: Run) -> Synthesis:
    """Fill what is not `there` of a map by graph cuts, in step with the lattice if there is one."""
    exemplar, lattice = plan.facts.exemplar, plan.lattice
    start = SourceMap(yx, np.where(there, 0, HOLE).astype(np.uint8), None, (exemplar.source,), wrap)
    canvas, method = Canvas(*start.shape, wrap, start, rim=plan.rim), Graphcut()
    if lattice is not None and lattice is plan.facts.about:
        longest = max(abs(n) for v in lattice.vectors for n in v) / UNIT
        if min(exemplar.shape) > LEAST_SIDE + longest:  # a patch fits beside one period
            method = Graphcut(lattice=vectors_of(lattice), evenness=STEPPED)
    side = min(*method.resolved([exemplar], canvas).footprint, 2 * plan.corner)
    return filled(Scene((exemplar,), canvas), replace(method, patch=side), seed, Blend(0), run)
