"""Growing under a guide: classes of windows, the joined cost against a slow search, and what comes out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import intarsia as ia
from intarsia.kernels.maps import PartialMap
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas, Guide
from intarsia.model.image import Kind, Plane
from intarsia.model.sourcemap import HOLE
from intarsia.patches.patch_synthesis import PatchSettings, PatchSynthesis, stray_pixels
from intarsia.published.multrus2003.guided_search import GuidedPatchSearch
from intarsia.published.multrus2003.pyramid import GuidedPyramid, PyramidSearch
from intarsia.search.guide import ONE, label_sets, pure_patch, seam_unit
from intarsia.testing.cases import texture

Pixels = NDArray[Any]
METHODS = [
    ia.ImageQuilting(patch=16, overlap=5),
    ia.PatchSampling(patch=10, overlap=3),
    ia.PatchSampling(patch=8, overlap=4, pyramid="mean", isometries="both"),
]
"""The last as in the source's figure 5.6: labels, pyramid and isometries together."""
BOTH = pytest.mark.parametrize("method", METHODS, ids=["image-quilting", "patch-sampling", "with-a-pyramid"])


def labels(pixels: Pixels) -> Plane:
    return Plane(pixels.astype(np.uint8), Kind.LABEL)


def regions(height: int, width: int, count: int = 2) -> Pixels:
    """Wavy stripes of labels 0, 1, ... from top to bottom."""
    y, x = np.mgrid[:height, :width]
    band = (y + 4 * np.sin(x / 9)) * count // height
    return np.clip(band, 0, count - 1).astype(np.uint8)


def painted(marks: Pixels, seed: int = 0) -> Exemplar:
    """A texture whose brightness tells the label."""
    grain = texture(*marks.shape, 3, seed).astype(int) // 4
    return Exemplar.of((grain + 60 * marks[:, :, None].astype(int)).astype(np.uint8))


def disc(size: int = 80, inner: int = 1, outer: int = 0) -> Pixels:
    y, x = np.mgrid[:size, :size] - size // 2
    return np.where(y * y + x * x < (size * 0.3) ** 2, inner, outer).astype(np.uint8)


def got(smap: Any, *marks: Pixels) -> Pixels:
    """The label of every output pixel, by where it comes from."""
    out = np.zeros(smap.yx.shape[:2], int)
    for n, m in enumerate(marks):
        mine = smap.numbers == n
        out[mine] = m[smap.yx[mine][:, 0], smap.yx[mine][:, 1]]
    return out


def agreement(smap: Any, target: Pixels, *marks: Pixels) -> float:
    return float((got(smap, *marks) == target).mean())


class TestClasses:
    @pytest.mark.parametrize("patch", [(1, 1), (3, 5), (6, 6), (20, 9)])
    def test_label_sets_are_those_of_every_window(self, patch: tuple[int, int]) -> None:
        ids = np.random.default_rng(1).integers(-1, 4, (20, 23)) * (np.arange(23) > 8)
        found = label_sets(ids, patch)
        for y, x in np.ndindex(20 - patch[0] + 1, 23 - patch[1] + 1):
            held = set(ids[y : y + patch[0], x : x + patch[1]].ravel().tolist()) - {-1}
            assert found[y, x] == sum(1 << k for k in held)

    @pytest.mark.parametrize("wrap", ["none", "both"])
    def test_windows_know_the_labels_of_the_canvas(self, wrap: str) -> None:
        marks, target = regions(40, 50, 3), regions(33, 41, 3)
        canvas = Canvas(33, 41, ia.Wrap(wrap), guide=Guide(labels(marks), labels(target)))
        growth = PatchSynthesis(PatchSettings((12, 12), (4, 4), hangs=1), [painted(marks)], canvas)
        for r, c in np.ndindex(growth.layout.shape):
            rows, columns = (np.arange(at, at + 12) for at in growth.layout.at(r, c))
            if wrap == "none":
                rows, columns = rows[(rows >= 0) & (rows < 33)], columns[(columns >= 0) & (columns < 41)]
            held = set(target[np.ix_(rows % 33, columns % 41)].ravel().tolist())
            assert growth.guided.guidance.windows[r, c] == sum(1 << k for k in held)
            assert growth.at_boundary((r, c)) == (len(held) > 1)

    def test_a_window_takes_patches_of_its_own_set(self) -> None:
        marks = regions(60, 60, 3)
        guide = Guide(labels(marks), labels(regions(60, 60, 3)))
        growth = PatchSynthesis(PatchSettings((10, 10), (3, 3)), [painted(marks)], Canvas(60, 60, guide=guide))
        every = label_sets(marks.astype(int), (10, 10))
        for held, (allowed,) in growth.guided.allowed.items():
            assert np.array_equal(allowed, every == held)
        (none,) = growth.guided.guidance.allowed(0b101)  # labels 0 and 2 never meet: only what holds nothing else
        assert np.array_equal(none, (every == 1) | (every == 4))

    def test_labels_turn_with_the_pixels(self) -> None:
        marks = regions(30, 41, 3)
        guide = Guide(labels(marks), labels(regions(30, 30, 3)))
        growth = PatchSynthesis(
            PatchSettings((8, 8), (2, 2), isometries="both"), [painted(marks)], Canvas(30, 30, guide=guide)
        )
        pictures = growth.guided.guidance.pictures
        for v in range(8):
            _, height, width, _ = pictures.table[v].tolist()
            yx = np.stack(np.mgrid[:height, :width], axis=2).astype(np.int32)
            there, _, _ = pictures.to_exemplars(yx, np.full((height, width), v, np.uint8))
            shown = pictures.picture(v)
            assert np.array_equal(shown.argmax(axis=2), marks[there[:, :, 0], there[:, :, 1]])
            assert set(np.unique(shown).tolist()) == {0, ONE}


