"""Laws of all methods that are not theirs: of drawing maps, of keeping them, and of reading pixels of any depth."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from intarsia.foundation.blend import Blend, Levelling
from intarsia.foundation.geometry import Box
from intarsia.foundation.run import Run
from intarsia.model import Exemplar, Exemplars
from intarsia.model.image import Kind, Plane, Transfer
from intarsia.model.sourcemap import SourceMap
from intarsia.rendering.render import render
from intarsia.request import Request, from_recipe
from intarsia.synthesis import Synthesis, synthesize
from intarsia.tasks import made_of, plan_of, scene_of
from intarsia.tasks.repair import repair
from intarsia.testing import Case, MethodContract, as_depth, looked_up, same_map, texture


def replayed(recipe: str, exemplars: Exemplars) -> Synthesis:
    """Run a recipe (JSON), which needs no input besides its exemplars, again on them."""
    request = from_recipe(json.loads(recipe), Request("replay", magnify=exemplars[0].times), "its recipe")
    made = made_of(request, plan_of(request, scene_of(request, exemplars)), request.seeds[0], Run())
    return repair(made, request.repair) if request.repair else made


class PackageLaws(MethodContract):
    """The contract of a method, and the laws that the rest of the package keeps for it."""

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

    def test_a_finished_picture_obeys_the_laws_of_drawing(self, tmp_path: Path) -> None:
        """Laws 2, 4, 5 and 10 hold with a finish, too: type, threads, windows, and what is saved."""

        def law(case: Case) -> None:
            grown = case.grow(self.method)
            blend = Blend(2, finish=(Levelling(5),) if grown.map.exact else ())  # others cannot be levelled
            out = replace(grown, blend=blend)
            whole, base = out.render(run=Run(1)), case.exemplars[0].base
            assert (whole.pixels.dtype, whole.pixels.shape[2:]) == (base.pixels.dtype, base.pixels.shape[2:])
            assert out.render(run=Run(2)).pixels.tobytes() == whole.pixels.tobytes()
            y, x = case.size[0] // 3, case.size[1] // 2
            part = out.render(box=Box(y, x, case.size[0], case.size[1])).pixels
            assert part.tobytes() == np.ascontiguousarray(whole.pixels[y:, x:]).tobytes()
            replace(out.map, blend=blend).save(tmp_path / "map.npz")
            loaded = SourceMap.load(tmp_path / "map.npz")
            assert render(out.exemplars, loaded).pixels.tobytes() == whole.pixels.tobytes()

        self.for_all(law, 4)

    def test_planes_rendered_together_or_alone_agree(self) -> None:
        """Law 9: one map draws all planes, in any order; each is that of its exemplar."""
        planes = {
            "albedo": texture(28, 26, 3, 2),
            "height": texture(28, 26, 1, 3)[:, :, 0],
            "normal": texture(28, 26, 3, 4),
        }
        out, again = (synthesize(planes, (31, 39), self.method, run=Run(1)) for _ in range(2))
        for feather in (0, 3):
            forth = {n: out.render(n, feather=feather).pixels.tobytes() for n in planes}
            back = {n: again.render(n, feather=feather).pixels.tobytes() for n in reversed(planes)}
            assert forth == back
        for name in ("albedo", "height") if out.map.exact else ():
            assert (out.render(name, feather=0).pixels == looked_up(out.exemplars, out.map, name)).all()

    def test_saved_maps_and_recipes_reproduce(self, tmp_path: Path) -> None:
        """Law 10: a saved map renders the same, and the recipe alone gives the same map."""

        def law(case: Case) -> None:
            out = case.grow(self.method)
            out.map.save(tmp_path / "map.npz")
            loaded = replace(out, map=SourceMap.load(tmp_path / "map.npz"))
            assert loaded.map.to_bytes() == out.map.to_bytes()
            assert loaded.render(feather=2).pixels.tobytes() == out.render(feather=2).pixels.tobytes()
            again = replayed(out.recipe_text, case.exemplars)
            assert same_map(again.map, out.map)
            assert again.recipe_text == out.recipe_text

        self.for_all(law)

    def test_the_depth_of_the_pixels_changes_no_map(self) -> None:
        """Law 13: 8 bits, the same times 257 in 16 bits, and over 255 in floats give the same map; of data, too."""

        def law(case: Case) -> None:
            digests = set()
            for dtype in ("uint8", "uint16", "float32", "float64"):

                def plane(n: int, e: Exemplar, dtype: str = dtype) -> Plane:
                    pixels = as_depth(texture(e.height, e.width, e.base.channels, n), dtype)
                    return Plane(pixels, (Kind.COLOUR, Kind.DATA)[case.seed % 2], Transfer.SRGB)

                digests.add(case.painted(plane).grow(self.method).map.digest)
            assert len(digests) == 1

        self.for_all(law)

    def test_heights_in_any_unit_give_the_same_map(self) -> None:
        """Law 14: data times a positive constant give the same map, from 1e-30 to 1e30.

        The data are 256 levels, the lowest and the highest among them: none lies half-way between two features.
        """

        def law(case: Case) -> None:
            for power in (-30, -5, 3, 30):
                factor, maps = (1 + case.seed % 97 / 10) * 10.0 ** (power - (power == 30)), []
                for scale in (1.0, factor):

                    def plane(n: int, e: Exemplar, scale: float = scale) -> Plane:
                        levels = texture(e.height, e.width, e.base.channels, n)
                        levels[e.height // 2, e.width // 2 - 1 : e.width // 2 + 1, :] = [[0], [255]]
                        return Plane((levels * (scale / 255)).astype(np.float32), Kind.DATA)

                    maps.append(case.painted(plane).grow(self.method).map)
                assert same_map(*maps), factor

        self.for_all(law, 2)
