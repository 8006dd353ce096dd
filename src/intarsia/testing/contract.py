"""The laws of the package as tests of one method; docs/design/000-architecture.md lists them by number."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, ClassVar, TypeVar

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis.strategies import SearchStrategy

from ..foundation import CancelledError, ParameterError
from ..foundation.arrays import Mask, Pair
from ..foundation.blend import Blend
from ..foundation.geometry import Box, Wrap
from ..foundation.params import extent
from ..foundation.run import Run
from ..methods import Ability, Method, make
from ..model import Exemplar, Exemplars
from ..model.canvas import Canvas, Guide
from ..model.image import Kind, Plane
from ..model.sourcemap import SourceMap, identity
from ..synthesis import Synthesis, synthesize
from ..tasks.completion import with_hole
from .cases import (
    Case,
    cases,
    depth,
    laid_over,
    looked_up,
    noise,
    same_map,
    same_pixels,
    texture,
)

L = TypeVar("L", bound=Callable[..., None])


def of_those_that_claim(*abilities: Ability) -> Callable[[L], L]:
    """Mark a law as one for methods with these abilities; other methods have no such test."""

    def mark(law: L) -> L:
        law.__dict__["abilities"] = frozenset(abilities)
        return law

    return mark


class Laws:
    """A method under test.

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

    def __init_subclass__(cls) -> None:
        """Remove the laws of abilities that the method does not have."""
        super().__init_subclass__()
        if not hasattr(cls, "method"):
            return
        laws = {n: law for base in reversed(cls.__mro__) for n, law in vars(base).items() if hasattr(law, "abilities")}
        for name, law in laws.items():
            if getattr(cls, name) in (law, None):
                setattr(cls, name, law if law.abilities <= cls.method.supports else None)

    def cases(self) -> SearchStrategy[Case]:
        """Return the requests on which the laws are tested."""
        return cases(self.method, least=self.least)

    def steps(self, count: int) -> Iterable[int]:
        """Return the steps, of `count`, at which cancelling is tested."""
        return range(1, count + 1)

    def rim(self, exemplars: Exemplars, start: SourceMap) -> int:
        """Return how deep, in px, a start map may be changed: the method's overlap or border, else 0."""
        resolved = self.method.resolved(exemplars, Canvas(*start.shape, start.wrap, start))
        return max(extent(getattr(resolved, "overlap", getattr(resolved, "border", 0))))

    def map_of_window(self, case: Case, box: Box) -> SourceMap:
        """Return the map of a single window of the endless plane."""
        method: Any = self.method
        smap: SourceMap = method.window(case.exemplars, box, case.seed, Run(1))
        return smap

    def many(self, examples: int) -> int:
        """Return the number of requests to test for a law that asks for `examples`."""
        return examples

    def for_all(self, law: Callable[[Case], None], examples: int | None = None) -> None:
        """Test a law on requests drawn by hypothesis."""

        @settings(
            max_examples=self.many(examples or self.examples),
            deadline=None,
            derandomize=True,
            database=None,
            suppress_health_check=[HealthCheck.too_slow],
        )
        @given(self.cases())
        def check(case: Case) -> None:
            law(case)

        check()


HOLES = ("right half", "middle", "scattered", "corners", "all")


def hole_of(name: str, height: int, width: int, seed: int) -> Mask:
    """Return a mask of the holes of a canvas."""
    y, x = np.mgrid[:height, :width]
    shapes = {
        "right half": x >= width // 2,
        "middle": (abs(2 * y - height) < height / 2) & (abs(2 * x - width) < width / 2),
        "scattered": noise(height, width, seed) % np.uint64(17) == 0,
        "corners": (np.minimum(y, height - 1 - y) < 6) & (np.minimum(x, width - 1 - x) < 5),
        "all": x >= 0,
    }
    return np.asarray(shapes[name], bool)