class Scene:
    """A window of random pixels under a boundary, and a slow search of every patch."""

    def __init__(self, weight: float, search: str, isometries: str = "none") -> None:
        rng = np.random.default_rng(5)
        self.marks = (rng.random((8, 9)).repeat(5, 0).repeat(5, 1) > 0.5).astype(np.uint8)
        self.target = np.zeros((12, 12), np.uint8)
        self.target[:, 5:] = self.target[8:, 3:] = 1
        exemplar = painted(self.marks)
        guide = Guide(labels(self.marks), labels(self.target), weight)
        way = "fast" if search == "fast" else "exact"
        settings = PatchSettings((12, 12), (4, 4), isometries=isometries, search=way)
        if search == "roots":
            settings = replace(settings, guided=GuidedPatchSearch)
        if search == "pyramid":
            settings = replace(
                settings, guided=GuidedPyramid,
                finder=lambda its, laid, patch, listed: PyramidSearch(laid, patch, its.overlap, "mean", 8, listed),
            )  # fmt: skip
        self.growth = PatchSynthesis(settings, [exemplar], Canvas(12, 12, guide=guide))
        self.unit = round(1023**2 * (0.30 + 0.59 + 0.11) / 0.59)  # the range in every channel, as channels count
        self.weight, self.published = weight, search in ("roots", "pyramid")
        for array, top in ((self.growth.growing.yx[:, :, 0], 40), (self.growth.growing.yx[:, :, 1], 45)):
            array[:] = rng.integers(0, top, (12, 12))
        self.growth.growing.variant[:] = 0
        self.growth.growing.variant[4:, 4:] = HOLE

    @property
    def guided(self) -> Any:
        return self.growth.guided

    def found(self) -> Any:
        work = self.growth.growing
        shows, at = PartialMap(work.variant, work.yx, self.growth.layout.wraps), np.zeros((1, 2), np.int64)
        return self.guided.find([(0, 0)], shows, at, self.growth.repetition.search_prices)[0]

    def cost(self, v: int, u: int, s: int) -> float:
        """d**2 + (alpha g)**2, or as published (d + alpha g)**2, in the units of the search, by the definition."""
        work, variants = self.growth.growing, self.growth.variants
        seam, n = 0, 0
        for i, j in np.argwhere(work.variant != HOLE).tolist():
            a = variants.picture(work.variant[i, j])[tuple(work.yx[i, j])].astype(int)
            seam += int(((a - variants.picture(v)[u + i, s + j].astype(int)) ** 2).sum())
            n += 1
        shown = self.guided.guidance.pictures.picture(v)[u : u + 12, s : s + 12, 0] // ONE
        g = np.sqrt((shown != self.target).mean())
        d, g = np.sqrt(seam / (n * self.unit)), self.weight * g
        return float(((d + g) ** 2 if self.published else d * d + g * g) * n * self.unit)


