"""Functions as parameters: known by themselves and by what they said where they were asked, never by a few tries."""

from __future__ import annotations

import json
import pickle
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from giant.giants import files_below, needs

import intarsia as ia
from intarsia.foundation.field import Field
from intarsia.foundation.geometry import Box
from intarsia.methods import recipe_settings
from intarsia.model import Exemplar
from intarsia.testing.cases import texture

GRID = 16  # px: whoever tries functions at every 16th px only takes these two for the same


def disc(y: Any, x: Any) -> Any:
    return ((y - 20) ** 2 + (x - 20) ** 2 < 200) * 1.0


@dataclass(frozen=True)
class Says:
    """Functions of one name, which say the same at every 16th px, or up to 512 px, or inside of a picture of 96 px."""

    kind: str

    def __call__(self, y: Any, x: Any) -> Any:
        tried, near = (y % GRID == 0) & (x % GRID == 0), (y < 512) & (x < 512)
        inside = (y >= 0) & (x >= 0) & (y < 96) & (x < 96)
        square = (abs(y - 20) < 9) & (abs(x - 20) < 15)
        return {
            "even": 0 * y + 0 * x + 0.25,
            "odd": np.where(tried, 0.25, 1.0),
            "beyond": np.where(near, 0.25, 1.0),
            "outside": np.where(inside, 0.25, 1.0),
            "disc": disc(y, x),
            "square": np.where(tried, disc(y, x), square * 1.0),
            "turned": 22.5 + 0 * y + 0 * x,
            "elsewhere": np.where(tried, 22.5, 90.0),
        }[self.kind]


even, odd, beyond, outside, round_, square, turned, elsewhere = (
    Says(kind) for kind in ("even", "odd", "beyond", "outside", "disc", "square", "turned", "elsewhere")
)

FREE = {"jitter": (0.3, 0.2, 0.5), "passes": 1, "keep_lattice": "off"}
PAIRS = [
    ("jitter_output", even, odd), ("jitter_exemplar", even, odd), ("feature", round_, square),
    ("angle", turned, elsewhere),
]  # fmt: skip


def exemplar() -> Exemplar:
    return Exemplar.of(texture(48, 48, 3, 8))


def grown(e: Exemplar, name: str, function: Any) -> ia.Synthesis:
    return ia.synthesize(e, 96, ia.ParallelControllable(**FREE, **{name: function}), seed=2, run=ia.Run(1))


@pytest.mark.parametrize(("name", "one", "other"), PAIRS, ids=[p[0] for p in PAIRS])
def test_functions_that_agree_here_and_there_make_their_own_maps(name: str, one: Any, other: Any) -> None:
    """Of one exemplar in one process as of exemplars of their own; recipes tell them apart, and name the same alike."""
    shared = exemplar()
    made, apart = [grown(shared, name, f) for f in (one, other)], [grown(exemplar(), name, f) for f in (one, other)]
    assert [m.map.digest for m in made] == [m.map.digest for m in apart]
    assert made[0].map.digest != made[1].map.digest
    told = [m.recipe["parameters"][name] for m in made]
    assert told[0]["sha256"] != told[1]["sha256"]
    assert [m.recipe for m in made] == [m.recipe for m in apart]
    told = json.loads(made[0].recipe_text)
    assert told == made[0].recipe | {"energy": made[0].energy}


def test_a_function_equals_itself_alone() -> None:
    """Through pickles, too; ends that are allowed count."""
    same = [Field(disc), Field(disc), pickle.loads(pickle.dumps(Field(disc)))]
    assert len({*same, Field(even), Field(odd), Field(lambda y, x: 0.25), Field(disc, 0, 2)}) == 5
    assert Field(even) != Field(0.25)
    assert Field(0.25) != Field(even)


def test_the_recipe_of_a_texture_without_end_names_functions_and_proves_nothing() -> None:
    woven = ia.weave(exemplar(), ia.ParallelControllable(**FREE, jitter_output=even), 3)
    assert woven.recipe["parameters"]["jitter_output"] == {"function": f"{__name__}.Says", "replayable": False}
    assert recipe_settings(woven.method)["jitter_output"] == woven.recipe["parameters"]["jitter_output"]
    told = [woven.recipe_over(Box(0, 0, side, side))["parameters"]["jitter_output"]["sha256"] for side in (64, 64, 65)]
    assert told[0] == told[1] != told[2]


def test_all_that_is_asked_counts_even_beside_the_picture() -> None:
    """Coarse levels begin outside: two functions that differ only there have other recipes, and may make other maps."""
    made = [grown(exemplar(), "jitter_output", f) for f in (even, outside)]
    assert made[0].map.digest != made[1].map.digest
    assert made[0].recipe != made[1].recipe


