"""Textures that flow (Lefebvre and Hoppe 2006): against the plain twin, and what a moving picture must keep."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from corrections.naive_advected import NaiveFlow
from methods.test_parallel_controllable import naive

import intarsia as ia
from intarsia.cli import cli
from intarsia.corrections.advected import AdvectedCorrections
from intarsia.corrections.coordinate_pyramid import CorrectionParameters
from intarsia.corrections.stack import ComparisonSettings, exemplar_stack
from intarsia.model import Exemplar
from intarsia.synthesis import Synthesis
from intarsia.tasks.advection import displacements
from intarsia.testing.cases import texture

QUICK = ia.ParallelControllable(jitter=0.0, passes=1)


def toy(toroidal: bool = False, masked: bool = False) -> Exemplar:
    mask = np.ones((21, 18), bool)
    mask[9:12, 4:8] = not masked
    return Exemplar.of(texture(21, 18, 3, 5), usable=mask, toroidal=toroidal)


def grown(size: Any = 64, wrap: str = "both", e: Exemplar | None = None) -> Synthesis:
    return ia.synthesize(e or Exemplar.of(texture(40, 44, 3, 2)), size, ia.ParallelControllable(), seed=3, wrap=wrap)


def shear(y: Any, x: Any) -> Any:
    return 0.7 * np.sin(x / 9), 1.4 + 1.2 * np.sin(y / 7)


@pytest.mark.parametrize("wrap", ["none", "x", "both"])
@pytest.mark.parametrize(("toroidal", "masked"), [(False, False), (True, False), (False, True)])
@pytest.mark.parametrize("size", [(16, 20), (13, 10)])
def test_moving_and_mending_do_what_the_plain_twin_does(wrap: str, toroidal: bool, masked: bool, size: Any) -> None:
    """Pixels from outside the canvas and beyond the exemplar, tears, levels of 4, 2 and 1 px, borders."""
    e = toy(toroidal, masked)
    made = grown(size, wrap, e)
    steps = displacements(lambda y, x: (3.4 * np.sin(x / 3), 1.6 * np.cos(y / 4) - 1), *size)
    closed = (made.map.wrap.y, made.map.wrap.x)
    stacked, rules = exemplar_stack(e, ComparisonSettings.of(QUICK)), CorrectionParameters.of(QUICK)
    flowing = AdvectedCorrections(stacked, rules, closed)
    yx, torn = flowing.moved(made.map.yx, steps, (3, 5))
    twin = NaiveFlow(size, closed, e, stacked.home)
    old = {p: tuple(made.map.yx[p].tolist()) for p in twin.pixels()}
    moved, tears = twin.moved(old, steps, (3, 5))
    assert [tuple(yx[p].tolist()) for p in twin.pixels()] == [moved[p] for p in twin.pixels()]
    assert {(int(y), int(x)) for y, x in np.argwhere(torn)} == tears
    assert 0 < len(tears) < torn.size
    got = flowing.mended(yx, torn, 2, ia.Run(threads=1))
    expected = twin.mended(moved, tears, 2, naive(QUICK, e, 0).levels, (1, 2, "near", rules.factor))
    assert [tuple(got[p].tolist()) for p in twin.pixels()] == [expected[p] for p in twin.pixels()]


def test_nothing_moves_nothing_and_a_whole_step_moves_a_torus_whole() -> None:
    made = grown()
    assert (ia.advect(made, np.zeros((64, 64, 2))).map.yx == made.map.yx).all()
    moved = ia.advect(made, lambda y, x: (0 * y + 3, 0 * x - 70.2))
    assert (moved.map.yx == np.roll(made.map.yx, (3, -70), (0, 1))).all()
    assert (np.asarray(moved.render()) == np.roll(np.asarray(made.render()), (3, -70), (0, 1))).all()


def test_whole_steps_of_a_steady_flow_add_up() -> None:
    flow = np.random.default_rng(1).uniform(-3, 3, (7, 9, 2))
    total = sum(displacements(flow, 7, 9, frame) for frame in range(1, 41))
    assert (total == np.floor(40 * flow + 0.5)).all()
    assert (displacements(flow, 7, 9) == np.floor(flow + 0.5)).all()


def test_a_flow_that_is_periodic_from_the_first_frame_loops() -> None:
    made = grown()
    frames = [ia.advect(made, lambda y, x, t=t: (0 * y, 3 * np.sin(2 * np.pi * (t / 6 + x / 64)))) for t in range(7)]
    assert (frames[0].map.yx == frames[6].map.yx).all()
    assert (frames[0].map.yx != frames[3].map.yx).any()


@pytest.mark.parametrize("wrap", ["none", "x"])
def test_threads_change_nothing_and_masked_pixels_are_never_shown(wrap: str) -> None:
    e = toy(masked=True)
    pair = [grown((70, 66), wrap, e), grown((70, 66), wrap, e)]
    for frame in range(1, 9):
        pair = [ia.advect(m, shear, frame=frame, run=ia.Run(threads=n)) for n, m in enumerate(pair, 1)]
    assert (pair[0].map.yx == pair[1].map.yx).all()
    assert pair[0].recipe == pair[1].recipe
    assert e.usable is not None
    assert e.usable[pair[0].map.yx[..., 0], pair[0].map.yx[..., 1]].all()


def test_what_flows_in_is_no_stripe() -> None:
    """When all of the first frame is gone, neighbours still continue one another, and the exemplar is seen as much.

    How much varies: crops of one photograph give 0.67 to 1.06 of what was seen before, so three are counted together.
    """
    kinds, along = np.zeros(2), np.zeros(2)
    for name in ("pebbles", "gravel", "grass"):
        pixels = np.asarray(ia.read(f"sample:{name}").base)
        made = first = grown((96, 96), "none", Exemplar.of(np.ascontiguousarray(pixels[:128, :128])))
        for frame in range(1, 34):
            made = ia.advect(made, lambda y, x: (0 * y + 0.7, 0 * x + 3.0), frame=frame)
        for k, yx in enumerate((first.map.yx, made.map.yx)):
            kinds[k] += len(np.unique(yx.reshape(-1, 2), axis=0))
            along[k] += (yx[:, 1:] - yx[:, :-1] == (0, 1)).all(axis=2).mean()
    assert along[1] > 0.9 * along[0]
    assert kinds[1] > 0.7 * kinds[0]


def test_maps_of_other_methods_flow_too() -> None:
    e = Exemplar.of(texture(40, 44, 3, 2))
    made = ia.synthesize(e, 60, ia.ImageQuilting(patch=16), seed=1)
    moved = ia.advect(made, shear, method=ia.ParallelControllable(kappa=4))
    assert moved.method == made.method
    assert (moved.render().pixels == e.base.pixels[moved.map.yx[..., 0], moved.map.yx[..., 1]]).all()


def test_recipes_count_frames_and_replay_refuses_them(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    made = ia.synthesize("sample:pebbles", 48, ia.ParallelControllable(), wrap="both")
    one = ia.advect(made, np.ones((48, 48, 2)))
    two = ia.advect(one, np.ones((48, 48, 2)))
    other = ia.advect(one, 2 * np.ones((48, 48, 2)))
    assert [r.recipe["advected"]["frames"] for r in (one, two, other)] == [1, 2, 2]
    assert len({r.recipe["advected"]["sha256"] for r in (one, two, other)}) == 3
    assert "advected" not in made.recipe
    ia.write("flow.png", two.render(), recipe=two.recipe_text)
    done = CliRunner().invoke(cli, ["replay", "flow.png", "-o", "again.png"])
    assert done.exit_code == 3
    assert "was moved by a flow that no recipe holds" in done.stderr


def test_wrong_flows_and_maps_are_refused_in_one_line() -> None:
    made = grown(32)
    several = ia.synthesize([texture(40, 44, 3, 2), texture(40, 44, 3, 4)], 32, ia.ImageQuilting(patch=16))
    turned = ia.synthesize(texture(40, 44, 3, 2), 32, ia.ImageQuilting(patch=16, isometries="both"), seed=2)
    fine = np.zeros((32, 32, 2))
    wrong: list[tuple[Any, Any, dict[str, Any], str]] = [
        (made, np.zeros((32, 30, 2)), {}, "the flow has the shape"),
        (made, "downstream", {}, "the flow holds no numbers"),
        (made, fine + np.nan, {}, "not finite"),
        (made, fine + 1e6, {"frame": 1000}, "not finite, or leads farther"),
        (made, fine, {"frame": 0}, "frame=0 is not allowed"),
        (made, fine, {"coarsest": 3}, "coarsest=3 is not allowed; choose 1, 2, 4, 8 or 16"),
        (several, fine, {}, "only a full map of one exemplar"),
        (turned, fine, {}, "only a full map of one exemplar"),
    ]
    for synthesis, flow, more, told in wrong:
        with pytest.raises(ia.ParameterError, match=told) as caught:
            ia.advect(synthesis, flow, **more)
        assert "\n" not in str(caught.value)