class TestCost:
    def test_a_seam_of_1_is_the_full_range_in_every_channel_as_channels_count(self) -> None:
        """What alpha is relative to does not depend on the picture, but on what a channel counts."""
        gray, colour = Exemplar.of(texture(20, 20, 1)), Exemplar.of(texture(20, 20, 3) // 3)
        assert seam_unit(gray, None) == 1023**2
        assert seam_unit(colour, None) == round(1023**2 * (0.30 + 0.59 + 0.11) / 0.59)
        assert seam_unit(colour, (2.0, 1.0, 1.0)) == 1023**2 * 2
        assert seam_unit(Exemplar.of(labels(disc(20))), None) == 1023**2

    @pytest.mark.parametrize("weight", [0.0, 0.3, 2.0, 100.0])
    @pytest.mark.parametrize("isometries", ["none", "both"])
    @pytest.mark.parametrize("search", ["exact", "roots", "pyramid"])
    def test_candidates_cost_seam_and_labels_together(self, weight: float, isometries: str, search: str) -> None:
        scene = Scene(weight, search, isometries)
        rows = scene.found().rows
        assert len(rows) == 16
        for cost, v, u, s in rows.tolist():
            assert abs(cost - scene.cost(v, u, s)) <= 1 + 1e-9 * cost
            assert scene.guided.allowed[0b11][v][u, s]

    @pytest.mark.parametrize("weight", [0.3, 2.0, 100.0])
    @pytest.mark.parametrize(("search", "among"), [("exact", 1), ("fast", 5), ("pyramid", 5)])
    def test_the_best_of_all_is_found(self, weight: float, search: str, among: int) -> None:
        scene = Scene(weight, search)
        (allowed,) = scene.guided.allowed[0b11]
        every = sorted(scene.cost(0, int(u), int(s)) for u, s in zip(*np.nonzero(allowed), strict=True))
        best = scene.found().rows[0, 0]
        assert best <= every[among - 1] * 1.0001 + 1

    def test_where_nothing_is_known_labels_alone_decide(self) -> None:
        scene = Scene(2.0, "exact")
        scene.growth.growing.variant[:] = HOLE
        marks = np.lib.stride_tricks.sliding_window_view(scene.marks, (12, 12))
        wrong, (allowed,) = (marks != scene.target).sum(axis=(2, 3)), scene.guided.allowed[0b11]
        assert wrong[tuple(scene.found().rows[0, 2:])] == wrong[allowed].min()


class TestRefusals:
    def test_what_does_not_fit(self) -> None:
        marks, e = regions(40, 40), painted(regions(40, 40))
        plane, normals = labels(marks), Plane(np.zeros((4, 4, 3)), Kind.NORMAL)
        for make, words in [
            (lambda: Guide(plane, labels(marks + 5)), "asks for 5, 6, which is in no label picture; paint with 0, 1"),
            (lambda: Guide(plane, Plane(marks)), "differ in kind"),
            (lambda: Guide(plane, plane, -1), "weight=-1"),
            (lambda: Guide(plane, plane, reach=-1), "reach=-1"),
            (lambda: Guide([], plane), "no source"),
            (lambda: Guide(normals, normals), "normals"),
            (lambda: ia.synthesize(e, 50, METHODS[0], guide=Guide(plane, plane)), "target is 40x40 px, the canvas"),
            (lambda: ia.synthesize(e, None, METHODS[0], guide=Guide([plane, plane], plane)), "2 source pictures for 1"),
            (lambda: ia.synthesize(e, None, METHODS[0], guide=Guide(labels(marks[:30]), plane)), "source is 40x30 px"),
        ]:  # fmt: skip
            with pytest.raises(ia.InputError, match=words):
                make()

    @BOTH
    def test_a_label_needs_a_patch_of_its_own(self, method: Any) -> None:
        marks = np.zeros((60, 60), np.uint8)
        marks[20:29, :] = 7
        e, guide = painted(marks // 7), Guide(labels(marks), labels(marks))
        with pytest.raises(ia.InputError, match=r"wholly in label 7; choose a patch of at most 9 px"):
            ia.synthesize(e, None, method, guide=guide)
        assert pure_patch([e], guide) == 9
        out = ia.synthesize(e, None, type(method)(), guide=guide)  # the automatic patch is small enough
        assert agreement(out.map, marks, marks) > 0.9

    def test_masked_patches_do_not_count(self) -> None:
        marks = regions(60, 60)
        usable = marks == 0
        usable[50:, :] = True
        e = Exemplar.of(painted(marks).base, usable=usable)
        with pytest.raises(ia.InputError, match="at most 10 px"):
            ia.synthesize(e, None, METHODS[0], guide=Guide(labels(marks), labels(disc())))

    def test_too_many_labels(self) -> None:
        marks = np.arange(40 * 40).reshape(40, 40) % 40
        with pytest.raises(ia.InputError, match="40 labels; at most 32"):
            ia.synthesize(painted(marks % 2), None, METHODS[0], guide=Guide(labels(marks), labels(marks)))


class TestStrays:
    def test_a_patch_of_wrong_pixels_is_judged_by_its_deepest(self) -> None:
        target = (np.arange(20) >= 10) * np.ones((20, 1), np.int16)
        found = target.copy()
        found[2:4, 10:13] = 0  # 3 px deep
        found[8:10, 10:17] = 0  # 7 px deep
        beside = np.ones((3, 3), bool)
        assert np.argwhere(stray_pixels(found, target, 4, beside))[:, 0].tolist() == [8] * 7 + [9] * 7
        assert not stray_pixels(found, target, 7, beside).any()
        assert np.array_equal(stray_pixels(found, target, 7, np.eye(3, dtype=bool)), found != target)
        assert not stray_pixels(target, target, 0, beside).any()
