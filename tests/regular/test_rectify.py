"""Courses that slant, converge or bow are laid straight: by exact copies, and only where it helps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import intarsia as ia
from intarsia.lattice import lattices_of
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.regular import rectify
from intarsia.regular.rectify import (
    TERMS,
    TURN,
    Rectified,
    _factors,
    _moved,
    _phase,
    rectified_for,
    rectified_if_better,
    straight_of,
)
from intarsia.testing import texture
from intarsia.testing.cases import noise

COURSE = 16.0


def coordinate(kind: str, size: int = 224) -> np.ndarray:
    """How far down a wall every px lies, were the wall straight."""
    y, x = np.mgrid[:size, :size].astype(float)
    u, middle = 2 * x / size - 1, size / 2
    return {
        "straight": y,
        "tilted": size * np.log1p(1.5 * y / size) / np.log(2.5),
        "winding": y + 12 * (u**3 - 0.6 * u + 0.4),
        "slanted": y - 0.03 * x,
        "converging": middle + (y - middle) * (1 + 0.02 * u),
        "bowed": y + 3 * u * u,
        "fan": middle + (y - middle) * (1 + 0.15 * u),
    }[kind]


def wall(down: np.ndarray, seed: int = 1) -> np.ndarray:
    """Bricks of free lengths in courses of 16 px, dark joints; as smooth as a photograph."""
    size = len(down)
    x = np.mgrid[:size, :size][1]
    row = np.floor(down / COURSE).astype(int)
    shift = (noise(200, 1, seed)[row % 200, 0] % np.uint64(400)).astype(int)
    along = x + shift
    length = 38
    far = np.minimum(np.minimum(down % COURSE, -down % COURSE), np.minimum(along % length, -along % length))
    mortar = np.clip(2 - far, 0, 1)
    shade = (noise(200, 40, seed + 1)[row % 200, along // length % 40] % np.uint64(60)).astype(int)
    grain = (noise(size, size, seed + 2) % np.uint64(9)).astype(int)
    return np.rint((130 + shade) * (1 - mortar) + 30 * mortar + grain).astype(np.uint8)


@pytest.mark.parametrize("kind", ["slanted", "converging", "bowed", "fan", "tilted", "winding"])
@pytest.mark.parametrize("upright", [False, True])
def test_courses_lie_straight_afterwards(kind: str, upright: bool) -> None:
    """Their pitch is the same everywhere within 0.2 px, and they leave straight level lines by less than 1 px."""
    truth = coordinate(kind)
    pixels = wall(truth)
    e = Exemplar.of(pixels.T if upright else pixels)
    straight = straight_of(e)
    assert straight is not None
    yx = straight.yx.swapaxes(0, 1)[..., ::-1] if upright else straight.yx
    down = truth[yx[..., 0], yx[..., 1]]
    known = straight.exemplar.free
    known = known.T if upright else known
    found = []
    for part in np.array_split(np.arange(down.shape[1]), 6):  # the pitch in strips from left to right, px
        rows = np.nonzero(known[:, part])[0]
        found.append(COURSE / np.polyfit(rows, down[:, part][known[:, part]], 1)[0])
    assert max(found) - min(found) < 0.2
    rows, columns = np.nonzero(known)
    a = np.stack([rows, np.ones(len(rows))], axis=1)
    off = down[known] - a @ np.linalg.lstsq(a, down[known], rcond=None)[0]
    assert np.abs(off).max() < 1.5
    assert abs(off[columns < 40].mean() - off[columns >= 180].mean()) < 0.5
    assert known.mean() > 0.6


def test_what_is_told_of_the_courses_is_true() -> None:
    kinds = "slanted", "converging", "bowed", "fan"
    told = {kind: straight_of(Exemplar.of(wall(coordinate(kind)))) for kind in kinds}
    assert told["slanted"].slant == pytest.approx(0.03, abs=0.003)
    assert told["slanted"].off < 1
    assert told["converging"].converging == pytest.approx(0.04, abs=0.01)
    assert told["bowed"].off == pytest.approx(2, abs=0.7)  # 3 px from the middle to the ends, less their mean
    assert told["fan"].converging == pytest.approx(1.15 / 0.85 - 1, abs=0.03)


def test_straight_walls_and_other_textures_are_left_alone() -> None:
    for pixels in (wall(coordinate("straight")), texture(90, 80, 3), np.full((64, 64), 7, np.uint8), texture(20, 25)):
        assert straight_of(Exemplar.of(pixels)) is None
    e = wall(coordinate("straight"))
    maps = [ia.synthesize(e, 120, ia.NearRegular(straighten=s), seed=1) for s in ("auto", "on", "off")]
    assert len({m.map.digest for m in maps}) == 1
    assert len({m.recipe_text for m in maps}) == 1
    assert maps[0].blend.feather == 0


def test_every_pixel_is_a_pixel_of_the_exemplar() -> None:
    """The straight exemplar is a gather, in all planes; what lay outside is not usable, masks follow."""
    pixels = wall(coordinate("fan"))
    height = np.repeat(np.repeat(pixels.astype(np.uint16) * 3, 2, axis=0), 2, axis=1)
    height[1::2] += 1
    usable = np.ones(pixels.shape, bool)
    usable[60:90, 100:140] = False
    small = (pixels[::2, ::2] // 2).astype(np.uint8)
    e = Exemplar.of({"albedo": pixels, "height": height, "roughness": small}, usable=usable)
    straight = straight_of(e)
    assert straight is not None
    made, (y, x) = straight.exemplar, np.moveaxis(straight.yx, 2, 0)
    np.testing.assert_array_equal(made.planes["albedo"].pixels, pixels[y, x])
    for i in (0, 1):
        np.testing.assert_array_equal(made.planes["height"].pixels[i::2, 1::2], height[2 * y + i, 2 * x + 1])
    np.testing.assert_array_equal(made.planes["roughness"].pixels, small[y // 2, x // 2])
    assert made.usable is not None
    assert usable[y, x][made.usable].all()
    shown = Rectified(made, (), straight).to_exemplar(np.argwhere(made.usable))
    np.testing.assert_array_equal(shown, straight.yx[made.usable])
    grown = ia.synthesize(e, 200, ia.NearRegular(), seed=1)
    assert grown.method.straighten == "on"
    assert usable[grown.map.yx[..., 0], grown.map.yx[..., 1]].all()
    assert grown.render(feather=0).pixels.tobytes() == pixels[grown.map.yx[..., 0], grown.map.yx[..., 1]].tobytes()


ALL = np.ones((200, 200), bool)


def fanned(heights: list[int]) -> np.ndarray:
    """Beds (n, 200) px of courses so high in the middle, that fan out by a tenth to either side."""
    x = np.linspace(-1, 1, 200)
    return np.rint(100 + (np.cumsum([0, *heights])[:, None] - 90) * (1 + 0.1 * x)).astype(np.int64)


def test_the_polynomial_goes_through_the_beds() -> None:
    """Compared with least squares over every place, and with the courses that beds part: within a fiftieth of one."""
    beds = fanned([20] * 9)
    factors = _factors(beds, ALL)
    assert factors is not None
    across, along = (2.0 * beds + 1 - 200) / 200, np.broadcast_to((2.0 * np.arange(200) + 1 - 200) / 200, beds.shape)
    terms = np.stack([(across**i * along**j).ravel() for i, j in TERMS], axis=1)
    numbers = np.repeat(np.arange(10.0), 200)
    plain = terms @ np.linalg.lstsq(terms, numbers, rcond=None)[0]
    assert np.abs(terms @ np.array(factors) / TURN - numbers).max() < np.abs(plain - numbers).max() + 0.02


def test_a_bed_that_was_not_found_is_passed_over() -> None:
    beds = fanned([20] * 9)
    whole, some = _factors(beds, ALL), _factors(np.delete(beds, 4, axis=0), ALL)
    assert whole is not None
    assert some is not None
    assert np.abs(np.array(whole) - some).max() < TURN / 20


def test_courses_of_several_heights_are_not_laid_straight() -> None:
    assert _factors(fanned([13, 27, 13, 27, 20, 14, 26, 13, 27]), ALL) is None
    assert _factors(fanned([20, 20, 21, 19, 20, 20, 20, 20, 20]), ALL) is not None


def test_only_what_is_usable_tells_where_beds_lie() -> None:
    """Beds that wander off where nothing may be used, or over the border, change nothing; unseen ones end it."""
    beds, usable = fanned([20] * 9), ALL.copy()
    usable[:, 150:] = False
    astray = np.where(np.arange(200) < 150, beds, beds - 30)
    assert _factors(astray, usable) == _factors(beds, usable)
    assert _factors(astray, ALL) != _factors(beds, ALL)
    usable[:, 6:] = False
    assert _factors(beds, usable) is None
    gone = ALL.copy()
    gone[:20] = False  # and with it the uppermost bed
    assert _factors(beds, gone) == _factors(beds[1:], gone) is not None


def test_a_pitch_that_grows_down_the_rows_is_followed() -> None:
    """Three times as high below as above: each gap is one course, by those around it."""
    highs = np.rint(9 * 1.13 ** np.arange(10)).astype(int).tolist()
    assert highs[-1] >= 2.9 * highs[0]
    factors = _factors(fanned(highs), ALL)
    assert factors is not None
    courses = _phase(factors, (200, 200))[:, 100] / TURN
    top, end = fanned(highs)[[0, -1], 100]
    assert courses[end] - courses[top] == pytest.approx(10, abs=0.2)


@pytest.mark.parametrize("lean", [0, 20, -37])
def test_places_get_the_pixel_of_the_nearest_phase(lean: int) -> None:
    """Compared with a search through all pixels of a column."""
    y, x = np.mgrid[:30, :23]
    at = (y - 14) * 5000 + (x - 11) * 700 + (y - 14) * (x - 11) * 40
    yx, inside = _moved(at, 12 * 256, lean)
    tall = len(yx)
    shift = [(r - tall // 2) * lean // 256 for r in range(tall)]
    first = -max(shift)
    for r in range(0, tall, 3):
        wanted = at.min() + r * 65536 * 256 // (12 * 256)
        for c in range(0, yx.shape[1], 5):
            column = first + c + shift[r]
            assert inside[r, c] <= (0 <= column < 23)
            column = min(max(column, 0), 22)
            distance = np.abs(at[:, column] - wanted)
            assert yx[r, c, 1] == column
            assert distance[yx[r, c, 0]] <= distance.min() + 1  # the border between two is rounded down
            if 0 <= first + c + shift[r] < 23:
                assert inside[r, c] == (distance.min() <= 65536 / 24 + 1 or distance.argmin() not in (0, 29))


def test_a_fan_of_courses_is_grown_straight() -> None:
    """Without straightening it has no lattice; with it the output's courses have one pitch."""
    down = coordinate("fan")
    e = wall(down)
    assert lattices_of(Exemplar.of(e)).accepted is None
    with pytest.raises(ia.MethodError, match="finds no lattice"):
        ia.synthesize(e, 200, ia.NearRegular(straighten="off"))
    made = ia.synthesize(e, (240, 260), ia.NearRegular(), seed=3)
    ((x, y),) = made.method.lattice
    assert (made.method.straighten, x) == ("on", 0)
    part = down[made.map.yx[..., 0], made.map.yx[..., 1]] / COURSE  # courses, but for whole ones
    turns = np.exp(2j * np.pi * (part - np.arange(240)[:, None] / y))
    assert abs(turns.mean()) > 0.95
    for strip in np.array_split(turns, 5, axis=1):
        assert abs(np.angle(strip.mean() / turns.mean())) / (2 * np.pi) * y < 0.6