class StartLaws(Laws):
    """Pixels of a start map beyond the rim are kept, and no hole remains."""

    @pytest.mark.parametrize("hole", HOLES)
    @of_those_that_claim(Ability.START)
    def test_start_pixels_beyond_the_rim_stay(self, hole: str) -> None:
        """Law 7: beyond the rim sources are kept, beyond rim + feather pixels; no hole is left."""

        def law(case: Case) -> None:
            start, feather = self._start(case, hole), 3
            out = case.grow(self.method, start=start)
            assert not out.map.holes.any()
            rim = self.rim(case.exemplars, start)
            far = depth(start, case.wrap)
            assert same_pixels(out.map, start, far > rim)
            before = laid_over(case.grow(self.method).map, start)
            old, clear = Synthesis(case.exemplars, before, Blend(0), self.method), far > rim + feather
            for f in (0, feather):
                assert (out.render(feather=f).samples[clear] == old.render(feather=f).samples[clear]).all()
            assert same_map(case.grow(self.method, start=start, threads=2).map, out.map)

        self.for_all(law)

    @of_those_that_claim(Ability.START)
    def test_the_rim_can_be_chosen(self) -> None:
        """Law 7: with a rim of 0 every filled start pixel keeps its source."""

        def law(case: Case) -> None:
            start = self._start(case, "middle")
            canvas = Canvas(*case.size, case.wrap, start, rim=0)
            resolved = self.method.resolved(case.exemplars, canvas)
            out = resolved.synthesize(case.exemplars, canvas, case.seed, Run(threads=1))
            assert same_pixels(out, start, ~start.holes)
            assert not out.holes.any()

        self.for_all(law, 5)

    @of_those_that_claim(Ability.START)
    def test_a_start_without_holes_is_the_result(self) -> None:
        """Law 7: a start map without holes is returned unchanged."""

        def law(case: Case) -> None:
            full = case.grow(self.method).map
            assert same_map(case.grow(self.method, start=full, seed=case.seed ^ 1).map, full)

        self.for_all(law, 5)

    @of_those_that_claim(Ability.START, Ability.SEVERAL, Ability.MASK)
    def test_the_picture_under_a_start_need_not_be_sampled(self) -> None:
        """Law 7: a start map may show an exemplar without usable pixels; no new pixel shows it."""
        below = Exemplar.of(texture(26, 30, 3, 5), usable=np.zeros((26, 30), bool))
        sampled = Exemplar.of(texture(28, 24, 3, 6))
        holes = hole_of("right half", 26, 30, 0)
        start = with_hole(identity((below.source, sampled.source), 0), holes)
        out = synthesize([below, sampled], None, self.method, start=start, run=Run(threads=1))
        assert (out.map.numbers[holes] == 1).all()
        deep = depth(start, Wrap.NONE) > self.rim((below, sampled), start)
        assert (out.map.numbers[deep] == 0).all()
        assert (out.render(feather=0).pixels[deep] == below.base.pixels[deep]).all()

    @of_those_that_claim(Ability.START)
    def test_a_start_map_is_never_written_to(self) -> None:
        """Law 8 for start maps."""

        def law(case: Case) -> None:
            start = self._start(case, "scattered")
            before = start.to_bytes()
            case.grow(self.method, start=start)
            assert start.to_bytes() == before

        self.for_all(law, 2)

    def _start(self, case: Case, hole: str) -> SourceMap:
        """Return a map made with another seed, with holes cut into it."""
        full = case.grow(self.method, seed=case.seed ^ 0xABCD).map
        return with_hole(full, hole_of(hole, *case.size, case.seed))


CORNERS = ((0, 0), (-7, 3), (2**40 - 5, -(2**40)))


