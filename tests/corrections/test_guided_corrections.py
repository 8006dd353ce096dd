"""Painting by corrections: the guide as feature channels, against the plain twin, and what comes out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from corrections.naive_correction import NaiveGuide
from long import going_round
from methods.test_parallel_controllable import BASE, MEMO, ONE, naive
from scipy.ndimage import distance_transform_edt
from search.test_guide import agreement, disc, got, labels, painted, regions

import intarsia as ia
from intarsia.corrections import guide as wanted
from intarsia.corrections.appearance import bordered, stack_of, without_gaps
from intarsia.corrections.guide import EDGE, NEAR, StackGuide, stacked
from intarsia.corrections.parallel_controllable import decided
from intarsia.corrections.coordinate_pyramid import CorrectionParameters, PyramidSynthesis
from intarsia.corrections.span import Span
from intarsia.corrections.stack import ComparisonSettings, exemplar_stack
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas, Guide
from intarsia.model.image import Plane
from intarsia.search.guide import codes_of
from intarsia.testing.cases import noise, same_map, texture

FULL = 1020 * 16
METHOD = ia.ParallelControllable()


def cells(height: int, width: int, count: int, seed: int = 0, size: int = 5) -> Any:
    """Labels in squares of a few px."""
    rough = (noise(height // size + 1, width // size + 1, seed) % np.uint64(count)).astype(np.uint8)
    return np.ascontiguousarray(rough.repeat(size, 0).repeat(size, 1)[:height, :width])


def grown(marks: Any, target: Any, method: Any = METHOD, **given: Any) -> Any:
    """The map of labels painted from a texture whose brightness tells the label."""
    weight, reach = given.pop("weight", 2.0), given.pop("reach", 0)
    guide = Guide(labels(marks), labels(target), weight, reach)
    return ia.synthesize(given.pop("exemplar", painted(marks)), None, method, guide=guide, **given).map


def guides(e: Exemplar, guide: Guide, method: ia.ParallelControllable) -> list[NaiveGuide]:
    """The plain twin's guide: full stacks, and scales that follow from the definition."""
    stack = exemplar_stack(e, ComparisonSettings.of(method))
    (source,), target = codes_of(guide, ia.Wrap.NONE)
    beside = list(stack_of(without_gaps(source, e), stack.count, (e.toroidal, e.toroidal)))
    over = list(stack_of(target, stack.count, (False, False)))
    unit = (min(source.shape[2], 2) if guide.is_labels else source.shape[2]) * FULL**2
    if guide.is_labels and not guide.reach:
        for picture in (beside, over):
            picture[:EDGE] = [np.concatenate([finer, picture[EDGE]], axis=2) for finer in picture[:EDGE]]
    enough, out = unit // 16 if guide.is_labels else int(unit / 16 / max(guide.weight, 1) ** 2), []
    for number in range(stack.count):
        level = stack.levels[min(number, len(stack.levels) - 1)]
        inner = slice(level.border, level.border + e.height), slice(level.border, level.border + e.width)
        may = level.open.reshape(-1, level.stride)[inner] > 0
        table = level.table.reshape(len(may) + 2 * level.border, level.stride, -1)[inner][may].astype(float)
        scale = guide.weight * (2 * ((table - table.mean(axis=0)) ** 2).sum() / len(table) / unit) ** 0.5 * 2**32
        out.append(NaiveGuide(1 << number, beside[number], over[number], round(scale), enough, number < NEAR, may))
    return out


GUIDES = {
    "two labels": (cells(21, 18, 2), cells(9, 11, 2, 3, 4), 0.7),
    "three labels": (cells(21, 18, 3), cells(9, 11, 3, 3, 4), 2.0),
    "no weight": (cells(21, 18, 2), cells(9, 11, 2, 3, 4), 0.0),
    "a picture": (texture(21, 18, 1, 5)[:, :, 0], texture(9, 11, 1, 8)[:, :, 0], 2.0),
}


NEAR_AND_MEMO = [BASE, MEMO]


