"""Patch-by-patch synthesis: the loop of all methods that fill windows of a canvas in batches.

Overlapping windows keep raster order. A method supplies how one of the candidates is chosen, and how it is joined.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..analysis import variance
from ..analysis.features import features
from ..foundation import lazy, ndimage
from ..foundation.arrays import Array, Int64, Mask, Pair
from ..foundation.blend import Blend
from ..foundation.geometry import patch_starts
from ..foundation.params import AUTO, Poses, Weights, extent
from ..foundation.run import Run, draw_many
from ..kernels.cuts import SeamPrice
from ..model import Exemplars
from ..model.canvas import Canvas, Guide
from ..model.sourcemap import HOLE, SourceMap
from ..search import (
    SHORT_LIST,
    Candidates,
    PosedExemplars,
    Search,
    WindowGrid,
    check_patch,
    isometry_ids,
    nearest,
    posed_exemplars,
    resolved_isometries,
)
from ..search.fourier import PatchSearch
from . import MapBuilder, Pick, Window, fill_order, index_of, random_patch, window_batches
from .repetition import Repetition, patch_saliency
from .repetition_kernels import edge_cells, weigh_edge

if TYPE_CHECKING:
    from ..search import guide as guiding
else:  # where labels are asked for
    guiding = lazy("intarsia.search.guide")

SLACK = 2  # by default labels may stray 1 / SLACK of a patch along boundaries into another region, at least 2 px


class Boundaries(NamedTuple):
    """Parameters of patches along the boundaries of a guide's labels.

    ``patch``: their side, px; 0: as large as the others. ``isometries``: those that are allowed only there.
    ``slack``: how far one label's pixels may lie in another's region, px, before they are replaced; None: any distance.
    """

    patch: int = 0
    isometries: Poses = "none"
    slack: int | None = None

    @classmethod
    def of(cls, patch: Pair, side: int | None, isometries: Poses | None, slack: int | None) -> Boundaries:
        """Return the parameters for patches of (rows, columns), with defaults for those that are None.

        Defaults: half a patch, all isometries that keep its shape, and 1 / SLACK of the side, at least 2 px.
        """
        side = min(patch) // 2 if side is None else side
        poses = isometries if isometries is not None else "both" if patch[0] == patch[1] else "180"
        return cls(side, poses, max(2, (side or min(patch)) // SLACK) if slack is None else slack)


@dataclass(frozen=True)
class PatchSettings:
    """Parameters of patch-based synthesis.

    `weights`, `structure`, `isometries` and `search` as the parameters of these names.
    """

    patch: Pair  # rows and columns of a window, px
    overlap: Pair  # that neighbours share, px
    # Windows at their exact pitch, of which the first begins so many overlaps before the border; None: spread evenly.
    hangs: int | None = None
    weights: Weights = None
    structure: float = 0.0  # weight of outlines and slow colour
    isometries: Poses = "none"
    search: str = "fast"
    listed: int = SHORT_LIST  # number of candidates that a search returns for each window
    rule: type[Repetition] = Repetition  # control of repeats
    usage: float = 0.0  # price of a repeat in usual distances
    rim: int = 0  # how deep start pixels may be replaced, px
    boundaries: Boundaries = field(default=Boundaries())  # how patches lie along the boundaries of a guide's labels
    # Makes a method's own search from these settings, the variants, the size of a window and the number of candidates.
    finder: Callable[[PatchSettings, PosedExemplars, Pair, int], Search] | None = None
    # Makes the search under a guide from that search, the guide of windows, and the unit of seam distances.
    guided: Callable[[Any, guiding.WindowGuide, int], guiding.GuidedSearch] | None = None

    def poses(self, guide: Guide | None) -> tuple[int, ...]:
        """Return the isometries of patches, those for boundaries of labels included."""
        own = isometry_ids(self.isometries)
        if guide is None or not guide.is_labels:
            return own
        return tuple(sorted({*own, *isometry_ids(self.boundaries.isometries)}))

    @property
    def smaller(self) -> PatchSettings | None:
        """The parameters along boundaries of labels; None where patches are as large as elsewhere."""
        side, least = self.boundaries.patch, min(self.patch)
        if not side or side >= least:
            return None
        rows, columns = (max(1, round(p * side / least)) for p in self.patch)
        shared = zip(self.overlap, (rows, columns), strict=True)
        high, wide = (min(max(min(o, 1), o * side // least), p - 1) for o, p in shared)
        bounds = self.boundaries._replace(patch=0)
        return replace(self, patch=(rows, columns), overlap=(high, wide), boundaries=bounds, rim=max(high, wide))

    def layout(self, canvas: Canvas) -> WindowGrid:
        """Return the windows of a canvas: around its start map if it has one and no guide, else a grid."""
        size, wraps = (canvas.height, canvas.width), (canvas.wrap.y, canvas.wrap.x)
        if canvas.guide is None and canvas.start is not None and not canvas.start.holes.all():
            patch = (min(self.patch[0], canvas.height), min(self.patch[1], canvas.width))
            overlap = (min(self.overlap[0], patch[0] - 1), min(self.overlap[1], patch[1] - 1))
            found = fill_order(~canvas.start.holes, patch, overlap, wraps)
            return WindowGrid((), (), patch, size, wraps, tuple(found))
        (rows, height), (columns, width) = (
            patch_starts(*axis, self.hangs) for axis in zip(size, self.patch, self.overlap, wraps, strict=True)
        )
        return WindowGrid(tuple(rows), tuple(columns), (height, width), size, wraps)


PASS = 1 << 20  # offset of the stage of random numbers of the second pass; of later ones 2 PASS and more


class Stages:
    """The passes that make a map: one, or several under a guide of labels.

    Iterate, fill each :class:`PatchSynthesis` yielded, then take the `map`. Under labels windows inside the regions
    come first, then the rest with smaller patches; last, pixels too deep in another label's region are replaced.
    """

    map: SourceMap

    def __init__(self, settings: PatchSettings, exemplars: Exemplars, canvas: Canvas, blend: Blend) -> None:
        self.settings, self.exemplars, self.canvas, self.blend = settings, exemplars, canvas, blend

    def __iter__(self) -> Iterator[PatchSynthesis]:
        guide, settings, exemplars = self.canvas.guide, self.settings, self.exemplars
        if guide is None or not guide.is_labels:
            yield from self._filled(PatchSynthesis(settings, exemplars, self.canvas))
            return
        small = settings.smaller
        yield from self._filled(
            PatchSynthesis(settings, exemplars, self.canvas, small is not None, turn=PassNumber(0, 0, 3))
        )
        if small is not None and self.map.holes.any():
            begun = replace(self.canvas, start=self.map)
            yield from self._filled(PatchSynthesis(small, exemplars, begun, turn=PassNumber(PASS, 1, 3)))
        if settings.boundaries.slack is not None and guide.weight:
            yield from self._without_strays(guide, settings.boundaries.slack)

    def _filled(self, growth: PatchSynthesis) -> Iterator[PatchSynthesis]:
        yield growth
        self.map = growth.map(self.blend)

    def _without_strays(self, guide: Guide, slack: int) -> Iterator[PatchSynthesis]:
        """Replace pixels that lie too deep in the region of another label, one region of the target after the other.

        They occur where the exemplars have no boundary of that shape, or none at all between two labels. While a region
        is filled, all pixels outside it are holes of the start map; pixels of a given start map are not replaced.
        """
        target = guiding.numbered_labels(guide.target, guide.names)
        found = shown_labels(self.map, guide)
        stray = stray_pixels(found, target, slack, neighbours(guide))
        free = np.ones(target.shape, bool) if self.canvas.start is None else self.canvas.start.holes
        stray &= free
        settings = replace(self.settings, boundaries=self.settings.boundaries._replace(isometries="none"))
        for k in np.unique(target[stray]).tolist():
            here = target == k
            kept = np.where(here & (found == k), self.map.numbers, HOLE).astype(np.uint8)
            start = replace(self.map, which=kept)
            plane = replace(guide.target, pixels=np.full_like(guide.target.pixels, guide.names[k]))
            inner = replace(self.canvas, start=start, guide=replace(guide, target=plane))
            growth = PatchSynthesis(
                settings, self.exemplars, inner, wanted=stray & here, turn=PassNumber(2 * PASS + k, 2, 3)
            )
            yield growth
            taken = free & here & (stray | (found == k))
            self.map = _merged(self.map, growth.map(self.map.blend), taken)


def shown_labels(smap: SourceMap, guide: Guide) -> Array:
    """Return the number of the label that the exemplar pixel of every output pixel has; -1 in holes."""
    out = np.full(smap.yx.shape[:2], -1, np.int16)
    for n, source in enumerate(guide.sources):
        mine = smap.numbers == n
        yx = smap.yx[mine]
        out[mine] = guiding.numbered_labels(source, guide.names)[yx[:, 0], yx[:, 1]]
    return out


def neighbours(guide: Guide) -> Array:
    """Return which labels adjoin in the exemplars: (K + 1, K + 1), True on the diagonal; K: those not in the target."""
    size = len(guide.names) + 1
    out = np.eye(size, dtype=bool)
    for source in guide.sources:
        ids = guiding.numbered_labels(source, guide.names)
        for a, b in ((ids[1:], ids[:-1]), (ids[:, 1:], ids[:, :-1])):
            out[a, b] = out[b, a] = True
    return out


def stray_pixels(found: Array, target: Array, slack: int, beside: Array) -> Array:
    """Return which pixels have a wrong label and are to be replaced: (H, W) bool.

    These are the connected groups of wrong pixels that extend deeper than `slack` px into a region of `target`, and
    all whose two labels do not adjoin in the exemplars (`beside`, from :func:`neighbours`).
    """
    wrong = np.asarray(found != target)
    groups, count = ndimage.label(wrong, np.ones((3, 3)))
    if not count:
        return wrong
    depth = np.zeros(target.shape)
    for k in np.unique(target).tolist():
        here = target == k
        if here.all():
            depth[:] = np.inf
        else:
            depth[here] = ndimage.distance_transform_edt(here)[here]
    deepest = np.append(-1.0, ndimage.maximum(depth, groups, np.arange(1, count + 1)))
    return np.asarray((deepest[groups] > slack) | ~beside[found, target])


def _merged(below: SourceMap, above: SourceMap, taken: Array) -> SourceMap:
    """Return `below` with the pixels `taken` from `above`."""
    parts = []
    for old, mine, other in ((below.which, below.numbers, above.numbers), (below.pose, below.turns, above.turns)):
        both = np.where(taken, other, mine)
        parts.append(None if old is None and not both.any() else both)
    yx = np.where(taken[:, :, None], above.yx, below.yx)
    return replace(below, yx=yx, which=parts[0], pose=parts[1])


Choose = Callable[[Window, Candidates, int], Pick]
Join = Callable[[Window, Pick, Candidates], None]

AROUND_HOLES = 64  # candidates kept of every search for windows around a start map whose rim is 0
# Of the standard deviation. Strong steps per 1000 px: halved, pebbles 1.8 for 1.2; doubled, a pebble road 5.6 for 4.
KNEE = 3, 8


def seam_threshold(spread: int) -> int:
    """Return the threshold of the truncated quadratic seam cost ``sharp``, from the variance of the features."""
    return max(math.isqrt(spread) * KNEE[0] // KNEE[1], 1)


class PassNumber(NamedTuple):
    """One of several passes over a map: its offset to the stage of random numbers, its number, how many there are."""

    stage: int = 0
    number: int = 0
    passes: int = 1


ONLY = PassNumber()


class PatchSynthesis:
    """One pass of patch-by-patch synthesis.

    Windows may be left out: with `inside_only` those that hold a boundary of labels; with `wanted`, a mask of the
    canvas, those that hold none of its pixels.
    """

    def __init__(
        self, settings: PatchSettings, exemplars: Exemplars, canvas: Canvas, inside_only: bool = False,
        wanted: Mask | None = None, turn: PassNumber = ONLY,
    ) -> None:  # fmt: skip
        self.settings, self.exemplars, self.canvas, self.turn = settings, exemplars, canvas, turn
        self.layout = settings.layout(canvas)
        self.features = features(exemplars, settings.weights, settings.structure)
        begun = () if canvas.start is None else canvas.start.poses
        poses = settings.poses(canvas.guide)
        self.variants = posed_exemplars(exemplars, self.features, poses, self.layout.patch, begun)
        rim = settings.rim if canvas.rim is None else canvas.rim
        listed = settings.listed if self.layout.places is None or rim else max(settings.listed, AROUND_HOLES)
        self.finder = self._finder(listed)
        prices = patch_saliency(self.features, self.finder) if settings.usage else None
        self.repetition = settings.rule(self.finder, self.layout, settings.usage, prices)
        self.growing = MapBuilder.begin(self.variants, canvas, rim)
        windows = self.growing.open_windows(self.layout, wanted)
        self.guided = self._guided()
        if self.guided is not None and self.guided.guidance.guide.is_labels:
            self.repetition.apart(self.guided.guidance.groups(self.finder))
        if inside_only and self.guided is not None:
            windows &= ~self.guided.guidance.boundaries
        self.windows, self.waves = windows, window_batches(self.layout, windows)
        if settings.rule.in_turn:
            self.waves = [[window] for window in sorted(w for wave in self.waves for w in wave)]
        if canvas.start is not None:
            self.repetition.note_start(self.growing.variant, self.growing.yx)

    def _finder(self, listed: int) -> Search:
        settings, patch = self.settings, self.layout.patch
        if settings.finder is not None:
            return settings.finder(settings, self.variants, patch, listed)
        return PatchSearch(self.variants, patch, min(settings.overlap), settings.search == "exact", listed)

    def _guided(self) -> guiding.GuidedSearch | None:
        """Return the search under the canvas's guide, None without one."""
        guide = self.canvas.guide
        if guide is None:
            return None
        what = guiding.WindowGuide(
            guide, self.variants, self.layout, self.canvas.wrap, isometry_ids(self.settings.isometries)
        )
        unit = guiding.seam_unit(self.exemplars[0], self.settings.weights)
        if self.settings.guided is not None:
            return self.settings.guided(self.finder, what, unit)
        assert isinstance(self.finder, PatchSearch), "methods with a search of their own say how it follows a guide"
        return guiding.GuidedSearch(self.finder, what, unit)

    def at_boundary(self, window: Window) -> bool:
        """Return whether a window holds a boundary between labels of the guide."""
        return self.guided is not None and bool(self.guided.guidance.boundaries[window])

    def fill(self, seed: int, stage: int, run: Run, join: Join, choose: Choose | float) -> None:
        """Fill all windows in batches of disjoint windows, which run in parallel.

        `seed`, `stage`: counters of the random numbers. `join` places the chosen patch in a window. `choose` picks
        among the candidates of a window, in a fixed order; a number stands for a draw among those whose price is within
        this tolerance of the best.
        """
        self._check = run.check
        before, total = self.turn.number * len(self.waves), self.turn.passes * len(self.waves)

        def joined(part: list[tuple[Window, Pick, Candidates]]) -> None:
            for item in part:
                join(*item)

        with run.pool() as each:
            for number, wave in enumerate(self.waves):
                run.tick(before + number, total, self.draft)
                self.repetition.account()
                found = self._search(wave, each, run.workers)
                bits = draw_many(seed, stage + self.turn.stage, 0, wave)
                picks = self._picks(wave, found, bits, choose)
                chosen, size = list(zip(wave, picks, found, strict=True)), -(-len(wave) // run.workers)
                parts = [chosen[k : k + size] for k in range(0, len(wave), size)]
                each(joined, parts)
        run.tick(before + len(self.waves), total, self.draft)

    def cutting(self, seam: str = "difference") -> Join:
        """Return the function that joins patches along the cheapest seam, by the seam cost of this name."""
        price = self.seam_price(seam)
        return lambda window, pick, found: self.growing.cut_in(self.at(window), pick, found, price)

    def seam_price(self, seam: str) -> SeamPrice:
        """Return the seam cost that the parameter `seam` names: ``difference``, ``gradient`` or ``sharp``."""
        return SeamPrice(seam == "gradient", seam_threshold(self.variance(seen=True)) if seam == "sharp" else 0)

    def variance(self, seen: bool = False) -> int:
        """Return the sum of the channels' variances over usable pixels, of the exemplar that varies most.

        `seen`: without the channels that are used in the search only (outlines and slow colour).
        """
        n = self.variants.channels - (self.features.structure if seen else 0)
        return max(variance(p[..., :n], e.usable) for p, e in zip(self.features.pictures, self.exemplars, strict=True))

    def map(self, blend: Blend) -> SourceMap:
        """Return the source map."""
        return self.growing.map(self.exemplars, self.canvas, blend)

    def draft(self) -> SourceMap:
        """Return a copy of the unfinished source map."""
        now = self.map(Blend())
        return replace(now, yx=now.yx.copy())

    def at(self, window: Window) -> Pair:
        """Return the first pixel of a window on the canvas."""
        return self.layout.at(*window)

    def _search(self, wave: list[Window], each: Any, workers: int) -> list[Candidates]:
        found: list[Any] = [None] * len(wave)
        parts = max(workers if len(wave) >= workers else 1, -(-len(wave) // self.finder.batch()))
        size = -(-len(wave) // parts)
        at: Int64 = np.array([self.at(w) for w in wave], np.int64)

        def part(begin: int) -> None:
            self._check()
            stop, prices = min(begin + size, len(wave)), self.repetition.search_prices
            where = self.growing.grown, at[begin:stop]
            if self.guided is not None:
                found[begin:stop] = self.guided.find(wave[begin:stop], *where, prices)
            else:
                found[begin:stop] = self.finder.find(*where, prices)

        each(part, range(0, len(wave), size))
        return list(map(self.weighed, wave, found))

    def weighed(self, window: Window, found: Candidates) -> Candidates:
        """Return the candidates reordered: locked pixels at the edge of holes count as much as all the rest."""
        if self.layout.places is None:
            return found
        here = index_of(*self.at(window), self.layout.patch, self.layout.size)
        spots, ends = edge_cells(self.growing.locked[here], found.known)
        if not len(spots):
            return found
        rows = found.rows.copy()
        weigh_edge(found.feats, int(found.known.sum()), spots, ends, self.variants.posed, rows)
        return replace(found, rows=nearest(rows))

    def _picks(
        self, wave: list[Window], found: list[Candidates], bits: list[int], choose: Choose | float
    ) -> list[Pick]:
        """Return the patches chosen for the windows of a batch, in their order; each choice is recorded as a use."""
        every = list(zip(wave, found, bits, strict=True))
        # Where there is no candidate nothing is known yet: any patch fits.
        free = {w: random_patch(self._valid(w), drawn) for w, of, drawn in every if not len(of.rows)}
        if not callable(choose) and self.layout.places is None and not len(self.repetition.started):
            ready = [replace(of, rows=np.array([(0, *free[w])])) if w in free else of for w, of, _ in every]
            return self.repetition.pick_all(wave, ready, choose, bits)  # handles windows of a grid only
        picks = []
        for w, of, drawn in every:
            if w in free:
                picks.append(free[w])
            elif callable(choose):
                picks.append(choose(w, of, drawn))
            else:
                picks.append(self.repetition.pick(*w, of, choose, drawn))
            self.repetition.add(*w, picks[-1])
        return picks

    def _valid(self, window: Window) -> Sequence[Array]:
        """Return, for every variant, a mask of the first pixels of patches that a window may take."""
        return self.variants.valid if self.guided is None else self.guided.allowed_at(window)


def decided(method: Any, exemplars: Exemplars, guide: Guide | None, patch: Callable[[], int]) -> Any:
    """Return a method with patch, overlap and isometries set; `patch` returns the default side without a guide, px."""
    side = method.patch
    if side is AUTO:
        side = patch() if guide is None else guiding.guided_patch(exemplars, guide)
    rows, columns = extent(side)
    isometries = resolved_isometries(method.isometries, exemplars, (rows, columns))
    check_patch(side, exemplars, isometries)
    if guide is not None:
        guiding.check_guide(exemplars, guide, side)
    third = (rows // 3, columns // 3) if rows != columns else rows // 3
    overlap = third if method.overlap is AUTO else method.overlap
    return replace(method, patch=side, overlap=overlap, isometries=isometries)
