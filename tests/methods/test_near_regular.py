"""Near-regular textures: rows are kept, windows are crops, and what has no lattice is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

import intarsia as ia
from intarsia.lattice import check_lattice, lattice_of
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.regular.mosaic import Mosaic
from intarsia.regular.near_regular import FEW
from intarsia.testing import texture
from intarsia.testing.cases import noise


def tiling(height: int, width: int, rows: float, columns: float, shear: float = 0.0) -> np.ndarray:
    """Tiles of different grey with dark joints; every second vector leans by `shear` px."""
    y, x = np.mgrid[:height, :width].astype(float)
    i = np.floor(y / rows).astype(int)
    u = x - i * shear
    j = np.floor(u / columns).astype(int)
    joint = (y % rows < 3) | (u % columns < 3)
    grey = 120 + (noise(64, 256, 5)[i % 64, j % 256] % np.uint64(100)).astype(int)
    grain = (noise(height, width, 7) % np.uint64(9)).astype(int)
    return np.where(joint, 20, grey + grain).astype(np.uint8)


@pytest.mark.parametrize(("rows", "columns", "shear"), [(20.0, 24.0, 0.0), (17.5, 22.25, 0.0), (16.0, 30.0, 15.0)])
def test_the_output_repeats_by_the_lattice_of_the_exemplar(rows: float, columns: float, shear: float) -> None:
    """Its joints lie on the lattice within 1 px: near the joints of a tiling of the same phase."""
    e = tiling(160, 180, rows, columns, shear)
    made = ia.synthesize(e, (300, 320), ia.NearRegular(lattice=((columns, 0), (shear, rows))), seed=4)
    shown = made.render().pixels.reshape(300, 320) < 60
    truth = tiling(300, 320, rows, columns, shear) < 60
    grown = truth.copy()
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            grown |= np.roll(truth, (dy, dx), (0, 1))
    assert (shown & ~grown).mean() < 0.005
    assert 0.85 < shown.mean() / truth.mean() < 1.15


ANYWHERE = [(17, 15), (23, 27), (30, 12)]
"""Where an exemplar is cut out of a tiling: its first joint lies so many px before its border."""


@pytest.mark.parametrize("cut", ANYWHERE)
@pytest.mark.parametrize("block", [40, 88])
def test_blocks_meet_in_the_joints_wherever_these_lie(cut: tuple[int, int], block: int) -> None:
    """The grid of blocks begins near a joint, not at the border of the exemplar, so cuts lie in joints."""
    pixels = tiling(360, 380, 40, 44)[cut[0] :, cut[1] :].copy()
    method = ia.NearRegular(lattice=((44, 0), (0, 40)), block=block, border=8)
    made = ia.synthesize(pixels, (400, 420), method, seed=1)
    dark = made.render().pixels.reshape(400, 420) < 60
    cuts = [made.map.yx[1:, :, 0] != made.map.yx[:-1, :, 0] + 1, made.map.yx[:, 1:, 1] != made.map.yx[:, :-1, 1] + 1]
    beside = [dark[1:] | dark[:-1], dark[:, 1:] | dark[:, :-1]]
    assert sum(int(c.sum()) for c in cuts) > 2000
    assert sum(int((c & d).sum()) for c, d in zip(cuts, beside, strict=True)) > 0.7 * sum(int(c.sum()) for c in cuts)


def moves(mosaic: Mosaic, height: int, width: int) -> dict[tuple[int, int], tuple[int, int]]:
    """By how much the pixel in the middle of each block lies elsewhere in the exemplar: what the block shows."""
    window = mosaic.continued_window(0, 0, height, width)
    down = (mosaic.grid.rows[0] + mosaic.grid.columns[0]) / 512
    right = (mosaic.grid.rows[1] + mosaic.grid.columns[1]) / 512
    found = {}
    last = mosaic.grid.block_of(height, width)
    for i in range(last[0]):
        for j in range(last[1]):
            y, x = (int(v / 256 + d) for v, d in zip(mosaic.grid.origin(i, j), (down, right), strict=True))
            if 0 <= y < height and 0 <= x < width:
                found[i, j] = int(window[y, x, 0]) - y, int(window[y, x, 1]) - x
    return found


def test_blocks_are_read_at_the_px_nearest_to_their_place_in_the_lattice() -> None:
    """Wherever on the canvas, a block is moved by whole steps of the lattice, rounded once."""
    settings = ia.NearRegular(lattice=((22.25, 0), (0, 17.7)), block=40, lattice_tolerance=0)
    mosaic = Mosaic.of(settings, Exemplar.of(tiling(200, 210, 17.7, 22.25)), 5)
    random = [move for (i, j), move in moves(mosaic, 900, 900).items() if (i + j) % 2 == 0]
    assert len(random) > 150
    for axis, period in enumerate((round(17.7 * 256) / 256, 22.25)):
        off = [(move[axis] + period / 2) % period - period / 2 for move in random]
        assert max(abs(o) for o in off) <= 0.5 + 1e-9
        assert max(off) > 0.3
        assert min(off) < -0.2


def test_places_are_used_in_turn() -> None:
    """Every second block shows a place drawn without putting back, so all are shown about as often."""
    settings = ia.NearRegular(lattice=((24, 0), (0, 20)), block=20, lattice_tolerance=0)
    mosaic = Mosaic.of(settings, Exemplar.of(tiling(160, 192, 20, 24)), 3)
    shown: dict[tuple[int, int], int] = {}
    for (i, j), move in moves(mosaic, 800, 800).items():
        if (i + j) % 2 == 0:
            y, x = mosaic.grid.origin(i, j)
            place = round(y / 256) + move[0], round(x / 256) + move[1]
            shown[place] = shown.get(place, 0) + 1
    counts = np.array(list(shown.values()))
    assert len(counts) > 40
    assert counts.sum() > 8 * len(counts)
    assert counts.std() < 0.2 * counts.mean()  # independent draws: 0.3


def test_a_gap_shows_something_else_than_what_lies_beside_it() -> None:
    """It neither repeats a block beside it, nor goes on with it as the exemplar does, where others fit, too."""
    settings = ia.NearRegular(lattice=((24, 0), (0, 20)), block=20, lattice_tolerance=0)
    mosaic = Mosaic.of(settings, Exemplar.of(tiling(200, 240, 20, 24)), 7)
    found = moves(mosaic, 900, 900)
    pairs = repeated = continued = 0
    for (i, j), (dy, dx) in found.items():
        for a, b in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)) if (i + j) % 2 else ():
            if (a, b) in found:
                (y, x), (v, u) = mosaic.grid.origin(i, j), mosaic.grid.origin(a, b)
                other = found[a, b]
                pairs += 1
                continued += other == (dy, dx)
                repeated += (round(v / 256) + other[0], round(u / 256) + other[1]) == (
                    round(y / 256) + dy, round(x / 256) + dx
                )  # fmt: skip
    assert pairs > 1000
    assert continued < 0.01 * pairs  # 37 in 1000 where any that fits is drawn
    assert repeated < 0.004 * pairs  # 10 in 1000


def test_the_lattice_is_found_and_replayed() -> None:
    e = Exemplar.of(tiling(160, 180, 20, 24))
    found = lattice_of(e, "near-regular")
    assert ia.NearRegular().resolved([e], Canvas(50, 50)).lattice == found
    off = np.array(found) / (24, 20)
    assert np.abs(off - off.round()).max() < 0.06
    one, two = (ia.synthesize(e, 120, m, seed=2) for m in (ia.NearRegular(), ia.NearRegular(lattice=found)))
    assert (one.map.digest, one.recipe_text) == (two.map.digest, two.recipe_text)


@pytest.mark.parametrize("lattice", [((22.25, 0), (0, 17.5)), ((30, 0), (15, 16)), ((21, 5), (-4, 18))])
@pytest.mark.parametrize("corner", [(0, 0), (-150, 77), (2**40 - 3, -(2**40) - 11)])
def test_a_window_is_a_crop(lattice: tuple, corner: tuple[int, int]) -> None:
    settings, (y, x) = ia.NearRegular(lattice), corner
    e = Exemplar.of(tiling(120, 140, 17.5, 22.25))
    mosaic = Mosaic.of(settings, e, 5)
    whole = mosaic.continued_window(y, x, 150, 170)
    assert whole.any(axis=2).mean() > 0.99
    for top, left, height, width in ((0, 0, 1, 1), (40, 31, 64, 50), (149, 0, 1, 170), (99, 101, 51, 69)):
        part = mosaic.continued_window(y + top, x + left, height, width)
        np.testing.assert_array_equal(part, whole[top : top + height, left : left + width])


def test_two_neighbours_never_meet_inside_a_gap() -> None:
    """They would meet along the mitre, in a seam that no cut counts."""
    settings = ia.NearRegular(lattice=((20, 0), (0, 21)), block=20)
    mosaic = Mosaic.of(settings, Exemplar.of(texture(100, 100, 3, 3)), 5)
    moved = mosaic.continued_window(0, 0, 180, 190) - np.moveaxis(np.indices((180, 190)), 0, 2)

    def shown_by(gap: tuple[int, int], y: int, x: int) -> set[tuple[int, int]]:
        """The neighbours of a gap that show a pixel in it, and not the gap's own block."""
        i, j = gap
        middle = tuple(c // 256 + 10 for c in mosaic.grid.origin(i, j))
        own = moved[middle] if 0 <= middle[0] < 180 and 0 <= middle[1] < 190 else moved[y, x]
        if mosaic.grid.block_of(y, x) != gap or (own == moved[y, x]).all():
            return set()
        near = ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1))
        return {n for n in near if (mosaic._shifts(*n, mosaic._place(*n)) == moved[y, x]).all()}

    let_in = 0
    for y, x in np.ndindex(179, 189):
        gap = mosaic.grid.block_of(y, x)
        one = shown_by(gap, y, x) if sum(gap) % 2 else set()
        let_in += bool(one)
        for other in (shown_by(gap, y + 1, x), shown_by(gap, y, x + 1)) if one else ():
            assert not other or one & other
    assert let_in > 500


