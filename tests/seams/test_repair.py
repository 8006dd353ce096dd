"""The worst seams of a finished map are covered anew, and nothing else is harmed by it."""

from __future__ import annotations

import json
import threading
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from analysis.naive_masking import visibility
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from laws import replayed
from seams.naive_recut import NaiveMap

import intarsia as ia
from intarsia.analysis import features, variance
from intarsia.cli import cli
from intarsia.methods import METHODS, keeps_lattice, make
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE, SourceMap, identity
from intarsia.patches import patch_synthesis as patches_growth
from intarsia.patches.patch_synthesis import PatchSettings, seam_threshold
from intarsia.seams.graphcut_textures import Cut, GraphcutMap, GraphcutSettings
from intarsia.seams.repair import Constraints, Repair, SeamRefinement, from_start, repaired
from intarsia.seams.worst_seams import WorstSeams
from intarsia.synthesis import Synthesis
from intarsia.tasks.repair import repair_of, repaired_with_statistics
from intarsia.testing import looked_up, texture

QUILTING = ia.ImageQuilting(patch=12, overlap=4)
SAMPLING = ia.PatchSampling(patch=10, overlap=2)
ONE = ia.Run(1)


def naive_total(made: Synthesis) -> int:
    """What all seams of an upright map cost by the price `sharp`, pair by pair."""
    pictures = features.features(made.exemplars).pictures
    knee = seam_threshold(max(variance(p, e.usable) for p, e in zip(pictures, made.exemplars, strict=True)))
    usable = [np.ones((e.height, e.width), bool) if e.usable is None else e.usable for e in made.exemplars]
    seen = [visibility(p, knee, e.usable, e.toroidal) for p, e in zip(pictures, made.exemplars, strict=True)]
    smap, which = made.map, np.zeros((made.map.height, made.map.width), int)
    which = which if smap.which is None else smap.which
    naive = NaiveMap(list(pictures), usable, [e.toroidal for e in made.exemplars], (smap.height, smap.width),
                     (smap.wrap.y, smap.wrap.x), threshold=knee, visible=seen)  # fmt: skip
    return naive.total({
        (y, x): (int(which[y, x]), int(smap.yx[y, x, 0]), int(smap.yx[y, x, 1]))
        for y, x in product(range(smap.height), range(smap.width))
    })  # fmt: skip


def exemplars(seed: int, several: bool, masked: bool) -> list[Exemplar]:
    usable = np.ones((34, 38), bool)
    usable[5:8, 25:] = not masked
    first = Exemplar.of(texture(34, 38, 3, seed), usable=usable if masked else None)
    return [first, Exemplar.of(texture(30, 31, 3, seed + 1))] if several else [first]


@given(st.integers(0, 99), st.sampled_from(["none", "x", "both"]), st.booleans(), st.booleans(), st.booleans())
def test_seams_never_become_dearer_and_the_books_are_kept(
    seed: int, wrap: str, several: bool, masked: bool, feathered: bool
) -> None:
    """The totals told are those that the slow twin counts in both maps; all pixels may be shown."""
    made = ia.synthesize(
        exemplars(seed, several, masked), (44, 50), SAMPLING if feathered else QUILTING, seed=seed, wrap=wrap, run=ONE
    )
    out, done = repaired_with_statistics(made, 3, ONE)
    assert done.before == naive_total(made)
    assert done.after == naive_total(out)
    assert done.after < done.before if done.patches else done.after == done.before
    assert (out.map.digest == made.map.digest) == (done.patches == 0)
    assert not out.map.holes.any()
    assert out.render(feather=0).pixels.tobytes() == looked_up(made.exemplars, out.map).tobytes()
    first = made.exemplars[0].usable
    if first is not None:
        mine = out.map.yx[out.map.which == 0] if several else out.map.yx.reshape(-1, 2)
        assert first[mine[:, 0], mine[:, 1]].all()


