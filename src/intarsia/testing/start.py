"""Law 7: a canvas may start with a map that is partly filled."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from ..blend import Blend
from ..canvas import Canvas
from ..exemplar import Exemplar
from ..geometry import Wrap
from ..methods.base import Ability
from ..run import Run
from ..sourcemap import SourceMap, identity
from ..synthesis import Synthesis, synthesize
from ..tasks.completion import with_hole
from .cases import Case, noise, texture
from .laws import Laws, of_those_that_claim
from .maps import depth, laid_over, same_map, same_pixels, which_of

HOLES = ("right half", "middle", "scattered", "corners", "all")


def hole_of(name: str, height: int, width: int, seed: int) -> NDArray[np.bool_]:
    """Return which pixels of a canvas are holes."""
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
    """What lies deep in a start map stays, and no hole remains."""

    @pytest.mark.parametrize("hole", HOLES)
    @of_those_that_claim(Ability.START)
    def test_start_pixels_beyond_the_rim_stay(self, hole: str) -> None:
        """Law 7: beyond the rim the source stays, beyond rim + feather the look; no hole is left."""

        def law(case: Case) -> None:
            start, feather = self._start(case, hole), 3
            out = case.grow(self.method, start=start)
            assert not out.map.holes.any()
            rim = self.rim(case.exemplars, case.size)
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
        """Law 7: with a rim of 0 every known start pixel keeps its source."""

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
        """Law 7: where all is known nothing changes."""

        def law(case: Case) -> None:
            full = case.grow(self.method).map
            assert same_map(case.grow(self.method, start=full, seed=case.seed ^ 1).map, full)

        self.for_all(law, 5)

    @of_those_that_claim(Ability.START, Ability.SEVERAL, Ability.MASK)
    def test_the_picture_under_a_start_need_not_be_sampled(self) -> None:
        """Law 7: a start map may show an exemplar that is wholly unusable; only its own pixels show it."""
        below = Exemplar.of(texture(26, 30, 3, 5), usable=np.zeros((26, 30), bool))
        sampled = Exemplar.of(texture(28, 24, 3, 6))
        holes = hole_of("right half", 26, 30, 0)
        start = with_hole(identity((below.source, sampled.source), 0), holes)
        out = synthesize([below, sampled], None, self.method, start=start, run=Run(threads=1))
        assert (which_of(out.map)[holes] == 1).all()
        deep = depth(start, Wrap.NONE) > self.rim((below, sampled), (26, 30))
        assert (which_of(out.map)[deep] == 0).all()
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
        """Grow a map with another seed and cut holes into it."""
        full = case.grow(self.method, seed=case.seed ^ 0xABCD).map
        return with_hole(full, hole_of(hole, *case.size, case.seed))
