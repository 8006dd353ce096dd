"""Patch search under a guide of labels or target pictures (Multrus 2003, 5.3).

A guide is a target picture of the canvas and a source picture of each exemplar. With labels, windows inside one region
of the target take patches that lie wholly in that label; windows on a boundary take patches that hold the same labels
(Multrus 2003, 5.3: the sets G1, G2 and G3, here for any number of labels).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..analysis import running_sums, valid_windows, window_sums
from ..analysis.elements import element_size
from ..analysis.features import RANGE, as_integers, channel_shares, features, robust_range, transformed
from ..foundation import InputError, ndimage
from ..foundation.arrays import Array, Pair
from ..foundation.geometry import Wrap
from ..foundation.params import extent
from ..kernels.maps import PartialMap
from ..model import Exemplar, Exemplars
from ..model.canvas import MAX_LABELS, Guide
from ..model.image import Kind, Plane
from . import (
    LARGEST_SHARE,
    LEAST,
    Candidates,
    PosedExemplars,
    Prices,
    Search,
    WindowGrid,
    default_patch,
    fourier_kernels,
    patch_for_element,
)
from .fourier import STEPS, PatchSearch, most_steps
from .fourier_kernels import FAR

MOST = float(1 << 30)  # largest cost of the guide in the short-list, so that all costs stay below 2**31


class GuideSearch(PatchSearch):
    """A search that compares the guide: every channel of its reduced pictures is one channel of the guide."""

    def _reduction(self) -> tuple[Array, Array, float, int]:
        channels = self.variants.channels
        clip = min(STEPS, most_steps(self.patch, self.cells, channels))
        scale = 2.0 * clip / ONE
        axes = np.rint(np.eye(channels) * scale * (1 << 24)).astype(np.int64)
        return np.full(channels, ONE // 2, np.int64), axes, scale, clip


class GuidedSearch:
    """Searches patches for windows under a guide: the short-list is ordered by the sum of seam and guide costs.

    `search` finds patches that fit the known pixels: a PatchSearch, or another search with its method ``within``;
    `unit`: the squared difference of one pixel over the full range of the exemplars (:func:`seam_unit`).
    """

    def __init__(self, search: Any, guidance: WindowGuide, unit: int) -> None:
        self.guidance = guidance
        self.ratio = unit / guidance.unit
        self.guide = self._beside(search)
        self.allowed = {s: guidance.allowed(s) for s in np.unique(guidance.windows).tolist()}
        self.among: dict[int, Any] = {s: search.within(valid) for s, valid in self.allowed.items()}

    def _beside(self, search: Any) -> Any:
        """Return the search that compares the guide."""
        return GuideSearch(self.guidance.pictures, search.patch, 0, factor=search.factor)

    def allowed_at(self, window: Pair) -> list[Array]:
        """Return, for every variant, a mask of the first pixels of patches that a window may take."""
        return self.allowed[int(self.guidance.windows[window])]

    def find(self, windows: list[Pair], grown: PartialMap, at: Array, prices: Prices) -> list[Candidates]:
        """Return the candidates for `windows` of the grid, which begin at `at` (n, 2) of a map under synthesis."""
        labels = [int(self.guidance.windows[w]) for w in windows]
        found: list[Any] = [None] * len(windows)
        for s in sorted(set(labels)):
            mine = np.array([k for k, own in enumerate(labels) if own == s])
            if self.guidance.guide.weight > 0 and not (s and s & (s - 1) == 0):
                some = self._weighed(self.among[s], grown, at[mine], prices)
            else:  # inside the region of one label all patches of it follow the guide equally
                some = self.among[s].find(grown, at[mine], prices)
            for k, candidates in zip(mine.tolist(), some, strict=True):
                found[k] = candidates
        return found

    def _weighed(self, search: Any, grown: PartialMap, at: Array, prices: Prices) -> list[Candidates]:
        """Return candidates by the sum of seam and guide distances, both computed from correlations."""
        feats, known = search.variants.windows(grown, at, search.patch)
        wanted, inside = self.guidance.wanted(at)
        shares, guide = self.shares(known, inside), self.guide
        pixels, over = search.reduce(feats, known), guide.reduce(wanted, inside)
        most = 4.0 * guide.clip**2 * len(guide.axes) * guide.cells[0] * guide.cells[1]
        weights = np.minimum((shares * search.scale / guide.scale) ** 2, MOST / most)[:, None, None]
        both, usual = {}, np.full(len(at), -1, np.int64)
        for v, (rows, columns) in enumerate(valid.shape for valid in search.valid):
            if rows and columns:
                seams, labels = (some.correlations(v, of)[:, :rows, :columns]
                                 for some, of in ((search, pixels), (guide, over)))  # fmt: skip
                search.short_list(pixels, {v: seams}, prices, usual)  # computes `usual`, of seams alone
                apart = over.squares[v][over.slots] + over.energies[:, None, None] - 2.0 * np.rint(labels)
                # In a distance the correlation counts -2, so half of the guide cost is subtracted from it.
                both[v] = np.maximum(np.rint(seams) - np.rint(weights * apart / 2.0), 1.0 - MOST / 2.0)
        best, counts, _ = search.short_list(pixels, both, prices, usual)
        return [
            Candidates(
                self.measured(search, (feats[k], known[k], wanted[k], inside[k]), shares[k], best[k, : counts[k]]),
                search.full(int(usual[k])), feats[k], known[k],
            )
            for k in range(len(at))
        ]  # fmt: skip

    def measured(self, search: Any, window: tuple[Array, Array, Array, Array], share: float, coarse: Array) -> Array:
        """Return coarse candidates (n, 4), each moved to the cheapest position around it, measured exactly, best first.

        Positions up to a cell less 1 px away along each axis are compared; equal results are merged. `window`: features
        and known mask, the guide, and the mask of where the window lies on the canvas.
        """
        feats, known, wanted, inside = window
        beyond = search.factor - 1
        apart = np.mgrid[-beyond : beyond + 1, -beyond : beyond + 1].reshape(2, -1).T
        rows = np.repeat(coarse[:, None], len(apart), axis=1)
        rows[:, :, 0], rows[:, :, 2:] = FAR, rows[:, :, 2:] * search.factor + apart
        begin, *size = search.offsets[rows[:, :, 1]].transpose(2, 0, 1)
        y, x = rows[:, :, 2], rows[:, :, 3]
        there = (y >= 0) & (x >= 0) & (y < size[0]) & (x < size[1])
        there[there] = search.flat_valid[(begin + y * size[1] + x)[there]] > 0
        seams = rows[there]
        labels = seams.copy()
        fourier_kernels.measure(feats, known, search.variants.posed, seams)
        fourier_kernels.measure(wanted, inside, self.guidance.pictures.posed, labels)
        rows[there, 0] = self.cost(seams[:, 0], labels[:, 0], share)
        rows = rows[np.arange(len(rows)), rows[:, :, 0].argmin(axis=1)]
        return np.unique(rows[rows[:, 0] < FAR], axis=0)

    def cost(self, seams: Array, labels: Array, share: float) -> Array:
        """Return the costs (n,): squared seam distances plus squared `share` times squared guide distances."""
        return np.asarray(seams + np.rint(share * share * labels).astype(np.int64))

    def shares(self, known: Array, inside: Array) -> Array:
        """Return the factor of the guide's distance (not squared) for each window.

        The cost is d**2 + (weight * g)**2, where d**2 is the mean squared seam difference over the n known pixels of
        the window and g**2 that of the guide over its A pixels on the canvas, both relative to their unit. Costs are
        computed as sums, larger by n and the unit of seams, so the factor is weight * sqrt(n / A * ratio of the units).
        Where nothing is known, n = A.
        """
        area = np.maximum(inside.sum(axis=(1, 2), dtype=np.int64), 1)
        count = known.sum(axis=(1, 2), dtype=np.int64)
        count = np.where(count > 0, count, area)
        return np.asarray(self.guidance.guide.weight * np.sqrt(count * self.ratio / area), np.float64)


def seam_unit(exemplar: Exemplar, weights: tuple[float, ...] | None) -> int:
    """Return the squared difference of one pixel that differs by the full range in every channel of the base plane.

    Channels are weighted as in the search. Other planes are not included. The range is that of the exemplar, as
    features are normalised to it.
    """
    base = exemplar.base
    shares = [1.0] if base.kind is Kind.LABEL else channel_shares(base, weights, base.channels)
    return round(RANGE**2 * sum(shares))


ONE = 1020  # value of a guide channel where its label is present, and the full range of a target picture


class WindowGuide:
    """The guide of a canvas for every variant and every window.

    ``pictures``: the sources of the guide, posed and laid out like the variants: one channel for each label of the
    target, ONE where a pixel has it (a single channel for two labels), or the channels of a picture, 0 .. ONE.
    ``unit``: the largest squared difference of one pixel. ``windows`` (rows, columns): the set of labels in each window
    of the layout, as bits; 0 everywhere without labels. ``boundaries`` (rows, columns): which windows hold more than
    one label; all others take patches in the isometries `poses` only.
    """

    def __init__(
        self, guide: Guide, variants: PosedExemplars, layout: WindowGrid, wrap: Wrap,
        poses: tuple[int, ...] = tuple(range(8)),
    ) -> None:  # fmt: skip
        self.guide, self.variants, self.layout, self._poses = guide, variants, layout, poses
        sources, target = codes_of(guide, wrap)
        channels, there = target.shape[2], np.ones(target.shape[:2], np.int16)
        wide = [layout.widened(channel, 0) for channel in (*np.moveaxis(target, 2, 0), there)]
        self._under = np.lib.stride_tricks.sliding_window_view(np.stack(wide, axis=2), layout.patch, (0, 1))
        self.unit = (min(channels, 2) if guide.is_labels else channels) * ONE * ONE
        self.pictures = variants.showing(sources)
        self.windows = np.zeros((len(layout.rows), len(layout.columns)), np.int64)
        self._held: list[Array] = []
        if guide.is_labels:
            ids = [numbered_labels(s, guide.names) for s in guide.sources]
            for v in range(len(variants)):
                posed = transformed(ids[variants.exemplar[v]], int(variants.pose[v]))
                self._held.append(label_sets(_padded(posed, variants.toroidal[v], layout.patch), layout.patch))
            self.windows = layout.of_windows(
                label_sets(layout.widened(numbered_labels(guide.target, guide.names), -1), layout.patch)
            )
        self.boundaries: Array = self.windows & (self.windows - 1) != 0

    def allowed(self, labels: int) -> list[Array]:
        """Return, for every variant, the first pixels of patches that a window with these labels (bits) may take.

        For several labels, patches of exactly these labels in any isometry; if there are none, or for a single label,
        patches without any other label, in the isometries `poses`. Without labels, all patches in `poses`.
        """
        valid = list(self.variants.valid)
        if labels & (labels - 1):
            same = [ok & (held == labels) for ok, held in zip(valid, self._held, strict=True)]
            if any(s.any() for s in same):
                return same
        posed = zip(valid, self.variants.pose.tolist(), strict=True)
        valid = [ok if pose in self._poses else np.zeros_like(ok) for ok, pose in posed]
        if not labels:
            return valid
        return [ok & (held & ~labels == 0) for ok, held in zip(valid, self._held, strict=True)]

    def groups(self, search: Search) -> Array:
        """Return the group of every coarse position of all variants, flat: those of patches with the same labels."""
        every = []
        for valid, held in zip(search.valid, self._held, strict=True):
            rows, columns = (np.minimum(np.arange(n) * search.factor, size - 1)
                             for n, size in zip(valid.shape, held.shape, strict=True))  # fmt: skip
            every.append(held[np.ix_(rows, columns)].ravel())
        return np.unique(np.concatenate(every), return_inverse=True)[1]

    def wanted(self, at: Array) -> tuple[Array, Array]:
        """Return the guide in the windows that begin at `at`: (n, h, w, C) int16, and where the canvas is."""
        under = self._under[tuple((at + self.layout.patch).T)]
        return np.ascontiguousarray(np.moveaxis(under[:, :-1], 1, 3)), under[:, -1].astype(np.uint8)


def label_sets(ids: Array, patch: Pair) -> Array:
    """Return the set of labels, as bits, in each window of a picture of label numbers; -1 is no label."""
    out = np.zeros([max(n - side + 1, 0) for n, side in zip(ids.shape, patch, strict=True)], np.int64)
    if not out.size:
        return out
    for k in range(int(ids.max()) + 1):
        out |= (window_sums(ids == k, patch, np.int32) > 0).astype(np.int64) << k
    return out


def check_guide(exemplars: Exemplars, guide: Guide, patch: int | Pair) -> None:
    """Raise InputError for a guide that does not match its exemplars, or a label without a patch wholly inside it."""
    check_sources(exemplars, guide)
    missing = _without_pure_patch(exemplars, guide, extent(patch))
    if missing:
        rows, columns = extent(patch)
        largest = pure_patch(exemplars, guide)
        remedy = f"choose a patch of at most {largest} px" if largest else "mark larger regions beside the exemplar"
        described = " and ".join(f"{e.name} ({e.width}x{e.height} px)" for e in exemplars[:4])
        raise InputError(
            f"no patch of {columns}x{rows} px of {described} lies wholly in label "
            f"{', '.join(map(guide.name_of, missing[:8]))}; {remedy}."
        )


def check_sources(exemplars: Exemplars, guide: Guide) -> None:
    """Raise InputError for source pictures whose number or sizes differ from the exemplars', or for too many labels."""
    if len(guide.sources) != len(exemplars):
        raise InputError(
            f"the guide has {len(guide.sources)} source pictures for {len(exemplars)} exemplars; give one for each."
        )
    for source, e in zip(guide.sources, exemplars, strict=True):
        if (source.height, source.width) != (e.height, e.width):
            raise InputError(
                f"the guide's source is {source.width}x{source.height} px, {e.name} {e.width}x{e.height}; "
                "make them equal."
            )
    if len(guide.names) > MAX_LABELS:
        raise InputError(f"the target has {len(guide.names)} labels; at most {MAX_LABELS} are possible.")