def test_most_maps_are_bettered_much() -> None:
    """A law that holds where nothing happens says little: here the seams of the baseline fall by a third."""
    made = ia.synthesize("sample:stones", (200, 200), ia.RandomTiling(patch=48), seed=1, run=ONE)
    _, done = repaired_with_statistics(made, 4, ONE)
    assert done.after < 0.67 * done.before


@pytest.mark.parametrize("isometries", ["none", "both"])
def test_threads_change_no_byte(isometries: str) -> None:
    """Law 4, in all poses too."""
    method = ia.ImageQuilting(patch=12, overlap=4, isometries=isometries)
    made = ia.synthesize(texture(40, 40, 3, 5), (70, 66), method, seed=2, wrap="y", run=ONE)
    outs = [repaired_with_statistics(made, 3, ia.Run(n)) for n in (1, 2, 4)]
    assert len({out.map.digest for out, _ in outs}) == 1
    assert outs[0][1].patches > 0
    again = SeamRefinement(repair_of(outs[0][0].method, made.exemplars, 1), made.exemplars, Canvas(70, 66, ia.Wrap.Y),
                      outs[0][0].map)  # fmt: skip
    assert again.sewn.total == outs[0][1].after


def test_the_wrapped_border_stays_as_good_as_the_inside() -> None:
    """Law 6, by pixels, and by the seams that run along the border and along the lines inside."""
    border, worst, seams, inside = np.zeros((4, 2))
    for seed in range(6):
        made = ia.synthesize(texture(40, 36, 1, seed), (48, 54), QUILTING, seed=seed, wrap="both", run=ONE)
        out = ia.repair(made, 4, run=ONE)
        pixels = out.render(feather=0).samples[:, :, 0].astype(float)
        assert made.canvas is not None
        work = SeamRefinement(repair_of(made.method, made.exemplars, 1), made.exemplars, made.canvas, out.map)
        for axis in (0, 1):
            steps = np.abs(np.roll(pixels, -1, axis) - pixels).mean(axis=1 - axis)
            border[axis] += steps[-1]
            worst[axis] += steps[:-1].max()
            lines = work.sewn.prices[:, :, 1 - axis].sum(axis=1 - axis)
            seams[axis] += lines[-1]
            inside[axis] += lines[:-1].max()
    assert (border <= 1.1 * worst).all()
    assert (seams <= inside).all()


def test_what_was_given_stays() -> None:
    """Law 7: of a start map, an extended and a healed picture every pixel that was kept is kept."""
    e = Exemplar.of(texture(48, 52, 3, 8))
    start = ia.synthesize(e, (60, 60), QUILTING, seed=1, run=ONE).map
    which = np.zeros((60, 60), np.uint8)
    which[20:44, 14:60] = HOLE
    begun = SourceMap(start.yx, which, None, start.sources)
    hole = np.zeros((48, 52), bool)
    hole[12:40, 16:44] = True
    for made in (
        ia.synthesize(e, None, QUILTING, start=begun, seed=3, run=ONE),
        ia.extend(e, ia.Margins(right=30, bottom=20), QUILTING, seed=3, run=ONE),
        ia.heal(e, hole, ia.PatchSampling(patch=10, overlap=2), seed=2, run=ONE),
    ):
        assert made.canvas is not None
        was = made.canvas.start
        assert was is not None
        stays = from_start(was, made.map)
        assert stays.sum() > 100
        out, done = repaired_with_statistics(made, 6, ONE)
        assert done.patches, "else nothing is tested"
        assert (out.map.yx[stays] == was.yx[stays]).all()
        if "heal" in made.recipe:
            assert (np.asarray(out)[~hole] == np.asarray(e.base)[~hole]).all()