@pytest.mark.parametrize(
    ("kind", "method", "toroidal"), going_round([*GUIDES], NEAR_AND_MEMO, [True, False])
)
def test_the_kernels_do_what_the_plain_twin_does(kind: str, method: Any, toroidal: bool) -> None:
    """What is asked of the levels, where pixels begin again, and what candidates cost."""
    source, target, weight = GUIDES[kind]
    plane = Plane if kind == "a picture" else labels
    e = Exemplar.of(texture(21, 18, 3, 5), toroidal=toroidal)
    guide = Guide(plane(source), plane(target), weight)
    twin = naive(method, e, 11)
    twin.guides = guides(e, guide, method)
    for level, told in zip(twin.levels, twin.guides, strict=False):
        level.guide = told
    out = method.synthesize([e], Canvas(9, 11, guide=guide), 11, ONE).yx
    assert out.tolist() == [[list(twin.final(y, x)) for x in range(11)] for y in range(9)]
    led = sum(twin.pixel(n, 0, y, x) != twin.pixel(n, -1, y, x) for n, _, y, x in list(twin.known))
    assert led > 0, "nothing began again, so the test shows nothing"


@pytest.mark.parametrize("closed", [False, True])
def test_a_stack_is_read_where_it_is_needed(closed: bool) -> None:
    picture = texture(23, 30, 2, 1).astype(np.int16) * 4
    every = [np.arange(23), np.arange(30)]
    axes = closed, closed
    for level, (a, b) in enumerate(zip(stacked(picture, [every] * 5, axes), stack_of(picture, 5, axes), strict=True)):
        assert np.array_equal(a, b), level
    some = [np.array([22, 0, 7, 7]), np.array([3])]
    for a, b in zip(stacked(picture, [some] * 5, axes), stack_of(picture, 5, axes), strict=True):
        assert np.array_equal(a, b[np.ix_(*some)])


def test_a_wrapped_target_is_blurred_across_its_border_along_that_axis_only() -> None:
    """A turned canvas asks for the turned guide; along an axis that does not wrap it is mirrored."""
    picture, every = texture(24, 30, 1, 1).astype(np.int16), [np.arange(24), np.arange(30)]
    (_, once), (_, moved) = (stacked(p, [every] * 2, (True, False)) for p in (picture, np.roll(picture, 5, 0)))
    assert np.array_equal(np.roll(once, 5, 0), moved)
    across = stacked(np.roll(picture, 5, 1), [every] * 2, (True, False))[1]
    assert not np.array_equal(np.roll(once, 5, 1), across)


def test_what_lies_along_a_boundary_lies_along_the_new_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """A dark rim of 3 px is found along two thirds of a disc, though the exemplar's boundary lies one way only."""
    marks, target = regions(120, 120), disc(120)
    pixels = np.array(painted(marks).base.samples)
    pixels[rim(marks)] = 0
    found = {}
    for edge in (EDGE, 0):
        monkeypatch.setattr(wanted, "EDGE", edge)
        yx = grown(marks, target, exemplar=Exemplar.of(pixels)).yx
        shown = (pixels[yx[..., 0], yx[..., 1]] == 0).all(axis=2)
        assert shown[~rim(target)].mean() < 0.01
        found[edge] = shown[rim(target)].mean()
    assert found[EDGE] > 0.6
    assert found[0] < 0.4, "sharp labels alone do not tell how far a boundary is"


def rim(marks: Any) -> Any:
    return (marks == 1) & (distance_transform_edt(np.pad(marks, 4, mode="edge"))[4:-4, 4:-4] <= 3)


@pytest.mark.parametrize("weight", [0.0, 0.5, 2.0])
def test_regions_lie_where_they_are_painted(weight: float) -> None:
    marks, target = regions(90, 90), disc(90)
    share = agreement(grown(marks, target, weight=weight, seed=3), target, marks)
    assert share > {0.0: 0.9, 0.5: 0.985, 2.0: 0.998}[weight]
    plain = ia.synthesize(painted(marks), 90, METHOD, seed=3).map
    assert agreement(plain, target, marks) < 0.8