def pure_patch(exemplars: Exemplars, guide: Guide) -> int:
    """Return the largest side, px, at which every label has a square patch wholly inside it; 0: there is none."""
    return min(0 if found is None else found[3] for found in largest_squares(exemplars, guide))


def guided_patch(exemplars: Exemplars, guide: Guide) -> int:
    """Return a patch side in px under a guide: with labels, the largest that the elements of any region ask for.

    Elements of a region are measured in the largest square of its label. The patch is at most 0.6 of the smallest of
    these squares, so that there is a choice of patches for every label. Without labels the default patch.
    """
    if not guide.is_labels:
        return default_patch(exemplars)
    check_sources(exemplars, guide)
    sizes, sides = [], []
    for found in largest_squares(exemplars, guide):
        if found is not None:
            number, y, x, side = found
            picture = features([exemplars[number]]).pictures[0][y : y + side, x : x + side]
            sizes.append(patch_for_element(element_size(np.ascontiguousarray(picture), None).size, side))
            sides.append(max(int(LARGEST_SHARE * side), min(side, 3)))
    return min(max(sizes), *sides) if sizes else LEAST


def largest_squares(exemplars: Exemplars, guide: Guide) -> list[tuple[int, int, int, int] | None]:
    """Return for every label its largest usable square: exemplar, row, column, side; None: it has no pixel."""
    best: list[tuple[int, int, int, int] | None] = [None] * len(guide.names)
    if not guide.is_labels:
        return best
    for number, (e, source) in enumerate(zip(exemplars, guide.sources, strict=True)):
        ids = numbered_labels(source, guide.names)
        for k in range(len(guide.names)):
            mine = ids == k if e.usable is None else (ids == k) & e.usable
            y, x, side = _largest_square(mine)
            before = best[k]
            if side > (0 if before is None else before[3]):
                best[k] = (number, y, x, side)
    return best