def test_labels_are_followed_as_before() -> None:
    """Under a guide no pixel follows it less well: of labels, none becomes wrong; of a picture, none is further off."""
    rng = np.random.default_rng(1)
    pixels = texture(60, 60, 3, 2)
    labels = np.repeat((np.arange(60) > 28).astype(np.uint8)[:, None], 60, 1)
    target = np.repeat((np.arange(84) > 38).astype(np.uint8)[None], 80, 0)
    label_guide = ia.Guide(ia.Plane(labels, ia.Kind.LABEL), ia.Plane(target, ia.Kind.LABEL))
    gray = rng.integers(0, 255, (80, 84)).astype(np.uint8)
    light = ia.Guide(ia.Plane(pixels[..., 0].copy()), ia.Plane(gray))
    for guide, plane, wanted in ((label_guide, labels, target), (light, pixels[..., 0], gray)):
        made = ia.synthesize(pixels, (80, 84), ia.ImageQuilting(patch=12, overlap=4), guide=guide, run=ONE)
        out, done = repaired_with_statistics(made, 6, ONE)
        assert done.patches
        before, after = (plane[m.yx[..., 0], m.yx[..., 1]].astype(int) for m in (made.map, out.map))
        if guide is label_guide:
            assert ((after == wanted) | (after == before)).all()
        else:
            assert (abs(after - wanted) <= abs(before - wanted)).all()


@pytest.mark.parametrize("wrap", ["none", "both"])
@pytest.mark.parametrize("isometries", ["none", "both"])
def test_no_pixel_returns_nearer_than_it_may(wrap: str, isometries: str) -> None:
    """What a least distance forbids, a repair does not bring back; counted pair by pair."""
    method = ia.ImageQuilting(patch=10, overlap=3, min_repeat_distance=16, isometries=isometries)
    made = ia.synthesize(texture(56, 60, 3, 4), (50, 54), method, seed=3, wrap=wrap, run=ONE)
    out, done = repaired_with_statistics(made, 5, ONE)
    assert done.patches
    for smap in (made.map, out.map):
        places: dict[tuple[int, ...], list[tuple[int, int]]] = {}
        for y, x in product(range(50), range(54)):
            places.setdefault(tuple(smap.yx[y, x].tolist()), []).append((y, x))
        nearest = 1 << 20
        for found in places.values():
            for n, (a, b) in enumerate(found):
                for c, d in found[:n]:
                    dy, dx = abs(a - c), abs(b - d)
                    if wrap == "both":
                        dy, dx = min(dy, 50 - dy), min(dx, 54 - dx)
                    nearest = min(nearest, dy * dy + dx * dx)
        assert nearest >= 16**2


@pytest.mark.parametrize("distance", [0, 60])
def test_patches_of_one_pass_heed_each_other(distance: int) -> None:
    """Two equal defects 40 px apart want the same patch in the same pass; within 60 px only one may have it."""
    e = Exemplar.of(texture(64, 40, 3, 2), toroidal=True)
    y, x = np.mgrid[:64, :80]
    right = np.stack([y, x % 40], axis=2)
    yx = right.copy()
    for left in (16, 56):
        yx[24:32, left : left + 8] = (right[24:32, left : left + 8] + (-20, 30)) % (64, 40)
    smap = SourceMap(yx, None, None, (e.source,))
    done = repaired(Repair((24, 24), 1, distance=distance), [e], Canvas(64, 80), smap, ONE)
    whole = [bool((done.map.yx[24:32, left : left + 8] == right[24:32, left : left + 8]).all()) for left in (16, 56)]
    assert whole == ([True, True] if not distance else [True, False])


def test_what_a_pass_works_on_is_its_own() -> None:
    """What the cut of one window reads no other changes, and what was barred for one patch is free for the next."""
    e = Exemplar.of(texture(40, 40, 3, 3))
    made = ia.synthesize(e, (90, 96), QUILTING, seed=1, wrap="x", run=ONE)
    work = SeamRefinement(Repair((12, 14), 1, distance=20), [e], Canvas(90, 96, ia.Wrap.X), made.map)
    wave = work.worst.apart(work.sewn.around)
    assert len(wave) > 4
    read = np.zeros((90, 96), int)
    for y, x in wave.values():
        rows = np.clip(np.arange(y - work.sewn.stitch.margin - 1, y + 12 + work.sewn.stitch.margin + 1), 0, 89)
        columns = np.arange(x - work.sewn.stitch.margin - 1, x + 14 + work.sewn.stitch.margin + 1) % 96
        read[np.ix_(np.unique(rows), columns)] += 1
    assert read.max() == 1
    work.growth.growing.locked[40:44] = True
    before = work.growth.growing.locked.copy()
    assert work.cover(wave, ONE, lambda begin: None)
    assert (work.growth.growing.locked == before).all()