def test_blocks_close_around_no_canvas() -> None:
    """Patches in step do."""
    e, lattice = tiling(160, 180, 26, 24, 1.0), ((24, 0), (1, 26))
    with pytest.raises(ia.ParameterError, match=r"^wrap: near-regular closes courses, .* take graphcut for that\.$"):
        ia.synthesize(e, (260, 192), ia.NearRegular(lattice=lattice, block=26), wrap="y")


@pytest.mark.parametrize("lattice", [((20, 0), (40, 0.5)), ((200, 0), (0, 10)), ((0.5, 0), (0, 10))])
def test_vectors_that_span_no_lattice_are_refused(lattice: tuple) -> None:
    e = Exemplar.of(texture(60, 70))
    message = "are parallel" if lattice[1][0] else "a lattice vector must be 1 px long at least"
    for ask in (lambda: check_lattice(lattice, e), lambda: ia.synthesize(e, 40, ia.NearRegular(lattice=lattice))):
        with pytest.raises(ia.ParameterError, match=message):
            ask()


@pytest.mark.parametrize(
    "lattice", [((math.nan, 1),), ((math.inf, 1), (0, 5)), ((0, 0),), (), ((1, 2, 3),), 5, "ab", ((9, 0),) * 3]
)
def test_vectors_that_are_none_are_refused(lattice: object) -> None:
    with pytest.raises(ia.ParameterError, match=r"^lattice="):
        ia.NearRegular(lattice=lattice)