def test_windows_ask_for_nothing_that_the_whole_does_not_ask_for() -> None:
    """So a hash over the whole answers for every piece of it."""
    asked: list[set[tuple[int, int]]] = [set()]

    def listening(y: Any, x: Any) -> Any:
        asked[-1] |= {(int(a), int(b)) for a in y.ravel() for b in x.ravel()}
        return 0 * y + 0 * x + 0.25

    woven = ia.weave(exemplar(), ia.ParallelControllable(**FREE, angle=listening), 3, blend=ia.Blend(0))
    for work in (lambda: woven.recipe_over(Box(-7, 5, 60, 90)), lambda: woven[-7:60, 5:90], lambda: woven[20:60, 5:31]):
        asked.append(set())
        work()
    assert asked[1] == asked[2] > asked[3]


def test_a_store_goes_on_with_its_own_function_alone(tmp_path: Path) -> None:
    """Finished or not; the same one changes nothing, whoever draws."""
    needs("zarr")

    def stream(path: Path, f: Any) -> dict[str, bytes]:
        woven = ia.weave(exemplar(), ia.ParallelControllable(**FREE, jitter_output=f), 3)
        woven.to_zarr(path, (70, 90), origin=(3, -8), chunk=32)
        return files_below(path)

    first = stream(tmp_path / "o", even)
    with pytest.raises(ia.ParameterError, match=r"o holds another recipe \(parameters\)") as caught:
        stream(tmp_path / "o", odd)
    assert "\n" not in str(caught.value)
    assert stream(tmp_path / "o", even) == first == files_below(tmp_path / "o")


def test_a_store_far_from_the_origin_is_told_apart(tmp_path: Path) -> None:
    needs("zarr")
    woven = [ia.weave(exemplar(), ia.ParallelControllable(**FREE, jitter_output=f), 3) for f in (even, beyond)]
    assert (woven[0][500:560, 500:560] != woven[1][500:560, 500:560]).any()
    woven[0].to_zarr(tmp_path / "o", 60, origin=(500, 500))
    with pytest.raises(ia.ParameterError, match="holds another recipe"):
        woven[1].to_zarr(tmp_path / "o", 60, origin=(500, 500))


def test_blocks_of_dask_are_those_of_their_own_function() -> None:
    """Drawn together, under one name, too."""
    needs("dask")
    import dask

    woven = [ia.weave(exemplar(), ia.ParallelControllable(**FREE, jitter_output=f), 3) for f in (even, odd)]
    wanted = [w[0:64, 0:64] for w in woven]
    assert (wanted[0] != wanted[1]).any()
    found = dask.compute(*(w.to_dask(64, chunks=32) for w in woven))
    assert all((a == b).all() for a, b in zip(found, wanted, strict=True))


def test_frames_of_a_flow_are_told_apart() -> None:
    water = ia.synthesize(exemplar(), 64, ia.ParallelControllable(**FREE), seed=3, wrap="both", run=ia.Run(1))
    flow = np.full((64, 64, 2), 2.0)
    told = [
        ia.advect(water, flow, method=ia.ParallelControllable(**FREE, feature=f)).recipe["advected"]["sha256"]
        for f in (round_, square, round_)
    ]
    assert told[0] == told[2] != told[1]


@pytest.mark.parametrize(
    "error", [KeyError("x"), AttributeError("no such thing\nat all"), ZeroDivisionError(), OSError(5, "gone")]
)
def test_a_function_that_fails_is_named_in_one_line(error: Exception) -> None:
    def failing(y: Any, x: Any) -> Any:
        raise error

    def late(y: Any, x: Any) -> Any:
        if y.size > 8:
            raise error
        return 0.5

    for name in ("jitter_output", "feature", "angle"):
        for f in (failing, late):
            told = f"the function {__name__}.*{f.__name__} gives no numbers"
            with pytest.raises(ia.InputError, match=told) as caught:
                grown(exemplar(), name, f)
            assert "\n" not in str(caught.value)
            assert type(error).__name__ in str(caught.value)
            assert caught.value.__cause__ is error


def test_a_function_may_be_stopped_and_may_refuse() -> None:
    """Ctrl-C and errors of ours pass as they are."""
    for error in (KeyboardInterrupt(), ia.CancelledError("stopped")):

        def stopping(y: Any, x: Any, error: BaseException = error) -> Any:
            if y.size > 8:
                raise error
            return 0.5

        with pytest.raises(type(error)):
            grown(exemplar(), "jitter_output", stopping)