def test_a_repair_ends() -> None:
    """Every patch saves something; a place where none does is left, until there is no place to look at."""
    made = ia.synthesize(texture(30, 30, 3, 6), (40, 44), QUILTING, run=ONE)
    passes: list[int] = []
    out, done = repaired_with_statistics(made, 1000, ia.Run(1, lambda now, total, draft: passes.append(now)))
    assert 4 < len(passes) < 500
    assert passes[-1] == 1000
    assert done.before - done.after >= done.patches > 4
    assert naive_total(out) == done.after


@given(st.integers(0, 999))
def test_bars_are_those_of_looking_pixel_by_pixel(seed: int) -> None:
    """Which pixels of a patch may not be taken: the same as by comparing each with each."""
    rng = np.random.default_rng(seed)
    toroidal, wrap = bool(rng.integers(2)), ia.Wrap(rng.choice(["none", "x", "both"]))
    e = Exemplar.of(texture(18, 20, 1, seed), toroidal=toroidal)
    yx = np.stack([rng.integers(0, 18, (22, 24)), rng.integers(0, 20, (22, 24))], 2).astype(np.int32)
    smap = SourceMap(yx, None, None, (e.source,), wrap)
    growth = patches_growth.PatchSynthesis(PatchSettings((6, 6), (2, 2), rim=1), [e], Canvas(22, 24, wrap, smap))
    sewn = GraphcutMap(growth, GraphcutSettings(), Constraints(growth, None, 5))
    box, pick = (int(rng.integers(14)), int(rng.integers(15)), 8, 9), (0, 3, 7)
    want = np.zeros((8, 9), bool)
    for i, j in product(range(8), range(9)):
        mine = (pick[1] + i) % 18, (pick[2] + j) % 20
        for y, x in product(range(22), range(24)):
            dy, dx = abs(y - box[0] - i), abs(x - box[1] - j)
            dy, dx = min(dy, 22 - dy) if wrap.y else dy, min(dx, 24 - dx) if wrap.x else dx
            want[i, j] |= tuple(yx[y, x]) == mine and 0 < dy * dy + dx * dx < 25
    assert sewn.constraint is not None
    assert (sewn.constraint(box, pick) == want).all()
    assert sewn.pays(Cut(0, box, pick, want.astype(np.uint8))) == (not want.any())
    assert sewn.pays(Cut(0, box, pick, ~want))


@pytest.mark.parametrize("wraps", [(False, False), (True, False), (True, True)])
def test_windows_of_a_pass_lie_apart_worst_first(wraps: tuple[bool, bool]) -> None:
    """Every window that is left out is too near to a worse one, or has no seam."""
    rng = np.random.default_rng(5)
    prices = (rng.integers(0, 99, (150, 133, 2)) * (rng.random((150, 133, 2)) < 0.02)).astype(np.int32)
    worst = WorstSeams(prices, (24, 20), wraps)
    found = worst.apart(9)
    assert len(found) > 6

    def near(a: tuple[int, int], b: tuple[int, int]) -> bool:
        gaps = [abs(p - q) for p, q in zip(a, b, strict=True)]
        gaps = [min(g, n - g) if w else g for g, n, w in zip(gaps, prices.shape, wraps, strict=False)]
        return gaps[0] < 24 + 9 and gaps[1] < 20 + 9

    cells, taken = list(found), list(found.values())
    costs = worst.scores()
    scores = [int(costs[c]) for c in cells]
    assert scores == sorted(scores, reverse=True)
    for n, at in enumerate(taken):
        assert not any(near(at, other) for other in taken[:n])
    for cell in np.ndindex(*worst.shape):
        place = worst._first(0, cell[0]), worst._first(1, cell[1])
        if cell not in found and costs[cell] > 0:
            assert any(near(place, t) for t, s in zip(taken, scores, strict=True) if s >= costs[cell])
    for cell in cells:
        worst.give_up(cell)
    assert not set(cells) & set(worst.apart(9))