def test_what_hardly_gains_stays_as_it_is() -> None:
    """A slant alone is kept by auto, as blocks follow it; on makes it level."""
    e = Exemplar.of(wall(coordinate("slanted")))
    assert rectified_if_better(e) is None
    asked = {s: ia.NearRegular(straighten=s).resolved([e], Canvas(9, 9)) for s in ("auto", "on")}
    assert asked["auto"].straighten == "off"
    assert asked["on"].straighten == "on"


def test_an_exemplar_is_laid_straight_only_for_a_clear_gain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twice what is asked of a lattice where it has none as it is, else 1.4 times the confidence that it has."""
    e = Exemplar.of(wall(coordinate("fan")))
    found, none = rectify.rectified_lattice(e), lattices_of(e)
    assert found is not None
    assert found[0].off >= 1
    least = found[1].confidence / found[1].share
    had = replace(none, accepted=replace(found[1], confidence=0.2))
    for plain, asked in ((none, 2 * least), (had, 1.4 * 0.2)):
        monkeypatch.setattr(rectify, "lattices_of", lambda e, weights=None, plain=plain: plain)
        for times, better in ((0.97, False), (1.03, True)):
            one = replace(found[1], confidence=times * asked)
            monkeypatch.setattr(rectify, "rectified_lattice", lambda e, weights=None, one=one: (found[0], one))
            assert (rectified_if_better(e) is not None) == better


def test_what_has_two_vectors_or_is_not_surely_bricks_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Patches in step bend as a lattice does; without one only stones that are told apart are asked for."""
    e = Exemplar.of(wall(coordinate("fan")))
    found, none = rectify.rectified_lattice(e), lattices_of(e)
    assert found is not None
    assert none.accepted is None
    surer = replace(found[1], vectors=((4096, 0), (0, 9728)))
    two = replace(none, accepted=replace(surer, confidence=0.1 * surer.confidence))
    cases = (none, found[1], True, True), (none, found[1], False, False), (two, surer, True, False)
    for plain, one, bricks, moved in cases:
        monkeypatch.setattr(rectify, "lattices_of", lambda e, weights=None, plain=plain: plain)
        monkeypatch.setattr(rectify, "rectified_lattice", lambda e, weights=None, one=one: (found[0], one))
        monkeypatch.setattr(rectify, "clear_masonry", lambda e, weights=None, bricks=bricks: bricks or None)
        assert (rectified_if_better(e) is not None) is moved


