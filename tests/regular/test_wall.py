"""Courses of whole bricks: joints are found, bricks stay whole, rows straight, and windows are crops."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from long import going_round
from paint_setts import COURSE
from regular import naive_wall as naive
from regular.test_unequal_courses import rubble
from scipy.ndimage import distance_transform_edt, gaussian_filter, label

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.kernels import shortest_paths
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.regular import wall_kernels
from intarsia.regular.masonry import bricks_of, masonry_of_pitch
from intarsia.regular.unequal_courses import faces_at_joints
from intarsia.regular.wall import Wall, brick_share, courses_of
from intarsia.regular.wall_kernels import NO_JOINT
from intarsia.testing import texture
from intarsia.testing.cases import noise

FREE = (52, (90, 110, 150), 8)
BONDED = (30, (60,), 4)
THIN = (16, (24, 24, 48), 4)
WALLS = [FREE, BONDED, THIN, (25, (40, 55, 70), 4)]


def wall(height: int, width: int, course: int, lengths: tuple[int, ...], joint: int, lean: float = 0.0, seed: int = 1):
    """A wall of bricks of free lengths, each of its own colour: pixels, and the number of each brick (0: mortar)."""
    drawn = noise(400, 400, seed).astype(object)
    numbers = np.zeros((height, width), np.int64)
    y, x = np.mgrid[:height, :width]
    row = np.floor((y - lean * x) / course).astype(int)
    v = y - lean * x - row * course
    n = 1
    for r in range(row.min(), row.max() + 1):
        left = -int(drawn[r % 400, 399] % max(lengths))
        k = 0
        while left < width:
            long = lengths[int(drawn[r % 400, k % 400] % len(lengths))]
            inside = (row == r) & (x >= left + joint / 2) & (x < left + long - joint / 2)
            numbers[inside & (v >= joint / 2) & (v < course - joint / 2)] = n
            left, k, n = left + long, k + 1, n + 1
    colours = 100 + (noise(n, 3, seed + 1) % np.uint64(140)).astype(int)
    colours[0] = 25
    grain = (noise(height, width, seed + 2) % np.uint64(9)).astype(int)[:, :, None]
    return (colours[numbers] + grain).astype(np.uint8), numbers


def exemplar_of(kind, **other):
    course, lengths, joint = kind
    return wall(max(6 * course, 200), 300, course, lengths, joint, **other)


def test_bricks_whose_joints_look_like_faces_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """As letters do: what parts them looks like faces by 114 of 255 and more, joints by 5 to 68."""
    e, pitch = Exemplar.of(exemplar_of(FREE)[0]), ((0.0, 52.0),)
    assert faces_at_joints(courses_of(pitch, None, e)[0]) < 60
    assert brick_share(pitch, e) > 0.5
    for faces, laid in ((96, True), (97, False)):
        monkeypatch.setattr("intarsia.regular.wall.faces_at_joints", lambda work, faces=faces: faces)
        assert (brick_share(pitch, e) > 0) is laid


@pytest.mark.parametrize("kind", WALLS)
def test_beds_and_joints_are_found(kind) -> None:
    """Every bed and joint lies within 1 px of the truth, and none is missed or invented."""
    pixels, numbers = exemplar_of(kind)
    course, _, joint = kind
    picture = features([Exemplar.of(pixels)]).pictures[0]
    work = masonry_of_pitch(picture, np.ones(picture.shape[:2], bool), (course * 256, 0))
    assert len(work.spans) >= len(pixels) // course - 1
    assert abs(work.thickness - joint) <= 1
    for k in work.spans:
        bed = np.median(work.beds[k])
        assert min(bed % course, -bed % course) <= 1
        middle = int(np.median(work.beds[k] + work.beds[k + 1])) // 2
        row = numbers[middle]
        edges = np.flatnonzero(np.diff((row == 0).astype(int)))
        inner = [(a + b + 2) // 2 for a, b in pairwise(edges) if row[a + 1] == 0]
        found = [int(work.joints[j, middle]) for j in work.of_course[k]]
        found = [x for x in found if joint < x < 300 - joint]
        inner = [x for x in inner if joint < x < 300 - joint]
        assert len(found) == len(inner), k
        assert np.abs(np.array(found) - inner).max(initial=0) <= 1


def test_the_material_of_setts_has_ten_stones_in_a_course() -> None:
    """Every bed in the middle of its joint, and ten stones in each course."""
    work = courses_of(((0.0, COURSE),), None, ia.read("sample:setts"))[0]
    off = np.median(work.beds, axis=1) / COURSE
    assert np.abs(off - off.round()).max() * COURSE < 2
    assert {len(work.of_course[k]) for k in work.spans} <= {10, 11}


@pytest.mark.parametrize("kind", [FREE, THIN])
def test_slopes_do_not_draw_beds_to_one_side_of_the_joints(kind) -> None:
    """Of a material of one tone almost, whose bricks are round: each bed in the middle of its joint."""
    pixels, numbers = exemplar_of(kind)
    course, _, joint = kind
    dy, dx = np.gradient(gaussian_filter(np.minimum(distance_transform_edt(numbers), joint), 0.7))
    normal = np.dstack([-dx, dy, np.ones_like(dx)]) / np.sqrt(dx**2 + dy**2 + 1)[:, :, None]
    planes = {"albedo": pixels // 4 + 80, "normal": np.round(127.5 * normal + 127.5).astype(np.uint8)}
    work = courses_of(((0.0, float(course)),), None, Exemplar.of(planes))[0]
    off = np.median(work.beds, axis=1) / course
    assert np.abs(off - off.round()).max() * course < 2


@pytest.mark.parametrize("kind", WALLS)
@pytest.mark.parametrize("seed", [1, 2])
def test_every_brick_is_one_brick(kind, seed: int) -> None:
    """Connected faces show one brick of the exemplar: at most a line of pixels of another; and it is whole."""
    pixels, numbers = exemplar_of(kind)
    made = ia.synthesize(pixels, (300, 400), ia.NearRegular(lattice=((0, kind[0]),)), seed=seed)
    shown = numbers[made.map.yx[:, :, 0], made.map.yx[:, :, 1]]
    area = np.bincount(numbers.ravel())
    parts, n = label(shown > 0)
    border = set(np.concatenate([parts[0], parts[-1], parts[:, 0], parts[:, -1]]))
    cut = 0
    for k in range(1, n + 1):
        counts = np.bincount(shown[parts == k])
        assert counts.sum() - counts.max() <= max(0.05 * counts.sum(), kind[0]), np.flatnonzero(counts)
        if k not in border:
            cut += counts.max() < 0.8 * area[counts.argmax()]
    assert cut <= 0.05 * n
    assert n > 0.7 * 300 * 400 / (kind[0] * np.mean(kind[1]))  # and they do not run into one another


@pytest.mark.parametrize("kind", [FREE, BONDED])
def test_rows_are_straight_and_joints_staggered(kind) -> None:
    """Beds lie where the pitch puts them, and no joint lies on one of the course above."""
    pixels, numbers = exemplar_of(kind)
    course, lengths, joint = kind
    method = ia.NearRegular(lattice=((0, course),))
    made = ia.synthesize(pixels, (10 * course, 600), method, seed=5)
    shown = numbers[made.map.yx[:, :, 0], made.map.yx[:, :, 1]]
    mortar = (shown == 0).mean(axis=1)
    for i in range(1, 10):
        assert mortar[i * course - 1 : i * course + 1].min() > 0.9
    near = total = 0
    for i in range(9):
        above, below = (shown[i * course + course // 2 + d * course] == 0 for d in (0, 1))
        for x in np.flatnonzero(below):
            total += 1
            near += above[max(0, x - 2) : x + 3].any()
    chance = (joint + 4) / np.mean(lengths)
    assert near / total < 0.5 * chance


@pytest.mark.parametrize("lean", [0.06, -0.06])
def test_courses_may_lean(lean: float) -> None:
    pixels, numbers = wall(260, 300, 26, (50, 70), 4, lean)
    vector = (-26 * lean / (1 + lean**2), 26 / (1 + lean**2))
    made = ia.synthesize(pixels, (300, 300), ia.NearRegular(lattice=(vector,)), seed=2)
    shown = numbers[made.map.yx[:, :, 0], made.map.yx[:, :, 1]]
    y, x = np.mgrid[:300, :300]
    v = (y - lean * x + 1) % 26
    assert (shown[v < 2] == 0).mean() > 0.95
    parts, n = label(shown > 0)
    pure = sum(np.bincount(shown[parts == k]).max() >= 0.95 * (parts == k).sum() for k in range(1, n + 1))
    assert pure >= 0.97 * n


@pytest.mark.parametrize(("pixels", "lying", "upright"), [
    (exemplar_of(BONDED)[0], {"lattice": ((0, 30),)}, {"lattice": ((30, 0),)}),
    (rubble()[0], {"course_heights": "unequal"}, {"course_heights": "unequal"}),
], ids=["equal", "unequal"])  # fmt: skip
def test_upright_courses_are_courses_turned(pixels, lying, upright) -> None:
    one = ia.synthesize(pixels, (200, 260), ia.NearRegular(**lying), seed=3)
    two = ia.synthesize(pixels.swapaxes(0, 1).copy(), (260, 200), ia.NearRegular(**upright), seed=3)
    np.testing.assert_array_equal(two.map.yx, one.map.yx.swapaxes(0, 1)[:, :, ::-1])


def test_bricks_are_used_in_turn() -> None:
    """Whole bricks are all shown, none much more often than others, and none beside itself."""
    pixels, numbers = exemplar_of((25, (40, 55, 70), 4))
    made = ia.synthesize(pixels, (600, 900), ia.NearRegular(lattice=((0, 25),)), seed=1)
    shown = numbers[made.map.yx[:, :, 0], made.map.yx[:, :, 1]]
    parts, n = label(shown > 0)
    first = np.array([shown[parts == k][0] for k in range(1, n + 1)])
    whole = [k for k in range(1, numbers.max() + 1) if not (set(np.argwhere(numbers == k)[:, 1]) & {0, 299})]
    count = np.bincount(first, minlength=numbers.max() + 1)[whole]
    assert (count > 0).mean() > 0.9
    assert count.max() < 1.85 * count.mean()
    for row in shown[12::25]:
        names = [b for a, b in pairwise(row) if b and b != a]
        assert all(a != b for a, b in pairwise(names))


def test_a_brick_is_cheapest_when_it_is_its_turn() -> None:
    """Along a chain the bricks of its hand take turns, one a usual length: nothing else is to choose between them."""
    pixels, _ = wall(200, 300, 25, (50,), 4)
    layer = Wall.of(((0, 25),), None, Exemplar.of(pixels), Canvas(10, 10), 5)
    chain = layer.layout
    whole = [k for k, row in enumerate(chain.bricks.table) if NO_JOINT not in row[3:]]
    assert len(whole) >= 8
    cost = chain._starts(whole, [], 0, round(2.5 * len(whole) * chain.bricks.usual))
    for turn in range(2 * len(whole)):
        at = round((turn + 0.5) * chain.bricks.usual)
        assert cost[:, at].argmin() == turn % len(whole)
        assert np.sort(cost[:, at])[1] > cost[:, at].min()


@pytest.mark.parametrize(("width", "shown"), [(150, True), (300, False)])
def test_bricks_that_the_border_cuts_are_left_out_where_whole_ones_are_enough(width: int, shown: bool) -> None:
    """Their straight ends and sharp corners are seen; few whole ones repeat, which is worse."""
    pixels = wall(130, width, 25, (40, 55, 70), 4)[0]
    picture = features([Exemplar.of(pixels)]).pictures[0]
    found = bricks_of(masonry_of_pitch(picture, np.ones(picture.shape[:2], bool), (25 * 256, 0)))
    whole = (found.table[:, 3:] != wall_kernels.NO_JOINT).all(axis=1)
    assert (whole.sum() < 16) == shown
    assert (~whole).any() == shown


CASES = [
    (exemplar_of((25, (40, 55, 70), 4))[0], ((0, 25),)),
    (exemplar_of((25, (40, 55, 70), 4))[0].swapaxes(0, 1).copy(), ((25, 0),)),
    (wall(200, 220, 26, (50, 70), 4, 0.06)[0], ((-1.56, 26),)),
    (texture(40, 44, 3), ((3, 18),)),
    (texture(36, 32, 1), ((0, 6),)),
]


UNEQUAL = [(rubble()[0], None), (rubble()[0].swapaxes(0, 1).copy(), None), (rubble(seed=4, joint=4)[0], None)]
CORNERS = [(0, 0), (-150, 77), (2**40 - 3, -(2**40) - 11)]


@pytest.mark.parametrize(("case", "corner"), going_round([*CASES, *UNEQUAL], CORNERS))
def test_a_window_is_a_crop(case, corner: tuple[int, int]) -> None:
    (pixels, lattice), (y, x) = case, corner
    e = Exemplar.of(pixels)
    whole = Wall.of(lattice, None, e, Canvas(10, 10), 5).window(y, x, 150, 170)
    for top, left, height, width in ((0, 0, 1, 1), (40, 31, 64, 50), (149, 0, 1, 170), (99, 101, 51, 69)):
        part = Wall.of(lattice, None, e, Canvas(10, 10), 5).window(y + top, x + left, height, width)
        np.testing.assert_array_equal(part, whole[top : top + height, left : left + width])


@pytest.mark.parametrize(("case", "long"), going_round(CASES, [37, 290, 900]))
def test_a_wrapped_canvas_continues_in_itself(case, long: int) -> None:
    """The window one canvas further on shows the same, at any length along the courses."""
    pixels, lattice = case
    (a, b), e = lattice[0], Exemplar.of(pixels)
    pitch = (a * a + b * b) / max(abs(a), abs(b))
    height, width = (round(7 * pitch), long) if abs(b) > abs(a) else (long, round(7 * pitch))
    wall_ = Wall.of(lattice, None, e, Canvas(height, width, ia.Wrap.BOTH), 3)
    here = wall_.window(0, 0, height, width)
    np.testing.assert_array_equal(wall_.window(height, -width, height, width), here)
    np.testing.assert_array_equal(wall_.window(-100, 200, height, width), np.roll(here, (100, -200), (0, 1)))


def test_sizes_that_strain_the_courses_are_refused() -> None:
    pixels, _ = exemplar_of(BONDED)
    with pytest.raises(ia.ParameterError, match=r"^wrap: height=195 px is no whole number .* choose 180 or 210 px"):
        ia.synthesize(pixels, (195, 288), ia.NearRegular(lattice=((0, 30),)), wrap="both")
    with pytest.raises(ia.ParameterError, match=r"^wrap: width=195 px is no whole number .* choose 180 or 210 px"):
        ia.synthesize(pixels.swapaxes(0, 1).copy(), (288, 195), ia.NearRegular(lattice=((30, 0),)), wrap="x")


def test_exemplars_without_a_whole_course_are_refused() -> None:
    with pytest.raises(ia.MethodError, match="holds no whole course"):
        ia.synthesize(texture(20, 60), 40, ia.NearRegular(lattice=((0, 28),)))


def test_boards_are_laid_whole_and_grown_in_step() -> None:
    """Courses without joints: each is one board to be laid, in place; by itself `auto` keeps them in step."""
    y = np.mgrid[:160, :240][0]
    tone = np.array([120, 180, 150, 200, 100, 160, 140, 190])[y // 20]
    grain = (noise(160, 240, 4) % np.uint64(20)).astype(int)
    pixels = np.where(y % 20 < 3, 10, tone + grain).astype(np.uint8)
    picture = features([Exemplar.of(pixels)]).pictures[0]
    assert bricks_of(masonry_of_pitch(picture, np.ones(picture.shape[:2], bool), (20 * 256, 0))) is None
    made = ia.synthesize(pixels, (200, 700), ia.NearRegular(lattice=((0, 20),)), seed=2)
    board = made.map.yx[:, :, 0] // 20
    for i in range(9):
        row = board[i * 20 + 10]
        ends = np.flatnonzero(np.diff(made.map.yx[i * 20 + 10, :, 1]) != 1)
        assert (board[i * 20 + 6 : i * 20 + 17] == row).mean() > 0.98  # cuts of ends wander a little
        assert 2 <= len(ends) <= 5
        assert np.diff(ends).min() > 100
    grown = ia.synthesize(pixels, (200, 300), seed=2)
    assert (grown.method.slug, np.round(grown.method.lattice).tolist()) == ("graphcut", [[0, 20]])
    off = (grown.map.yx[:, :, 0] - np.arange(200)[:, None]) % 20
    assert np.isin((off - off[0, 0] + 10) % 20, range(7, 14)).all()  # give or take 3 px


def draws(shape, seed: int, below: int) -> np.ndarray:
    return (noise(int(np.prod(shape)), 1, seed) % np.uint64(below)).astype(np.int64).reshape(shape)


@pytest.mark.parametrize("seed", range(8))
def test_paths_and_cuts_are_the_cheapest(seed: int) -> None:
    cost, gap = draws((5, 4), seed, 9), draws((5, 3), seed + 90, 9)
    path = shortest_paths.cheapest(cost)
    assert np.abs(np.diff(path)).max() <= 1
    assert cost[np.arange(5), path].sum() == naive.cheapest_cost(cost) == shortest_paths.accumulate(cost, 0)[-1].min()
    cut = shortest_paths.least_cut(cost, gap)
    assert naive.cut_cost(cost, gap, cut) == naive.least_cut_cost(cost, gap)


@pytest.mark.parametrize("seed", range(12))
def test_chains_are_the_best(seed: int) -> None:
    """Without the cost of early returns, which only looks back, the chain is the best of all."""
    length, sizes = 17, 3 + draws(3, seed, 5)
    start, joint = draws((3, length + 1), seed + 20, 30), draws(length + 1, seed + 40, 30)
    pair, closing = draws((3, 3), seed + 60, 30), draws(3, seed + 80, 30)
    rules = np.array([seed % 3, seed % 2, 2, 25, 0, -1], np.int64)
    out = np.empty((length + 2, 3), np.int64)
    n = wall_kernels.best_chain(length, sizes, start, joint, pair, closing, rules, out)
    chain = out[:n]
    assert chain[0, 1] == 0
    assert chain[-1, 2] == length
    assert (chain[1:, 1] == chain[:-1, 2]).all()
    is_cut = bool(chain[-1, 2] - chain[-1, 1] < sizes[chain[-1, 0]] - 1 or n == 1)
    arguments = (length, sizes, start, joint, pair, closing, rules)
    names = tuple(int(k) for k in chain[:, 0])
    cost = min(naive.chain_cost((names, c), *arguments) for c in ({is_cut, True, False}))
    assert cost == naive.best_chain_cost(*arguments)


def scene_of(seed: int):
    picture = texture(24, 40, 2, seed).astype(np.int16)
    usable = np.ones((24, 40), bool)
    usable[3, 5] = False
    joints = np.stack([np.full(24, 12), 25 + np.arange(24) // 9]).astype(np.int64)
    beds = np.stack([np.full(40, 4), np.full(40, 15)]).astype(np.int64)
    return picture, usable, draws((24, 40), seed, 200), beds, joints, np.array([2, 1], np.int64)


@pytest.mark.parametrize("kinds", [(1, 0), (-1, 0), (1, -1)])
def test_pieces_are_cut_as_their_twins(kinds: tuple[int, int]) -> None:
    scene = scene_of(sum(kinds) + 5)
    left = np.array([0, 14, 11, 2, 0, -1, kinds[0], 0, 25, 0], np.int64)
    right = np.array([14, 30, -2, 1, 0, kinds[1], -1, 12, 30, 0], np.int64)
    cost, gap = naive.junction_costs(scene, left, right, 1, 16, 4)
    cut = np.empty(16, np.int64)
    wall_kernels.cut_head_joint(scene, left, right, 1, cut, 4)
    np.testing.assert_array_equal(cut, 10 + shortest_paths.least_cut(cost, gap))
    rows = np.full(30, 1, np.int64)
    spans = np.array([[0, 1, 0], [1, 16, 4]], np.int64)
    out, wrong = np.empty((16, 30, 2), np.int32), np.empty((16, 30), np.int64)
    wall_kernels.place_course(scene, np.stack([left, right]), rows, spans, out, wrong)
    for v in range(16):
        for x in range(30):
            piece = left if x < cut[v] else right
            y, z = 1 + v + piece[3], x + piece[2]
            assert tuple(out[v, x]) == (y, z)
            usable = 0 <= y < 24 and 0 <= z < 40 and scene[1][y, z]
            beyond = usable and not scene[3][0, z] <= y < scene[3][1, z]
            assert wrong[v, x] == (naive.UNREADABLE if not usable else beyond * (scene[2][y, z] + naive.STEP))


def test_beds_are_cut_and_poured_as_their_twins() -> None:
    scene = scene_of(3)
    upper = (draws((12, 9, 2), 1, 24).astype(np.int32), draws((12, 9), 2, 99))
    lower = (draws((12, 9, 2), 3, 24).astype(np.int32), draws((12, 9), 4, 99))
    shift = draws(9, 5, 3) + 3
    costs = wall_kernels.bed_costs(scene, upper, lower, shift, 2)
    for mine, theirs in zip(costs, naive.part(scene, upper, lower, shift, 2), strict=True):
        np.testing.assert_array_equal(mine, theirs)
    out = np.zeros((14, 8, 2), np.int32)
    top, end = draws(9, 6, 3), 8 + draws(9, 7, 3)
    wall_kernels.write_course(upper[0], shift, top, end, out, -2)
    for y in range(14):
        for u in range(8):
            x = u + 2
            v = y - shift[x] if x < 9 else -1
            shown = x < 9 and top[x] <= v < end[x]
            assert tuple(out[y, u]) == (tuple(upper[0][v, x]) if shown else (0, 0))