@pytest.mark.parametrize("height", [1, 2, 5, 15, 16, 90])
@pytest.mark.parametrize("method", ["near-regular", "best-tile"])
def test_an_exemplar_without_a_lattice_is_refused(method: str, height: int) -> None:
    with pytest.raises(ia.MethodError, match=rf"^{method} finds no lattice in .* use method image-quilting") as caught:
        ia.synthesize(texture(height, max(height - 10, height % 80)), 100, method)
    assert caught.value.exit_code == 1


@pytest.mark.parametrize("kind", [ia.NearRegular, ia.GapFilling])
def test_any_texture_grows_without_a_lattice(kind: type) -> None:
    """With vectors 1,0 and 0,1 blocks come from anywhere, and gaps still fit: better than patches at random."""
    e = Exemplar.of(texture(90, 80, 1, 3))
    method = kind(lattice=((1, 0), (0, 1)), block=20, border=8)
    out = ia.synthesize(e, 160, method, seed=1)
    blind = ia.synthesize(e, 160, ia.RandomTiling(patch=20), seed=1)
    steps = [np.abs(np.diff(o.render(feather=0).pixels[:, :, 0].astype(int), axis=0)) for o in (out, blind)]
    broken = [np.diff(o.map.yx[:, :, 0], axis=0) != 1 for o in (out, blind)]
    assert steps[0][broken[0]].mean() < 0.8 * steps[1][broken[1]].mean()
    assert len(np.unique(out.map.yx.reshape(-1, 2), axis=0)) > 0.6 * 90 * 80


def test_too_few_places_give_the_best_tile_and_say_so() -> None:
    """What holds one period repeats it, and the run tells why."""
    e, run = tiling(30, 40, 20, 24), ia.Run(1)
    made = ia.synthesize(e, (90, 100), ia.NearRegular(lattice=((24, 0), (0, 20))), run=run)
    yx = made.map.yx
    np.testing.assert_array_equal(yx[20:], yx[:-20])
    np.testing.assert_array_equal(yx[:, 24:], yx[:, :-24])
    assert len(np.unique(yx.reshape(-1, 2), axis=0)) == 20 * 24
    assert run.notes == [FEW]
    enough = ia.Run(1)
    ia.synthesize(tiling(160, 180, 20, 24), 90, ia.NearRegular(lattice=((24, 0), (0, 20))), run=enough)
    assert enough.notes == []


def test_less_than_one_period_is_refused() -> None:
    with pytest.raises(ia.MethodError, match=r"no tile of one period \(20.0,0.0 px and 0.0,20.0 px\) and its border"):
        ia.synthesize(texture(20, 20), 30, ia.NearRegular(lattice=((20, 0), (0, 20))))