@pytest.mark.parametrize("wrap", ["none", "x", "y", "both"])
def test_three_labels_any_size_and_wraps(wrap: str) -> None:
    marks, target = regions(96, 72, 3), np.ascontiguousarray(regions(50, 131, 3)[::-1])
    smap = grown(marks, target, wrap=wrap)
    assert smap.yx.shape[:2] == (50, 131)
    assert agreement(smap, target, marks) > 0.99


def test_thin_strokes_and_single_pixels_are_kept() -> None:
    """No patch is needed: neither strokes nor regions of the exemplar have to hold one."""
    marks, target = regions(90, 90), np.zeros((100, 120), np.uint8)
    for k, width in enumerate((1, 2, 4, 8)):
        target[12 + 24 * k : 12 + 24 * k + width, 10:110] = 1
    found = got(grown(marks, target), marks)
    for k, width in enumerate((1, 2, 4, 8)):
        assert (found[12 + 24 * k : 12 + 24 * k + width, 10:110] == 1).mean() > 0.95


def test_a_rare_label_is_found() -> None:
    """A label of 6 x 6 of 128 x 128 px fills a region, though a draw of any place would hardly ever meet it."""
    marks = np.zeros((128, 128), np.uint8)
    marks[60:66, 70:76] = 1
    target = disc(96)
    assert agreement(grown(marks, target), target, marks) > 0.99


def test_labels_that_never_meet_are_cut_at_the_boundary() -> None:
    marks, target = regions(90, 90, 3), disc(90, 2, 0)
    assert agreement(grown(marks, target), target, marks) > 0.995


def test_a_reach_is_followed() -> None:
    marks, target = regions(90, 90), disc(90)
    near = [agreement(grown(marks, target, reach=r), target, marks) for r in (0, 6)]
    assert near[0] >= near[1] > 0.95


def test_a_target_picture_is_followed() -> None:
    e = Exemplar.of(texture(90, 90, 1, 4))
    ramp = np.tile(np.linspace(40, 200, 80).astype(np.uint8), (60, 1))
    near = []
    for weight in (0.0, 2.0):
        out = ia.synthesize(e, None, METHOD, guide=Guide(e.base, Plane(ramp), weight))
        shown = np.asarray(out.render().pixels, float).reshape(60, 80).mean(axis=0)
        near.append(float(np.corrcoef(shown, ramp[0])[0, 1]))
    assert near[1] > 0.97
    assert near[1] > near[0]


def test_colours_may_guide() -> None:
    """Three channels, one target for each."""
    e = Exemplar.of(texture(90, 90, 3, 4))
    y, x = np.mgrid[:60, :80]
    wanted = np.stack([60 + 2 * x, 60 + 2 * y, np.full_like(x, 120)], axis=2).astype(np.uint8)
    gaps = []
    for weight in (0.0, 4.0):
        out = ia.synthesize(e, None, METHOD, guide=Guide(e.base, Plane(wanted), weight)).render()
        gaps.append(np.abs(np.asarray(out.pixels, float) - wanted).mean())
    assert gaps[1] < 0.8 * gaps[0]


@pytest.mark.parametrize("toroidal", [False, True])
def test_masked_pixels_are_neither_shown_nor_compared(toroidal: bool) -> None:
    marks, usable = regions(90, 90), np.ones((90, 90), bool)
    usable[30:52, 20:60] = False
    usable[:, :3] = False
    e = Exemplar.of(painted(marks).base, usable=usable, toroidal=toroidal)
    target, other = disc(90), marks.copy()
    other[~usable] = 1 - other[~usable]
    maps = [grown(m, target, exemplar=e) for m in (marks, other)]
    assert same_map(*maps)
    assert usable[maps[0].yx[..., 0], maps[0].yx[..., 1]].all()
    assert agreement(maps[0], target, marks) > 0.99


def test_a_wrapped_border_is_no_worse_than_the_inside() -> None:
    """The guide crosses the border, too: a target that is turned around gives regions that are."""
    marks, target = regions(90, 90), np.roll(disc(80), (40, 40), (0, 1))
    smap = grown(marks, target, wrap="both")
    assert agreement(smap, target, marks) > 0.99
    yx = smap.yx.astype(int)
    for axis, step in ((0, (1, 0)), (1, (0, 1))):
        on = (np.roll(yx, -1, axis) == yx + step).all(axis=2).mean(axis=1 - axis)
        assert on[-1] > 0.7 * on[:-1].mean()