def test_a_continued_exemplar_is_found_again() -> None:
    """A block moved within the exemplar is put back where it fits: no seam is left."""
    e = Exemplar.of(texture(64, 64, 3, 3))
    yx = identity([e.source], 0).yx.copy()
    yx[30:36, 28:35] -= 11
    made = Synthesis((e,), SourceMap(yx, None, None, (e.source,)), ia.Blend(0), ia.ImageQuilting(patch=24, overlap=8))
    assert naive_total(made) > 0
    out, done = repaired_with_statistics(made, 4, ONE)
    assert done.after == naive_total(out) == 0


@pytest.mark.parametrize("slug", METHODS)
def test_every_method_is_repaired_or_refused(slug: str) -> None:
    """Methods that keep a lattice are refused in one line, all others go; the recipe repeats the repair."""
    e, small = Exemplar.of(texture(40, 40, 3, 6)), {"lattice": ((8.0, 0.0), (0.0, 8.0))}
    method = make(slug, small if slug in ("best-tile", "near-regular", "gap-filling") else {})
    made = Synthesis((e,), identity([e.source], 0), ia.Blend(0), method)
    if keeps_lattice(method):
        assert slug in ("best-tile", "near-regular", "gap-filling")
        with pytest.raises(ia.ParameterError, match="keeps a lattice"):
            ia.repair(made)
        return
    grown = ia.synthesize(e, (52, 50), method, seed=1, run=ONE)
    out = ia.repair(grown, 2, run=ONE)
    assert json.loads(out.recipe_text)["repair"] == 2
    assert replayed(out.recipe_text, [e]).map.digest == out.map.digest
    with pytest.raises(ia.ParameterError, match="repaired already"):
        ia.repair(out)


def test_passes_and_nothing_to_do() -> None:
    e = Exemplar.of(texture(40, 40, 3, 6))
    made = ia.synthesize(e, (60, 60), QUILTING, run=ONE)
    assert ia.repair(made, 0, run=ONE).map.digest == made.map.digest
    for wrong in (-1, 1001, 1.5, True):
        with pytest.raises(ia.ParameterError, match="repair="):
            ia.repair(made, wrong)  # type: ignore[arg-type]
    smap = identity([e.source], 0)
    which = np.zeros((40, 40), np.uint8)
    which[3, 4] = HOLE
    with pytest.raises(ia.InputError, match="the map has holes"):
        ia.repair(Synthesis((e,), SourceMap(smap.yx, which, None, smap.sources), ia.Blend(0), QUILTING))
    other = Exemplar.of(texture(30, 30, 3, 6))
    with pytest.raises(ia.InputError, match="other sizes"):
        ia.repair(Synthesis((other,), smap, ia.Blend(0), QUILTING))
    whole = Synthesis((e,), smap, ia.Blend(0), QUILTING)
    assert repaired_with_statistics(whole, 3, ONE)[1].patches == 0
    more = [repaired_with_statistics(made, n, ONE)[1].after for n in (1, 2, 3, 4)]
    assert more == sorted(more, reverse=True)


