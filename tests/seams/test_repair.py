"""The worst seams of a finished map are covered anew, and nothing else is harmed by it."""

from __future__ import annotations

import json
import threading
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from laws import replayed
from seams.naive_recut import naive_total

import intarsia as ia
from intarsia.analysis import features, variance
from intarsia.cli import cli
from intarsia.kernels.cuts import SeamPrice
from intarsia.methods import METHODS, keeps_lattice, make
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE, SourceMap, identity
from intarsia.patches import patch_synthesis as patches_growth
from intarsia.patches.patch_synthesis import PatchSettings, seam_threshold
from intarsia.seams.graphcut_textures import GraphcutMap, GraphcutSettings
from intarsia.seams.repair import Repair, SeamRefinement, from_start, keeping_guide, repaired
from intarsia.synthesis import Synthesis
from intarsia.tasks.repair import repair_of, repaired_with_statistics
from intarsia.testing import looked_up, texture

QUILTING = ia.ImageQuilting(patch=12, overlap=4)
SAMPLING = ia.PatchSampling(patch=10, overlap=2)
ONE = ia.Run(1)


def total(made: Synthesis) -> int:
    """What all seams of an upright map cost by the price `sharp`, pair by pair."""
    pictures = features.features(made.exemplars).pictures
    spread = [variance(p, e.usable) for p, e in zip(pictures, made.exemplars, strict=True)]
    return naive_total(made.exemplars, made.map, SeamPrice(threshold=seam_threshold(max(spread))))


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
    assert done.before == total(made)
    assert done.after == total(out)
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
    method = ia.ImageQuilting(patch=12, overlap=4, isometries=isometries)
    made = ia.synthesize(texture(40, 40, 3, 5), (70, 66), method, seed=2, wrap="y", run=ONE)
    outs = [repaired_with_statistics(made, 3, ia.Run(n)) for n in (1, 2, 4)]
    assert len({out.map.digest for out, _ in outs}) == 1
    assert outs[0][1].patches > 0
    again = SeamRefinement(repair_of(outs[0][0].method, made.exemplars, 1), made.exemplars, Canvas(70, 66, ia.Wrap.Y),
                      outs[0][0].map)  # fmt: skip
    assert again.sewn.total == outs[0][1].after


def test_what_was_given_stays() -> None:
    """Law 7: of a start map, an extended and a healed picture every pixel that was kept is kept."""
    e = Exemplar.of(texture(48, 52, 3, 8))
    which, hole = np.zeros((60, 60), np.uint8), np.zeros((48, 52), bool)
    which[20:44, 14:60], hole[12:40, 16:44] = HOLE, True
    begun = replace(ia.synthesize(e, (60, 60), QUILTING, seed=1, run=ONE).map, which=which)
    for made in (
        ia.synthesize(e, None, QUILTING, start=begun, seed=3, run=ONE),
        ia.extend(e, ia.Margins(right=30, bottom=20), QUILTING, seed=3, run=ONE),
        ia.heal(e, hole, SAMPLING, seed=2, run=ONE),
    ):
        was = made.canvas.start if made.canvas else None
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


def test_what_a_pass_works_on_is_its_own() -> None:
    """What the cut of one window reads no other changes, and what is locked stays so."""
    e = Exemplar.of(texture(40, 40, 3, 3))
    made = ia.synthesize(e, (90, 96), QUILTING, seed=1, wrap="x", run=ONE)
    work = SeamRefinement(Repair((12, 14), 1), [e], Canvas(90, 96, ia.Wrap.X), made.map)
    wave = work.worst.apart(work.sewn.around)
    assert len(wave) > 4
    read, more = np.zeros((90, 96), int), work.sewn.stitch.margin + 1
    for y, x in wave.values():
        rows, columns = np.clip(np.arange(y - more, y + 12 + more), 0, 89), np.arange(x - more, x + 14 + more) % 96
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
    assert total(out) == done.after