def _largest_square(mine: Array) -> tuple[int, int, int]:
    """Return first row, first column and side of a largest square of True."""
    low, high, at = 0, min(mine.shape), (0, 0)
    total = running_sums(mine)  # once for all sizes
    while low < high:  # bisection, as every square contains smaller ones
        n = (low + high + 1) // 2
        full = total[n:, n:] - total[:-n, n:] - total[n:, :-n] + total[:-n, :-n] == n * n
        if full.any():
            low, at = n, divmod(int(full.argmax()), full.shape[1])
        else:
            high = n - 1
    return at[0], at[1], low


def _without_pure_patch(exemplars: Exemplars, guide: Guide, patch: Pair) -> list[int]:
    if not guide.is_labels:
        return []
    every = [(e, numbered_labels(source, guide.names)) for e, source in zip(exemplars, guide.sources, strict=True)]

    def there(k: int, e: Exemplar, ids: Array) -> bool:
        mine = (ids == k) & e.free
        beyond = [n + (side - 1) * e.toroidal for n, side in zip(mine.shape, patch, strict=True)]
        return bool(valid_windows(tuple(beyond), mine, e.toroidal, patch).any())

    return [name for k, name in enumerate(guide.names) if not any(there(k, *one) for one in every)]


def numbered_labels(plane: Plane, names: tuple[int, ...]) -> Array:
    """Return the labels of a plane as indices into the sorted `names`; other labels get ``len(names)``."""
    pixels = plane.pixels.reshape(plane.height, plane.width).astype(np.int64)
    place = np.searchsorted(names, pixels)
    known = np.append(np.array(names, np.int64), -1)[place] == pixels
    return np.where(known, place, len(names)).astype(np.int16)