def test_courses_that_are_nearly_straight_stay_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is off by less than 3 px is not moved: patches in step give way by as much."""
    e = Exemplar.of(wall(coordinate("fan")))
    found = rectify.rectified_lattice(e)
    assert found is not None
    assert rectified_if_better(e) is not None
    monkeypatch.setattr(rectify, "rectified_lattice", lambda e, weights=None: found)
    for off, moved in ((2.9, False), (3.0, True)):
        one = replace(found[0], off=off)
        monkeypatch.setattr(rectify, "straight_of", lambda e, weights=None, one=one: one)
        assert (rectified_if_better(e) is not None) is moved


def test_recipes_hold_what_was_done() -> None:
    """The vectors of a recipe are those of the straight exemplar, and bring it back; vectors alone do not."""
    e = wall(coordinate("fan"))
    one = ia.synthesize(e, 150, ia.NearRegular(), seed=2)
    again = ia.NearRegular(lattice=one.method.lattice, straighten="on")
    two = ia.synthesize(e, 150, again, seed=2, run=ia.Run(3))
    assert one.map.digest == two.map.digest
    assert one.recipe_text == two.recipe_text
    assert one.map.blend.feather == two.blend.feather == 4
    given = ia.NearRegular(lattice=((0, 16),)).resolved([Exemplar.of(e)], Canvas(9, 9))
    assert given.straighten == "off"
    assert rectified_for(Exemplar.of(e), given.slug, given.lattice, given.straighten).straight is None


def test_analyze_says_so() -> None:
    found = ia.analyze(wall(coordinate("fan")))
    told = found.as_dict()
    assert told["lattice"] is None
    assert told["straightened"]["converging"] == pytest.approx(0.35, abs=0.03)
    assert told["straightened"]["confidence"] > 0.3
    assert told["suggested"]["method"] == "near-regular"
    assert told["suggested"]["parameters"]["straighten"] == "on"
    assert ia.analyze(wall(coordinate("straight"))).as_dict()["straightened"] is None
