"""Tests that every method has to pass; a new one is tested by naming it.

    from intarsia.testing import MethodContract

    class TestMyMethod(MethodContract):
        method = MyMethod(patch=12)

pytest then runs every law of the package that the method's ``supports`` claims, on small exemplars of all kinds
that hypothesis draws. What it does not claim must be refused. Needs pytest and hypothesis.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt

from .canvas import Canvas
from .errors import CancelledError, ParameterError
from .exemplar import Exemplar
from .geometry import ISOMETRIES, Box, Wrap
from .guide import Guide
from .image import Kind, Plane, Transfer
from .methods.base import Ability, Method, make
from .params import extent, parameters
from .run import Run
from .sourcemap import HOLE, Blend, SourceMap, identity
from .synthesis import Synthesis, synthesize

SEEDS = st.integers(0, 2**64 - 1)
WRAPS = st.sampled_from(list(Wrap))

Array = NDArray[Any]


def noise(height: int, width: int, seed: int) -> NDArray[np.uint64]:
    """Return 64 mixed bits for every pixel, the same on every machine."""
    y, x = np.mgrid[:height, :width].astype(np.uint64)
    z = (np.uint64(seed % 2**32) << np.uint64(24)) + y * np.uint64(0x9E3779B97F4A7C15) + x * np.uint64(0xD1B54A32D192ED03)
    for factor in (0xBF58476D1CE4E5B9, 0x94D049BB133111EB):
        z = (z ^ (z >> np.uint64(29))) * np.uint64(factor)
    return np.asarray(z ^ (z >> np.uint64(32)), np.uint64)


def texture(height: int, width: int, channels: int = 1, seed: int = 0) -> NDArray[np.uint8]:
    """Return a procedural texture (height, width, channels): soft blobs of some 6 px under a little noise."""
    layers = []
    for c in range(channels):
        cells = (noise(height // 6 + 2, width // 6 + 2, seed * 97 + c) >> np.uint64(56)).astype(np.int64)
        (y, v), (x, u) = (divmod(np.arange(n), 6) for n in (height, width))
        top = cells[np.ix_(y, x)] * (6 - u) + cells[np.ix_(y, x + 1)] * u
        low = cells[np.ix_(y + 1, x)] * (6 - u) + cells[np.ix_(y + 1, x + 1)] * u
        soft = (top * (6 - v)[:, None] + low * v[:, None]) // 36
        layers.append(np.clip(soft + (noise(height, width, seed * 89 + c) % np.uint64(9)).astype(np.int64) - 4, 0, 255))
    return np.stack(layers, axis=2).astype(np.uint8)


@st.composite
def exemplars(draw: DrawFn, *, masks: bool = True, least: int = 20, most: int = 40) -> Exemplar:
    """Draw an exemplar: uint8, uint16 or float32, of 1 to 5 channels, sometimes masked or toroidal."""
    return _exemplar(draw, _Make.drawn(draw), masks, least, most)


@dataclass(frozen=True)
class _Make:
    """What exemplars of one request have in common."""

    dtype: str
    channels: int

    @classmethod
    def drawn(cls, draw: DrawFn) -> _Make:
        return cls(draw(st.sampled_from(("uint8", "uint16", "float32"))), draw(st.integers(1, 5)))


def _exemplar(draw: DrawFn, kind: _Make, masks: bool, least: int, most: int) -> Exemplar:
    height, width = draw(st.integers(least, most)), draw(st.integers(least, most))
    pixels = as_depth(texture(height, width, kind.channels, draw(st.integers(0, 999))), kind.dtype)
    if kind.channels == 1 and draw(st.booleans()):
        pixels = pixels[:, :, 0]
    usable = None
    if masks and draw(st.booleans()):
        usable = np.ones((height, width), bool)
        usable[: draw(st.integers(0, 2)), :] = False
        usable[:, width - draw(st.integers(1, 3)) :] = False
    return Exemplar.of(pixels, usable=usable, toroidal=draw(st.booleans()))


def as_depth(pixels: NDArray[np.uint8], dtype: str) -> Array:
    """Return 8-bit pixels in another depth: 16 bits times 257, floats over 255."""
    if dtype == "uint16":
        return pixels.astype(np.uint16) * np.uint16(257)
    return pixels if dtype == "uint8" else (pixels / 255).astype(dtype)


@dataclass(frozen=True)
class Case:
    """One request to a method."""

    exemplars: tuple[Exemplar, ...]
    size: tuple[int, int]
    seed: int
    wrap: Wrap

    def grow(self, method: Method, **other: Any) -> Synthesis:
        """Run the method on it."""
        given = {"seed": self.seed, "wrap": self.wrap, "run": Run(threads=1)} | other
        return synthesize(self.exemplars, given.pop("size", self.size), method, **given)


@st.composite
def cases(draw: DrawFn, method: Method, *, least: int = 20, sizes: SearchStrategy[int] | None = None) -> Case:
    """Draw a request that the method claims to serve: several exemplars, masks and wraps only if it does."""
    kind, supports = _Make.drawn(draw), method.supports
    count = draw(st.integers(1, 2)) if Ability.SEVERAL in supports else 1
    given = [_exemplar(draw, kind, Ability.MASK in supports, least, least + 14) for _ in range(count)]
    side = st.integers(1, 45) if sizes is None else sizes
    wrap = draw(WRAPS) if Ability.WRAP in supports else Wrap.NONE
    return Case(tuple(given), (draw(side), draw(side)), draw(SEEDS), wrap)


def looked_up(exemplars: Sequence[Exemplar], smap: SourceMap, plane: str | None = None) -> Array:
    """Fetch every pixel of a map from its exemplar, one exemplar after the other: law 1 in plain words."""
    planes = [e.base if plane is None else e.planes[plane] for e in exemplars]
    out = np.zeros((smap.height, smap.width, planes[0].channels), planes[0].pixels.dtype)
    which = np.zeros(out.shape[:2], np.uint8) if smap.which is None else smap.which
    for number, p in enumerate(planes):
        mine = which == number
        out[mine] = p.samples[smap.yx[mine, 0], smap.yx[mine, 1]]
    return out if planes[0].pixels.ndim == 3 else out[:, :, 0]


def same_map(a: SourceMap, b: SourceMap) -> bool:
    """Say whether two maps show the same pixels in the same poses."""
    return a.digest == b.digest


def unbroken(smap: SourceMap, axis: int) -> NDArray[np.bool_]:
    """Say where a pixel and the next along an axis (the first after the last) continue one another."""
    which = np.zeros((smap.height, smap.width), np.uint8) if smap.which is None else smap.which
    pose = np.zeros((smap.height, smap.width), np.uint8) if smap.pose is None else smap.pose
    step = np.array([(i.j[0][axis], i.j[1][axis]) for i in ISOMETRIES])[pose]
    following = (np.roll(a, -1, axis) for a in (smap.yx, which, pose))
    yx, other, turned = following
    return np.asarray((yx == smap.yx + step).all(axis=2) & (other == which) & (turned == pose))


class MethodContract:
    """The laws of the package, as tests of one method; subclass it and name the ``method``.

    Attributes
    ----------
    method : Method
        With parameters that suit exemplars of 20 px a side; a patch of about 12.
    examples : int
        How many requests hypothesis draws for each law.
    least : int
        Shortest side, px, of the exemplars drawn.
    """

    method: ClassVar[Method]
    examples: ClassVar[int] = 10
    least: ClassVar[int] = 20

    # ---- what the laws use; a subclass may replace them -------------------------------------------------------

    def cases(self) -> SearchStrategy[Case]:
        """The requests on which the laws are tested."""
        return cases(self.method, least=self.least)

    def rim(self, exemplars: Sequence[Exemplar], size: tuple[int, int]) -> int:
        """How deep, in px, the method may replace what a start map holds: its overlap, 0 if it has none."""
        settled = self.method.settled(exemplars, Canvas(*size))
        return max(extent(getattr(settled, "overlap", 0)))

    def map_of_window(self, case: Case, box: Box) -> SourceMap:
        """Compute the map of a window alone, whatever lies around it; methods that claim WINDOW replace this."""
        raise NotImplementedError("a method that claims WINDOW says here how a window is computed alone")

    def for_all(self, law: Callable[[Case], None], examples: int | None = None) -> None:
        """Test a law on requests that hypothesis draws."""

        @settings(
            max_examples=examples or self.examples, deadline=None, derandomize=True, database=None,
            suppress_health_check=[HealthCheck.too_slow],
        )  # fmt: skip
        @given(self.cases())
        def check(case: Case) -> None:
            law(case)

        check()

    def claims(self, ability: Ability) -> None:
        """Skip the test of an ability that the method does not claim."""
        if ability not in self.method.supports:
            pytest.skip(f"{self.method.slug} does not claim {ability}")

    # ---- the laws, by their numbers in DESIGN 4 ---------------------------------------------------------------

    def test_every_pixel_is_a_usable_exemplar_pixel(self) -> None:
        """Law 1: without feather every output pixel is, bit for bit, the usable exemplar pixel that the map names."""

        def law(case: Case) -> None:
            out = case.grow(self.method)
            assert not out.map.holes.any()
            pixels = out.render(feather=0).pixels
            assert pixels.tobytes() == looked_up(case.exemplars, out.map).tobytes()
            which = np.zeros(case.size, np.uint8) if out.map.which is None else out.map.which
            for number, e in enumerate(case.exemplars):
                shown = out.map.yx[which == number]
                assert e.usable is None or e.usable[shown[:, 0], shown[:, 1]].all()

        self.for_all(law, 2 * self.examples)

    def test_size_type_and_channels_are_kept(self) -> None:
        """Law 2: the output has the size asked for, and depth, channels, kind and transfer of the exemplar."""

        def law(case: Case) -> None:
            out, base = case.grow(self.method).render(), case.exemplars[0].base
            assert (out.height, out.width) == case.size
            assert (out.pixels.dtype, out.pixels.ndim, out.channels) == (base.pixels.dtype, base.pixels.ndim, base.channels)
            assert (out.kind, out.transfer) == (base.kind, base.transfer)

        self.for_all(law)

    @pytest.mark.parametrize("feather", [0, 3])
    def test_uniform_in_uniform_out(self, feather: int) -> None:
        """Law 3: an exemplar of one colour gives that colour, with a feather, too."""

        def law(case: Case) -> None:
            first = case.exemplars[0].base.samples[0, 0]
            flat = tuple(replace(e, planes={"albedo": _filled(e.base, first)}, _memo={}) for e in case.exemplars)
            pixels = replace(case, exemplars=flat).grow(self.method).render(feather=feather).samples
            assert (pixels == first).all()

        self.for_all(law, 2)

    def test_threads_and_repetition_change_no_byte(self) -> None:
        """Law 4: one, two or four threads, called again, give the same map and the same pixels."""

        def law(case: Case) -> None:
            outs = [case.grow(self.method, run=Run(threads=n)) for n in (1, 2, 4, 1)]
            assert len({out.map.digest for out in outs}) == 1
            assert len({out.render(feather=3, run=Run(threads=n)).pixels.tobytes() for n, out in enumerate(outs, 1)}) == 1
            assert len({out.recipe_text for out in outs}) == 1

        self.for_all(law)

    @pytest.mark.parametrize("feather", [0, 4])
    def test_a_rendered_window_is_a_crop(self, feather: int) -> None:
        """Law 5: rendering a window equals that window of the whole, across wrapped borders, too."""

        def law(case: Case) -> None:
            out = case.grow(self.method)
            (height, width), wrap = case.size, case.wrap
            whole = out.render(feather=feather).pixels
            y0, y1 = (-height - 3, height + 2) if wrap.y else (height // 3, height)
            x0, x1 = (-5, 2 * width) if wrap.x else (0, width - width // 2)
            part = out.render(feather=feather, box=Box(y0, x0, y1, x1)).pixels
            crop = whole[np.ix_(np.arange(y0, y1) % height, np.arange(x0, x1) % width)]
            assert part.tobytes() == np.ascontiguousarray(crop).tobytes()

        self.for_all(law)

    @pytest.mark.parametrize("corner", [(0, 0), (-7, 3), (2**40 - 5, -(2**40))])
    def test_a_computed_window_is_a_crop(self, corner: tuple[int, int]) -> None:
        """Law 5 of window methods: a window's map, computed alone, equals that window of any larger one."""
        self.claims(Ability.WINDOW)
        y, x = corner

        def law(case: Case) -> None:
            small = self.map_of_window(case, Box(y + 4, x + 6, y + 20, x + 31))
            large = self.map_of_window(case, Box(y, x, y + 40, x + 33))
            assert same_map(small, large.window(Box(4, 6, 20, 31)))

        self.for_all(law)

    def test_the_wrapped_border_is_no_worse_than_the_inside(self) -> None:
        """Law 6: neighbours across a wrapped border differ no more than those along the worst joins inside."""
        self.claims(Ability.WRAP)
        across = np.zeros(4)
        for seed in range(6):
            e = Exemplar.of(texture(36, 32, 1, seed))
            out = synthesize(e, (48, 54), self.method, seed=seed, wrap=Wrap.BOTH, run=Run(threads=1))
            pixels = out.render(feather=0).pixels.astype(float)[:, :, 0]
            for axis in (0, 1):
                steps = np.abs(np.roll(pixels, -1, axis) - pixels).mean(axis=1 - axis)
                across[axis] += steps[-1]
                across[2 + axis] += steps[:-1].max()
        assert across[0] <= 1.1 * across[2]
        assert across[1] <= 1.1 * across[3]

    @pytest.mark.parametrize("hole", ["right half", "middle", "scattered", "corners"])
    def test_start_pixels_beyond_the_rim_stay(self, hole: str) -> None:
        """Law 7: what lies deeper than the rim keeps its source, and its look beyond rim + feather; no hole is left."""
        self.claims(Ability.START)

        def law(case: Case) -> None:
            start, feather = self._start(case, hole), 3
            out = case.grow(self.method, start=start)
            assert not out.map.holes.any()
            rim = self.rim(case.exemplars, case.size)
            kept, clear = _depth(start, case.wrap) > rim, _depth(start, case.wrap) > rim + feather
            assert same_pixels(out.map, start, kept)
            filled = case.grow(self.method).map
            before = replace(start, **_laid_over(filled, start))
            old = Synthesis(case.exemplars, before, Blend(0), self.method)
            for f in (0, feather):
                assert (out.render(feather=f).samples[clear] == old.render(feather=f).samples[clear]).all()

        self.for_all(law)

    def test_the_rim_can_be_chosen(self) -> None:
        """Law 7: with a rim of 0 every known start pixel keeps its source."""
        self.claims(Ability.START)

        def law(case: Case) -> None:
            start = self._start(case, "middle")
            canvas = Canvas(*case.size, case.wrap, start, rim=0)
            settled = self.method.settled(case.exemplars, canvas)
            out = settled.synthesize(case.exemplars, canvas, case.seed, Run(threads=1))
            assert same_pixels(out, start, ~start.holes)
            assert not out.holes.any()

        self.for_all(law, 2)

    def test_a_start_without_holes_is_the_result(self) -> None:
        """Law 7: where all is known nothing changes."""
        self.claims(Ability.START)

        def law(case: Case) -> None:
            full = case.grow(self.method).map
            assert same_map(case.grow(self.method, start=full, seed=case.seed ^ 1).map, full)

        self.for_all(law, 2)

    def test_the_picture_under_a_start_need_not_be_sampled(self) -> None:
        """Law 7: a start map may show an exemplar that is wholly unusable; only its own pixels show it."""
        self.claims(Ability.START)
        self.claims(Ability.SEVERAL)
        below = Exemplar.of(texture(26, 30, 3, 5), usable=np.zeros((26, 30), bool))
        sampled = Exemplar.of(texture(28, 24, 3, 6))
        start = identity((below.source, sampled.source), 0)
        which = np.array(start.which)
        which[:, 15:] = HOLE
        start = replace(start, which=which)
        out = synthesize([below, sampled], None, self.method, start=start, run=Run(threads=1))
        assert out.map.which is not None
        assert (out.map.which[:, 15:] == 1).all()
        deep = _depth(start, Wrap.NONE) > self.rim((below, sampled), (26, 30))
        assert (out.map.which[deep] == 0).all()
        assert (out.render(feather=0).pixels[deep] == below.base.pixels[deep]).all()

    def test_inputs_are_never_written_to(self) -> None:
        """Law 8: arrays given stay as they are, and may be read-only, of any order and any strides."""
        pixels = np.asfortranarray(texture(29, 50, 3, 1))[:, ::-2]
        before = pixels.copy()
        pixels.flags.writeable = False
        out = synthesize(pixels, (33, 40), self.method, run=Run(threads=1))
        first = out.render().pixels.copy()
        assert (pixels == before).all()
        assert not np.shares_memory(out.render().pixels, pixels)
        assert (synthesize(np.ascontiguousarray(pixels), (33, 40), self.method).render().pixels == first).all()
        if Ability.START in self.method.supports:
            start = self._start(Case(out.exemplars, (33, 40), 0, Wrap.NONE), "middle")
            digest = start.digest
            synthesize(pixels, None, self.method, start=start, run=Run(threads=1))
            assert start.digest == digest

    def test_planes_rendered_together_or_alone_agree(self) -> None:
        """Law 9: one map draws all planes, in any order; each is that of its exemplar."""
        planes = {"albedo": texture(28, 26, 3, 2), "height": texture(28, 26, 1, 3)[:, :, 0], "normal": texture(28, 26, 3, 4)}
        out = synthesize(planes, (31, 39), self.method, run=Run(threads=1))
        again = synthesize(planes, (31, 39), self.method, run=Run(threads=1))
        for feather in (0, 3):
            forth = {n: out.render(n, feather=feather).pixels.tobytes() for n in planes}
            back = {n: again.render(n, feather=feather).pixels.tobytes() for n in reversed(planes)}
            assert forth == back
        for name in ("albedo", "height"):
            assert (out.render(name, feather=0).pixels == looked_up(out.exemplars, out.map, name)).all()

    def test_saved_maps_and_recipes_reproduce(self, tmp_path: Path) -> None:
        """Law 10: a saved map renders the same, and the recipe alone gives the same map."""

        def law(case: Case) -> None:
            out = case.grow(self.method)
            out.map.save(tmp_path / "map.npz")
            loaded = replace(out, map=SourceMap.load(tmp_path / "map.npz"))
            assert same_map(loaded.map, out.map)
            assert (loaded.map.sources, loaded.map.wrap, loaded.map.blend) == (out.map.sources, out.map.wrap, out.map.blend)
            assert loaded.render(feather=2).pixels.tobytes() == out.render(feather=2).pixels.tobytes()
            again = replayed(out.recipe_text, case.exemplars)
            assert same_map(again.map, out.map)
            assert again.recipe == out.recipe

        self.for_all(law)

    def test_cancelling_stops_at_every_step(self) -> None:
        """Law 12: set at any step, the event ends the work with CancelledError; drafts are maps with holes or none."""
        e = Exemplar.of(texture(26, 24, 3, 7))
        ticks: list[tuple[int, int]] = []
        synthesize(e, (40, 44), self.method, run=Run(1, lambda done, total, draft: ticks.append((done, total))))
        assert ticks
        assert [d for d, _ in ticks] == sorted(d for d, _ in ticks)
        assert all(0 <= d <= total for d, total in ticks)
        for stop in {0, len(ticks) // 2, len(ticks) - 1}:
            event, seen = threading.Event(), []

            def step(done: int, total: int, draft: Any, at: int = stop, cancel: Any = event, s: Any = seen) -> None:
                if draft is not None:
                    assert (draft().height, draft().width) == (40, 44)
                s.append(done)
                if len(s) > at:
                    cancel.set()

            with pytest.raises(CancelledError):
                synthesize(e, (40, 44), self.method, run=Run(1, step, event))
            assert len(seen) == stop + 1

    def test_the_depth_of_the_pixels_changes_no_map(self) -> None:
        """Law 13: 8 bits, the same times 257 in 16 bits, and over 255 in floats give the same map."""

        def law(case: Case) -> None:
            pixels = [texture(e.height, e.width, e.base.channels, n) for n, e in enumerate(case.exemplars)]
            maps = []
            for dtype in ("uint8", "uint16", "float32", "float64"):
                deep = [Plane(as_depth(p, dtype), Kind.COLOUR, Transfer.SRGB) for p in pixels]
                given = [Exemplar.of(p, usable=e.usable, toroidal=e.toroidal) for p, e in zip(deep, case.exemplars, strict=True)]
                maps.append(replace(case, exemplars=tuple(given)).grow(self.method).map)
            assert len({m.digest for m in maps}) == 1

        self.for_all(law)

    @pytest.mark.parametrize("ability", list(Ability))
    def test_what_is_not_claimed_is_refused(self, ability: Ability) -> None:
        """An ability that is not claimed is refused with one line before any work."""
        if ability is Ability.WINDOW:
            pytest.skip("nothing can ask for a window yet")
        if ability in self.method.supports:
            pytest.skip("it is claimed")
        e = Exemplar.of(texture(24, 22, 3, 8))
        label = Plane(np.zeros((24, 22), np.uint8), Kind.LABEL)
        asked: dict[Ability, Callable[[], object]] = {
            Ability.WRAP: lambda: synthesize(e, 30, self.method, wrap="x"),
            Ability.START: lambda: synthesize(e, None, self.method, start=identity([e.source], 0)),
            Ability.MASK: lambda: synthesize(replace(e, usable=np.arange(22) > np.zeros((24, 1)), _memo={}), 30, self.method),
            Ability.GUIDE: lambda: synthesize(e, (24, 22), self.method, guide=Guide(label, label)),
            Ability.SEVERAL: lambda: synthesize([e, e], 30, self.method),
            Ability.ISOMETRIES: lambda: make(self.method.slug, {"isometries": "both"}),
        }
        with pytest.raises(ParameterError) as caught:
            asked[ability]()
        assert "\n" not in str(caught.value)

    def _start(self, case: Case, hole: str) -> SourceMap:
        """Grow a map with another seed and cut holes into it."""
        full = case.grow(self.method, seed=case.seed ^ 0xABCD).map
        height, width = case.size
        y, x = np.mgrid[:height, :width]
        holes = {
            "right half": x >= width // 2,
            "middle": (abs(2 * y - height) < height / 2) & (abs(2 * x - width) < width / 2),
            "scattered": noise(height, width, case.seed) % np.uint64(17) == 0,
            "corners": (np.minimum(y, height - 1 - y) < 6) & (np.minimum(x, width - 1 - x) < 5),
        }[hole]
        which = np.zeros(case.size, np.uint8) if full.which is None else np.array(full.which)
        which[holes] = HOLE
        return replace(full, which=which, yx=np.where(holes[:, :, None], 0, full.yx))


def same_pixels(a: SourceMap, b: SourceMap, where: NDArray[np.bool_]) -> bool:
    """Say whether two maps show the same exemplar pixels, in the same poses, wherever `where` says so."""
    for name in ("which", "pose"):
        one, two = (np.zeros(where.shape, np.uint8) if getattr(m, name) is None else getattr(m, name) for m in (a, b))
        if not (one[where] == two[where]).all():
            return False
    return bool((a.yx[where] == b.yx[where]).all())


def replayed(recipe: str, exemplars: Sequence[Exemplar]) -> Synthesis:
    """Run a recipe (JSON) again on its exemplars."""
    told = json.loads(recipe)
    assert [s["sha256"] for s in told["exemplars"]] == [e.digest for e in exemplars]
    kinds = {p.name: p.kind for p in parameters(make(told["method"], {}))}
    values = {k: v[::-1] if kinds[k] == "extent" and isinstance(v, list) else v for k, v in told["parameters"].items()}
    blend = Blend(**told["blend"])
    width, height = told["size"]
    method = make(told["method"], values)
    return synthesize(exemplars, (height, width), method, seed=told["seed"], wrap=told["wrap"], blend=blend)


def _filled(plane: Plane, value: Array) -> Plane:
    return plane.like(np.broadcast_to(value, plane.samples.shape))


def _depth(start: SourceMap, wrap: Wrap) -> NDArray[np.int32]:
    """How far, along rows, columns and diagonals, every start pixel is from the nearest hole."""
    known = ~start.holes
    if known.all():
        return np.full(known.shape, 1 << 20, np.int32)
    pad = [(n if w else 0,) * 2 for n, w in zip(known.shape, (wrap.y, wrap.x), strict=True)]
    depth = distance_transform_cdt(np.pad(known, pad, mode="wrap"), metric="chessboard")
    return np.asarray(depth[pad[0][0] : pad[0][0] + known.shape[0], pad[1][0] : pad[1][0] + known.shape[1]], np.int32)


def _laid_over(below: SourceMap, start: SourceMap) -> dict[str, Array]:
    """The arrays of `start`, its holes filled from another map."""
    holes, out = start.holes, {}
    for name in ("which", "pose"):
        one, two = (np.zeros(holes.shape, np.uint8) if getattr(m, name) is None else getattr(m, name) for m in (below, start))
        out[name] = np.where(holes, one, two)
    return {**out, "yx": np.where(holes[:, :, None], below.yx, start.yx)}