class MethodContract(StartLaws):
    """The laws of the package, as tests of one method; subclass it and name the ``method``.

    ``examples``: number of requests for each law; ``least``: shortest side of an exemplar; :meth:`cases` and
    :meth:`rim` may be overridden. Law 11 (feathering is a partition of unity) is one of rendering, not of methods.
    """

    def test_every_pixel_is_a_usable_exemplar_pixel(self) -> None:
        """Law 1: without feather or finish every output pixel is, bit for bit, the usable pixel that the map names.

        Maps with frames or fractions are interpolated, and only name usable pixels.
        """

        def law(case: Case) -> None:
            out = case.grow(self.method)
            assert not out.map.holes.any()
            pixels = out.render(feather=0).pixels
            assert not out.map.exact or pixels.tobytes() == looked_up(case.exemplars, out.map).tobytes()
            for number, e in enumerate(case.exemplars):
                shown = out.map.yx[out.map.numbers == number]
                assert e.usable is None or e.usable[shown[:, 0], shown[:, 1]].all()

        self.for_all(law, 2 * self.examples)

    def test_size_type_and_channels_are_kept(self) -> None:
        """Law 2: the size is the requested one; depth, channels, kind and transfer are the exemplar's."""

        def law(case: Case) -> None:
            out, base = case.grow(self.method).render(), case.exemplars[0].base
            assert out.shape == case.size
            assert (out.pixels.dtype, out.pixels.ndim) == (base.pixels.dtype, base.pixels.ndim)
            assert (out.channels, out.kind, out.transfer) == (base.channels, base.kind, base.transfer)

        self.for_all(law)

    @pytest.mark.parametrize("feather", [0, 3])
    def test_uniform_in_uniform_out(self, feather: int) -> None:
        """Law 3: an exemplar of one colour gives that colour, also with a feather."""

        def law(case: Case) -> None:
            first = case.exemplars[0].base.samples[0, 0]
            flat = case.painted(lambda _, e: e.base.like(np.broadcast_to(first, e.base.samples.shape)))
            out = flat.grow(self.method)
            assert (out.render(feather=feather).samples == first).all()

        self.for_all(law, 5)

    def test_threads_and_repetition_change_no_byte(self) -> None:
        """Law 4: one, two or four threads, and repeated calls, give the same map and the same pixels."""

        def law(case: Case) -> None:
            outs = [case.grow(self.method, threads=n) for n in (1, 2, 4, 1)]
            assert len({out.map.digest for out in outs}) == 1
            pictures = [out.render(feather=3, run=Run(n)).pixels for n, out in enumerate(outs, 1)]
            assert len({p.tobytes() for p in pictures}) == 1
            assert len({out.recipe_text for out in outs}) == 1

        self.for_all(law)

    @of_those_that_claim(Ability.WINDOW)
    def test_a_computed_window_is_a_crop(self) -> None:
        """Law 5 of window methods: a window's map, computed on its own, equals that window of a larger one."""

        def law(case: Case) -> None:
            for y, x in CORNERS:
                small = self.map_of_window(case, Box(y + 4, x + 6, y + 20, x + 31))
                large = self.map_of_window(case, Box(y, x, y + 40, x + 33))
                assert same_map(small, large.window(Box(4, 6, 20, 31)))

        self.for_all(law)

    @of_those_that_claim(Ability.WINDOW)
    def test_a_plain_canvas_is_a_window_of_the_endless_plane(self) -> None:
        """Law 5 of window methods: what `synthesize` fills is the window whose first pixel is (0, 0)."""

        def law(case: Case) -> None:
            whole = replace(case, wrap=Wrap.NONE).grow(self.method).map
            assert same_map(self.map_of_window(case, Box(0, 0, *case.size)), whole)

        self.for_all(law, 5)

    @of_those_that_claim(Ability.WRAP)
    def test_the_wrapped_border_is_no_worse_than_the_inside(self) -> None:
        """Law 6: neighbours across the periodic border differ no more than along the worst lines inside."""
        border, worst = np.zeros(2), np.zeros(2)
        for seed in range(6):  # of three, one bad border decides
            e = Exemplar.of(texture(36, 32, 1, seed))
            out = synthesize(e, (48, 54), self.method, seed=seed, wrap=Wrap.BOTH, run=Run(1))
            pixels = out.render(feather=0).pixels[:, :, 0].astype(float)
            for axis in (0, 1):
                steps = np.abs(np.roll(pixels, -1, axis) - pixels).mean(axis=1 - axis)
                border[axis] += steps[-1]
                worst[axis] += steps[:-1].max()
        assert (border <= 1.1 * worst).all()

    def test_inputs_are_never_written_to(self) -> None:
        """Law 8: input arrays are unchanged, and may be read-only, of any order and any strides."""
        pixels = np.asfortranarray(texture(29, 50, 3, 1))[:, ::-2]
        before = pixels.copy()
        pixels.flags.writeable = False
        out = synthesize(pixels, (33, 40), self.method, run=Run(1))
        first = out.render().pixels.copy()
        assert (pixels == before).all()
        assert not np.shares_memory(out.render().pixels, pixels)
        assert (synthesize(before, (33, 40), self.method).render().pixels == first).all()

    def test_cancelling_stops_at_every_step(self) -> None:
        """Law 12: an event set at any step ends the work with CancelledError; drafts have the size of the canvas."""
        e, size = Exemplar.of(texture(26, 24, 3, 7)), (40, 44)
        event, ticks, stop = threading.Event(), list[Pair](), -1

        def step(done: int, total: int, draft: Callable[[], SourceMap] | None) -> None:
            ticks.append((done, total))
            assert draft is None or draft().shape == size
            if len(ticks) == stop:
                event.set()

        synthesize(e, size, self.method, run=Run(1, step, event))
        reported = ticks[:]
        assert reported == sorted(reported)
        assert all(0 <= done <= total for done, total in reported)
        for stop in self.steps(len(reported)):
            event.clear()
            ticks.clear()
            with pytest.raises(CancelledError):
                synthesize(e, size, self.method, run=Run(2, step, event))
            assert ticks == reported[:stop]

    def test_what_is_not_claimed_is_refused(self) -> None:
        """Abilities that a method does not have are refused with one line, before any work."""
        pixels = texture(24, 22, 3, 8)
        e = Exemplar.of(pixels)
        masked = Exemplar.of(pixels, usable=np.arange(22) > np.zeros((24, 1)))
        label = Plane(np.zeros((24, 22), np.uint8), Kind.LABEL)
        start, guide = identity([e.source], 0), Guide(label, label)
        asked: dict[Ability, Callable[[], object]] = {
            Ability.WRAP: lambda: synthesize(e, 30, self.method, wrap="x"),
            Ability.START: lambda: synthesize(e, None, self.method, start=start),
            Ability.MASK: lambda: synthesize(masked, 30, self.method),
            Ability.GUIDE: lambda: synthesize(e, (24, 22), self.method, guide=guide),
            Ability.SEVERAL: lambda: synthesize([e, e], 30, self.method),
            Ability.ISOMETRIES: lambda: make(self.method.slug, {"isometries": "both"}),
        }
        for ability, ask in asked.items():
            if ability not in self.method.supports:
                with pytest.raises(ParameterError) as caught:
                    ask()
                assert "\n" not in str(caught.value), ability