def test_cancelling_stops_at_every_pass() -> None:
    """Law 12; drafts have the canvas's size and no hole."""
    made = ia.synthesize(texture(40, 40, 3, 6), (60, 60), QUILTING, run=ONE)
    event, told = threading.Event(), list[tuple[int, int]]()

    def step(done: int, total: int, draft: object) -> None:
        told.append((done, total))
        assert callable(draft)
        assert not draft().holes.any()
        if len(told) == 2:
            event.set()

    with pytest.raises(ia.CancelledError):
        ia.repair(made, 5, run=ia.Run(1, step, event))
    assert told == [(0, 5), (1, 5)]


def test_a_repair_of_large_patches_on_a_small_canvas() -> None:
    """Windows are at most as large as the canvas, and wrap around it once."""
    for wrap in ("none", "both"):
        made = ia.synthesize(texture(40, 40, 3, 6), (20, 17), ia.ImageQuilting(patch=12, overlap=4), wrap=wrap, run=ONE)
        repair, canvas = Repair((30, 30), 3), made.canvas
        assert canvas is not None
        done = repaired(repair, made.exemplars, canvas, made.map, ONE)
        assert done.after <= done.before


class TestCommand:
    @pytest.fixture(autouse=True)
    def _folder(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        ia.write("e.png", ia.Plane(texture(40, 44, 3, 9)))

    def run(self, *words: str) -> object:
        result = CliRunner().invoke(cli, list(words))
        assert result.exit_code == 0, result.stderr
        return json.loads(result.stdout) if "--json" in words else result

    def test_grow_and_replay(self) -> None:
        method = ("--method", "image-quilting", "--patch", "12")
        told = self.run("grow", "e.png", "-o", "a.png", "--size", "60", *method, "--repair", "2", "--json")
        assert told["repair"]["passes"] == 2
        assert 0 < told["repair"]["seams"] < 1
        made = ia.repair(ia.synthesize("e.png", 60, ia.ImageQuilting(patch=12)), 2)
        assert (np.asarray(made) == np.asarray(ia.read("a.png").base)).all()
        self.run("replay", "a.png", "-o", "b.png", "-e", "e.png")
        assert Path("a.png").read_bytes() == Path("b.png").read_bytes()

    def test_extend_heal_and_paint(self) -> None:
        hole = np.zeros((40, 44), np.uint8)
        hole[10:30, 12:30] = 255
        ia.write("hole.png", ia.Plane(hole))
        labels = np.where(np.arange(44) > 20, 255, 0).astype(np.uint8)
        ia.write("l.png", ia.Plane(np.repeat(labels[None], 40, 0)))
        ia.write("t.png", ia.Plane(np.repeat(np.repeat(labels, 2)[None, :80], 70, 0)))
        again = ("-o", "again.png", "-q", "--force", "-e", "e.png")
        for words, more in (
            (("extend", "e.png", "--right", "30", "--patch", "10"), ()),
            (("heal", "e.png", "--mask", "hole.png", "--patch", "10"), ("--mask", "hole.png")),
            (("paint", "e.png", "-l", "l.png", "-t", "t.png", "--patch", "10"), ("-l", "l.png", "-t", "t.png")),
        ):
            told = self.run(*words, "-o", "out.png", "--repair", "3", "--json", "--force")
            assert told["repair"]["patches"] > 0 or words[0] == "heal", words  # what is healed was covered anew already
            self.run("replay", "out.png", *again, *more)
            assert Path("out.png").read_bytes() == Path("again.png").read_bytes()

    def test_what_keeps_a_lattice(self) -> None:
        """Named, it is refused before any work; chosen, it is left as it is, and that is said."""
        words = ["grow", "sample:tiles", "-o", "x.png", "--size", "100", "--repair", "2", "--method"]
        result = CliRunner().invoke(cli, [*words, "near-regular"])
        assert result.exit_code == 2
        assert result.stderr.count("\n") == 1
        assert "keeps a lattice" in result.stderr
        assert not Path("x.png").exists()
        result = CliRunner().invoke(cli, [*words, "auto", "--explain"])
        assert result.exit_code == 0
        assert "nothing was repaired" in result.stderr
        assert "--repair" not in result.output.split("command")[-1]