@given(st.integers(0, 999))
def test_bars_are_those_of_looking_pixel_by_pixel(seed: int) -> None:
    rng = np.random.default_rng(seed)
    toroidal, wrap = bool(rng.integers(2)), ia.Wrap(rng.choice(["none", "x", "both"]))
    e = Exemplar.of(texture(18, 20, 1, seed), toroidal=toroidal)
    yx = np.stack([rng.integers(0, 18, (22, 24)), rng.integers(0, 20, (22, 24))], 2).astype(np.int32)
    smap = SourceMap(yx, None, None, (e.source,), wrap)
    growth = patches_growth.PatchSynthesis(PatchSettings((6, 6), (2, 2), rim=1), [e], Canvas(22, 24, wrap, smap))
    labels, target = (rng.integers(0, 3, size).astype(np.uint8) for size in ((18, 20), (22, 24)))
    kind = ia.Kind.LABEL if rng.integers(2) else ia.Kind.DATA
    bar = keeping_guide(growth, ia.Guide(ia.Plane(labels, kind), ia.Plane(target, kind)))
    sewn = GraphcutMap(growth, GraphcutSettings(), bar)
    box, pick = (int(rng.integers(14)), int(rng.integers(15)), 8, 9), (0, 3, 7)
    want = np.zeros((8, 9), bool)
    for i, j in product(range(8), range(9)):
        y, x = box[0] + i, box[1] + j
        new, old = labels[(pick[1] + i) % 18, (pick[2] + j) % 20], labels[tuple(yx[y, x])]
        off = [abs(int(label) - int(target[y, x])) for label in (new, old)]
        want[i, j] = min(off[0], 1) > min(off[1], 1) if kind is ia.Kind.LABEL else off[0] > off[1]
    assert (sewn.constraint(box, pick) == want).all()


def test_a_continued_exemplar_is_found_again() -> None:
    e = Exemplar.of(texture(64, 64, 3, 3))
    yx = identity([e.source], 0).yx.copy()
    yx[30:36, 28:35] -= 11
    made = Synthesis((e,), SourceMap(yx, None, None, (e.source,)), ia.Blend(0), ia.ImageQuilting(patch=24, overlap=8))
    assert total(made) > 0
    out, done = repaired_with_statistics(made, 4, ONE)
    assert done.after == total(out) == 0


@pytest.mark.parametrize("slug", METHODS)
def test_every_method_is_repaired_or_refused(slug: str) -> None:
    """Methods that keep a lattice are refused in one line, all others go; the recipe repeats the repair."""
    e, small = Exemplar.of(texture(40, 40, 3, 6)), {"lattice": ((8.0, 0.0), (0.0, 8.0))}
    method = make(slug, small if slug in ("best-tile", "near-regular", "gap-filling") else {})
    if keeps_lattice(method):
        assert slug in ("best-tile", "near-regular", "gap-filling")
        with pytest.raises(ia.ParameterError, match="keeps a lattice"):
            ia.repair(Synthesis((e,), identity([e.source], 0), ia.Blend(0), method))
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
    holed = replace(smap, which=np.where(np.arange(1600).reshape(40, 40) == 124, HOLE, 0).astype(np.uint8))
    for shown, on, said in ((e, holed, "the map has holes"), (Exemplar.of(texture(30, 30, 3, 6)), smap, "other sizes")):
        with pytest.raises(ia.InputError, match=said):
            ia.repair(Synthesis((shown,), on, ia.Blend(0), QUILTING))
    assert repaired_with_statistics(Synthesis((e,), smap, ia.Blend(0), QUILTING), 3, ONE)[1].patches == 0
    more = [repaired_with_statistics(made, n, ONE)[1].after for n in (1, 2, 3, 4)]
    assert more == sorted(more, reverse=True)


def test_cancelling_stops_at_every_pass() -> None:
    made, event = ia.synthesize(texture(40, 40, 3, 6), (60, 60), QUILTING, run=ONE), threading.Event()
    told = list[tuple[int, int]]()

    def step(done: int, total: int, draft: object) -> None:
        told.append((done, total))
        assert not draft().holes.any()
        if len(told) == 2:
            event.set()

    with pytest.raises(ia.CancelledError):
        ia.repair(made, 5, run=ia.Run(1, step, event))
    assert told == [(0, 5), (1, 5)]


def test_a_repair_of_large_patches_on_a_small_canvas() -> None:
    for wrap in ("none", "both"):
        made = ia.synthesize(texture(40, 40, 3, 6), (20, 17), ia.ImageQuilting(patch=12, overlap=4), wrap=wrap, run=ONE)
        done = repaired(Repair((30, 30), 3), made.exemplars, made.canvas, made.map, ONE)
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
        for verb, own, more in (("extend", "--right 30", ""), ("heal", "", "--mask hole.png"),
                                ("paint", "", "-l l.png -t t.png")):  # fmt: skip
            made = "e.png", *f"{own} {more}".split(), "--patch", "10", "-o", "out.png", "--repair", "3"
            told = self.run(verb, *made, "--json", "--force")
            assert told["repair"]["patches"] > 0 or verb == "heal"  # what is healed was covered anew already
            self.run("replay", "out.png", *again, *more.split())
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