def codes_of(guide: Guide, wrap: Wrap) -> tuple[list[Array], Array]:
    """Return the guide as int16 channels of 0 .. ONE: of every exemplar, and of the canvas."""
    planes = [*guide.sources, guide.target]
    if guide.is_labels:
        ids = [numbered_labels(p, guide.names) for p in planes]
        codes = [
            np.stack([_presence(i == k, guide.reach, wrap if n == len(ids) - 1 else Wrap.NONE)
                      for k in range(len(guide.names))], axis=2)
            for n, i in enumerate(ids)
        ]  # fmt: skip
        if len(guide.names) == 2 and not any((i == 2).any() for i in ids):
            codes = [c[:, :, 1:] for c in codes]  # the presence of one of two labels determines that of the other
    else:
        values, _ = as_integers(planes, [None] * len(planes))
        low, high = robust_range(values)
        codes = [
            ((np.clip(v, low, high).astype(np.int64) - low) * ONE // max(high - low, 1)).astype(np.int16)
            for v in values
        ]
    return codes[:-1], codes[-1]


def _presence(mine: Array, reach: int, wrap: Wrap) -> Array:
    """Return ONE inside a region and 0 outside; with a `reach`, a linear ramp over so many px on either side."""
    if not reach or mine.all() or not mine.any():
        return mine.astype(np.int16) * np.int16(ONE)
    pad = [(reach, reach) if closed else (0, 0) for closed in (wrap.y, wrap.x)]
    wide = np.pad(mine, pad, mode="wrap")
    depth = ndimage.distance_transform_edt(wide) - ndimage.distance_transform_edt(~wide)
    soft = np.clip(np.floor((depth / (2 * reach) + 0.5) * ONE + 0.5), 0, ONE).astype(np.int16)
    return np.asarray(soft[pad[0][0] : pad[0][0] + mine.shape[0], pad[1][0] : pad[1][0] + mine.shape[1]])


def _padded(picture: Array, toroidal: bool, patch: Pair) -> Array:
    if not toroidal:
        return picture
    pad = [(0, patch[0] - 1), (0, patch[1] - 1), (0, 0)][: picture.ndim]
    return np.pad(picture, pad, mode="wrap")