def test_a_lattice_is_kept_to() -> None:
    """With snap=on pixels begin again whole periods away."""
    y, x = np.mgrid[:96, :96]
    marks = (x // 48).astype(np.uint8)
    pixels = np.stack([(y % 8) * 30, (x % 8) * 30, 90 * marks], axis=2).astype(np.uint8)
    method = ia.ParallelControllable(keep_lattice="on", lattice=((8.0, 0.0), (0.0, 8.0)), jitter=(0, 0, 0.3))
    target = disc(96)
    smap = grown(marks, target, method, exemplar=Exemplar.of(pixels))
    assert agreement(smap, target, marks) > 0.95
    moved = (smap.yx - np.stack(np.mgrid[:96, :96], axis=2)) % 8
    assert (moved == 0).all(axis=2).mean() > 0.95


def test_a_pin_is_stronger_than_the_guide_on_coarse_levels() -> None:
    marks = regions(96, 96)
    e, target = painted(marks), np.zeros((96, 96), np.uint8)
    stack, guide = exemplar_stack(e, ComparisonSettings()), Guide(labels(marks), labels(target))
    pinned = ia.ParallelControllable(pin=((40, 70, 48, 48, 20),))
    asked = StackGuide(Canvas(96, 96, guide=guide), stack)
    descent = PyramidSynthesis(stack, CorrectionParameters.of(decided(pinned, e)), 1, asked)
    spans = descent._spans(Span(0, 96, 0), Span(0, 96, 0))
    assert spans[0][0].start == -CorrectionParameters.of(decided(pinned, e)).margin - 1
    coords = descent.window(Span(0, 96, 0), Span(0, 96, 0), ONE)
    assert coords.shape == (96, 96, 2)
    free = PyramidSynthesis(
        stack, CorrectionParameters.of(decided(METHOD, e)), 1, StackGuide(Canvas(96, 96, guide=guide), stack)
    )
    assert (free.window(Span(0, 96, 0), Span(0, 96, 0), ONE) != coords).any()


def test_threads_change_nothing() -> None:
    marks, target = regions(70, 70), disc(100)
    e, guide = painted(marks), Guide(labels(marks), labels(target))
    outs = [ia.synthesize(e, None, METHOD, guide=guide, seed=5, run=ia.Run(n)) for n in (1, 2, 4)]
    assert len({o.map.digest for o in outs}) == 1
    assert "guide" in outs[0].recipe
    assert ia.synthesize(e, None, METHOD, guide=guide, seed=6).map.digest != outs[0].map.digest


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (3, 2), (33, 64)])
def test_any_shape_will_do(shape: tuple[int, int]) -> None:
    marks = np.zeros(shape, np.uint8)
    marks[:, shape[1] // 2 :] = 1
    target = np.full((20, 30), marks.max(), np.uint8)
    smap = grown(marks, target, wrap="x", run=ONE)
    assert not smap.holes.any()
    assert agreement(smap, target, marks) > 0.9


def test_what_does_not_fit_is_refused() -> None:
    marks, usable = regions(60, 60), regions(60, 60) == 0
    e = Exemplar.of(painted(marks).base, usable=usable)
    with pytest.raises(ia.InputError, match=r"no patch of 1x1 px of .* lies wholly in label 1; mark larger regions"):
        grown(marks, disc(60), exemplar=e)
    guide = Guide([labels(marks)] * 2, labels(marks))
    with pytest.raises(ia.ParameterError, match="grows from one exemplar"):
        ia.synthesize([painted(marks)] * 2, None, METHOD, guide=guide)


def test_without_a_guide_the_site_holds_none() -> None:
    """An empty guide is a loop of no turns, and border positions are never asked for theirs."""
    e = painted(regions(40, 40))
    assert all(not len(level.shown) + len(level.asked) for level in exemplar_stack(e, ComparisonSettings()).levels)
    around = bordered(np.arange(6).reshape(2, 3), 1, False)
    assert around.shape == (4, 5)
