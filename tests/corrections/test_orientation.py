"""Turned and scaled textures: parallel-controllable with angle and zoom (Lefebvre and Hoppe 2006, section 5)."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from methods.test_parallel_controllable import BASE, ONE, SET, VARIANTS, naive, toy

import intarsia as ia
from intarsia.corrections.coordinate_pyramid import CorrectionParameters
from intarsia.corrections.correction_kernels import subpixel_offsets
from intarsia.corrections.span import SINES, Orientation
from intarsia.foundation.field import Field
from intarsia.foundation.geometry import Box
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.image import Kind, Plane
from intarsia.testing.cases import texture


def leaning(y: Any, x: Any) -> Any:
    return (3 * y + 5 * x) % 360 - 180


def growing(y: Any, x: Any) -> Any:
    return 0.25 + (np.floor(y) + 2 * x) % 16 / 4


@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize(
    ("method", "angle", "zoom"),
    [(BASE, 33, 1), (BASE, 0, 2.5), (BASE, leaning, growing), (replace(SET, rule="memo", k=3), 140, 0.5),
     (replace(BASE, passes=2, kappa="inf"), leaning, 0.25), (VARIANTS[6], -90, 4)],
)  # fmt: skip
def test_framed_kernels_do_what_the_plain_twin_does(
    method: ia.ParallelControllable, angle: Any, zoom: Any, toroidal: bool
) -> None:
    """Upsampling by J h D, candidates less J D, neighbours in the warped directions, jitter as it was."""
    e, method = toy(toroidal=toroidal), replace(method, angle=angle, zoom=zoom)
    box = Box(-3, 1 << 20, 1, (1 << 20) + 5)
    got = method.window([e], box, 11, ONE)
    twin, lie = naive(method, e, 11), CorrectionParameters.of(method).orientation

    def matrix(level: int, y: int, x: int) -> tuple[int, ...]:
        h = 1 << level
        return tuple(lie.at(np.array([h * y + h // 2]), np.array([h * x + h // 2]))[0, 0].tolist())

    twin.orientation = matrix  # type: ignore[assignment]
    expected = [[twin.final(y, x) for x in range(box.x0, box.x1)] for y in range(box.y0, box.y1)]
    assert got.yx.tolist() == [[list(u) for u in row] for row in expected]


def test_frames_are_turns_and_scales() -> None:
    """To the left as seen, y downwards: at 90 degrees, above in the output is to the right in the exemplar."""
    at = np.arange(3)
    j = Orientation(Field(90), Field(1)).at(at, at)[1, 2]
    assert j.tolist() == [0, 4096, -4096, 0]
    assert Orientation(Field(0), Field(2)).at(at, at)[0, 0].tolist() == [2048, 0, 0, 2048]
    assert Orientation(Field(30), Field(1)).at(at, at)[0, 0].tolist() == [3547, 2048, -2048, 3547]
    y, x = Orientation(Field(leaning), Field(growing)).at(at, at)[2, 1].reshape(2, 2).tolist()
    angle, zoom = np.radians(float(leaning(2.0, 1.0))), float(growing(2.0, 1.0))
    turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    assert np.allclose([y, x], 4096 / zoom * turned, atol=8)
    assert hashlib.sha256(SINES.astype("<i8").tobytes()).hexdigest()[:16] == "629da15d2cda6a89"


def test_upright_is_the_plain_method() -> None:
    e, method = Exemplar.of(texture(64, 64, 3, 8)), replace(BASE, kappa="inf")
    ones = replace(method, angle=0.0, zoom=Field(np.ones((96, 96))))
    plain, said = (ia.synthesize(e, 96, m, run=ONE).map for m in (method, ones))
    assert plain.exact
    assert not said.exact
    assert (said.yx == plain.yx).all()


def test_a_quarter_turn_of_a_torus_without_jitter_is_the_torus_turned() -> None:
    pixels = texture(32, 32, 3, 5)
    m = ia.ParallelControllable(jitter=0, angle=90)
    e = Exemplar.of(pixels, toroidal=True)
    out = ia.synthesize(e, 64, m, run=ONE)
    turned = np.asarray(out)
    again = np.rot90(np.tile(pixels, (3, 3, 1)))
    offsets = [(dy, dx) for dy in range(32) for dx in range(32) if (again[dy : dy + 64, dx : dx + 64] == turned).all()]
    assert len(offsets) == 1
    assert not np.asarray(out.map.sub).any()


def test_windows_threads_and_wraps_of_turned_textures() -> None:
    e = Exemplar.of(texture(60, 44, 3, 8))
    m = ia.ParallelControllable(angle=Field(leaning), zoom=0.7)
    whole = m.window([e], Box(-40, 2**31 - 30, 30, 2**31 + 50), 5, ONE)
    for part in (Box(0, 0, 20, 30), Box(41, 17, 70, 80)):
        box = Box(part.y0 - 40, part.x0 + 2**31 - 30, part.y1 - 40, part.x1 + 2**31 - 30)
        assert m.window([e], box, 5, Run(threads=2)).digest == whole.window(part).digest
    turned = ia.weave(e, m, seed=3)  # read between pixels
    pixels = turned[-40:60, 2**31 - 30 : 2**31 + 50]
    assert (turned[-13:29, 2**31 - 9 : 2**31 + 31] == pixels[27:69, 21:61]).all()
    far = ia.ParallelControllable(angle=30, zoom=0.25, keep_lattice="on", lattice=((9.5, 0.0), (4.75, 7.25)))
    yx = far.window([e], Box(-(2**40), 2**40 - 9, -(2**40) + 9, 2**40), 5, ONE).yx
    assert (yx >= 0).all()
    closed = ia.synthesize(e, (66, 50), ia.ParallelControllable(angle=20), wrap="both", run=ONE)
    assert closed.map.frame is not None
    assert not closed.map.exact


def test_remainders_are_what_neighbours_foretell() -> None:
    """Rounded coordinates of a plane that lies turned: the mean of 7 x 7 pixels."""
    lie = Orientation(Field(25), Field(1.3))
    rows, cols = np.arange(20), np.arange(24)
    frame = lie.at(rows, cols)
    y, x = np.meshgrid(np.arange(-3, 23), np.arange(-3, 27), indexing="ij")
    j = frame[0, 0] / 4096
    true = np.stack([j[0] * y + j[1] * x, j[2] * y + j[3] * x], axis=2)
    coords = np.rint(true).astype(np.int32) + 100
    coords[:5, :7] += 40  # another piece
    out = np.empty((20, 24, 2), np.int32)
    subpixel_offsets(coords, frame, np.array([300, 300, 0]), out)
    for i, k in ((0, 0), (1, 3), (2, 4), (10, 12), (19, 23)):
        near = []
        for oy in range(-3, 4):
            for ox in range(-3, 4):
                d = 4096 * (coords[i + 3 + oy, k + 3 + ox].astype(int) - coords[i + 3, k + 3])
                moved = [d[n] - frame[i, k, 2 * n] * oy - frame[i, k, 2 * n + 1] * ox for n in (0, 1)]
                near += [moved] if max(map(abs, moved)) <= 6144 else []
        assert out[i, k].tolist() == [int(np.floor(sum(m[a] for m in near) / len(near))) for a in (0, 1)]
    missed = (coords[3:-3, 3:-3] - 100 + out / 4096 - true[3:-3, 3:-3])[8:, 8:]
    assert np.abs(missed).max() < 0.2
    assert np.abs(coords[11:-3, 11:-3] - 100 - true[11:-3, 11:-3]).max() > 0.45


def test_a_pin_lies_as_the_texture_does() -> None:
    e = Exemplar.of(texture(96, 80, 3, 5))
    m = ia.ParallelControllable(pin=((40, 50, 10, 70, 24),), angle=90)
    yx = m.window([e], Box(0, -40, 130, 90), 3, ONE).yx
    y, x = np.mgrid[62:79, 2:19]
    shown = (yx[62:79, 42:59] == np.stack([50 + (x - 10), 40 - (y - 70)], axis=2)).all(axis=2)
    assert shown.mean() > 0.9


def test_masked_pixels_are_not_shown_turned() -> None:
    usable = np.ones((60, 70), bool)
    usable[20:30, 40:52] = False
    e = Exemplar.of(texture(60, 70, 3, 4), usable=usable)
    yx = ia.synthesize(e, 128, ia.ParallelControllable(angle=50, zoom=0.5)).map.yx
    assert usable[yx[..., 0], yx[..., 1]].all()


def test_what_cannot_be_turned_is_refused() -> None:
    for values, told in (
        ({"zoom": 0.1}, "zoom=0.1 is not allowed; give 0.25 to 4"),
        ({"zoom": 2}, "neighbourhood=colour cannot follow angle and zoom; drop it"),
        ({"angle": 3, "rule": "published", "neighbourhood": "appearance"}, "published cannot follow angle and zoom"),
    ):
        with pytest.raises(ia.ParameterError, match=told):
            ia.Correction2008(**values)


def test_a_guide_is_followed_turned() -> None:
    pixels, labels, target = texture(64, 96, 3, 8), np.zeros((64, 96), np.uint8), np.zeros((80, 90), np.uint8)
    pixels[:, 48:] //= 4
    labels[:, 48:] = target[20:60, 25:70] = 1
    guide = ia.Guide(Plane(labels, Kind.LABEL), Plane(target, Kind.LABEL))
    made = ia.synthesize(Exemplar.of(pixels), method=ia.ParallelControllable(angle=35), guide=guide, run=ONE)
    assert made.map.frame is not None
    found = labels[made.map.yx[..., 0], made.map.yx[..., 1]]
    assert (found == target).mean() > 0.95


def test_what_needs_whole_pixels_is_refused_before_work(monkeypatch: pytest.MonkeyPatch) -> None:
    turned, e = ia.ParallelControllable(angle=30), Exemplar.of(texture(30, 30, 3, 1))
    with monkeypatch.context() as patch:
        patch.setattr(ia.ParallelControllable, "synthesize", None)
        for blend in (ia.Blend(0, finish=(ia.Levelling(8),)), ia.Blend(4)):
            with pytest.raises(ia.ParameterError, match="turned, scaled"):
                ia.synthesize(e, 40, turned, blend=blend)
    made = ia.synthesize(e, 40, turned)
    with pytest.raises(ia.ParameterError, match="repair lays whole pixels over what is turned or scaled"):
        ia.repair(made, 1)
