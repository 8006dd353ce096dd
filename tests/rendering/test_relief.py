"""Turned relief: normals, height and shading of an output tell of one surface, lit from one side."""

from __future__ import annotations

import numpy as np
import pytest
from naive import unbroken
from numpy.typing import NDArray

import intarsia as ia
from intarsia import Kind, Plane
from intarsia.analysis import features

F = NDArray[np.float64]

SIDE, STEEP = 96, 6.0
LIGHT = np.array([-0.5, 0.6, 0.62])
"""From the upper left, toward the viewer: x to the right, y up."""


def bumps(side: int = SIDE) -> F:
    """Heights of 0..1 that continue over the borders and look different in all eight poses."""
    y, x = np.mgrid[:side, :side] * (2 * np.pi / side)
    out = np.zeros((side, side))
    rng = np.random.default_rng(7)
    for _ in range(24):
        k, m = rng.integers(-6, 7, 2)
        out += np.sin(k * y + m * x + rng.uniform(0, 6.28)) / (1 + abs(k) + abs(m))
    out -= out.min()
    return np.asarray(out / out.max())


def normals_of(height: F, wrap: bool = False) -> F:
    """Unit vectors (H, W, 3) of a relief, x to the right, y up, z toward the viewer."""
    around = np.pad(height, 1, mode="wrap" if wrap else "edge") * STEEP
    right = (around[1:-1, 2:] - around[1:-1, :-2]) / 2
    down = (around[2:, 1:-1] - around[:-2, 1:-1]) / 2
    n = np.dstack([-right, down, np.ones(height.shape)])
    return np.asarray(n / np.sqrt((n * n).sum(axis=2))[..., None])


def coded(n: F, coding: str) -> Plane:
    """A normal map: of 8 or 16 bit, green up or down, or of floats from -1 to 1 or from 0 to 1."""
    n = n * [1, -1, 1] if coding.endswith("dx") else n
    about = {"normals": "dx"} if coding.endswith("dx") else {}
    if coding.startswith("signed"):
        return Plane(n.astype(np.float32), Kind.NORMAL, meta=about)
    share = (n + 1) / 2
    if coding.startswith("unsigned"):
        return Plane(share.astype(np.float32), Kind.NORMAL, meta=about)
    top, dtype = (255, np.uint8) if coding.startswith("8") else (65535, np.uint16)
    return Plane(np.floor(share * top + 0.5).astype(dtype), Kind.NORMAL, meta=about)


def vectors(plane: Plane, coding: str) -> F:
    """What a normal map says."""
    n = plane.pixels.astype(np.float64)
    if not coding.startswith("signed"):
        n = 2 * n / (np.iinfo(plane.pixels.dtype).max if plane.pixels.dtype.kind == "u" else 1) - 1
    n = n * [1, -1, 1] if coding.endswith("dx") else n
    return np.asarray(n / np.sqrt((n * n).sum(axis=2))[..., None])


def relief(coding: str, times: int = 1) -> ia.Exemplar:
    """Albedo by how open a place is, which light does not change; height; and normals, perhaps of `times` the size."""
    height = bumps()
    albedo = np.floor(60 + 150 * height + 0.5).astype(np.uint8)
    n = normals_of(bumps(SIDE * times) * times, wrap=True)
    return ia.Exemplar.of({
        "albedo": np.dstack([albedo, albedo, 255 - albedo]), "height": Plane(height.astype(np.float32), Kind.DATA),
        "normal": coded(n, coding),
    })  # fmt: skip


def inside(smap: ia.SourceMap, far: int) -> NDArray[np.bool_]:
    """Pixels that lie so far from seams and borders of the output."""
    going_on = [unbroken(smap, axis) for axis in (0, 1)]
    joined = going_on[0] & going_on[1] & np.roll(going_on[0], 1, 0) & np.roll(going_on[1], 1, 1)
    for _ in range(far):
        joined = np.logical_and.reduce([np.roll(joined, d, a) for a in (0, 1) for d in (-1, 0, 1)])
    edge = far + 2
    joined[:edge] = joined[-edge:] = joined[:, :edge] = joined[:, -edge:] = False
    return np.asarray(joined)


def grown(coding: str, feather: int = 0, times: int = 1) -> ia.Synthesis:
    method = ia.ImageQuilting(patch=32, isometries=tuple(range(8)), tolerance=0.3)
    return ia.synthesize(relief(coding, times), 192, method, seed=2, blend=ia.Blend(feather))


def angles(made: ia.Synthesis, coding: str, far: int) -> tuple[F, F]:
    """Angles in degrees between drawn normals and those of the drawn height, and differences of shading, in pieces."""
    drawn, from_height = vectors(made.render("normal"), coding), normals_of(made.render("height").pixels)
    seen = inside(made.map, far)
    assert seen.mean() > 0.3
    assert set(np.unique(made.map.turns[seen])) == set(range(8))
    cosine = np.clip((drawn * from_height).sum(axis=2), -1, 1)
    lit = [np.clip(n @ LIGHT, 0, 1) for n in (drawn, from_height)]
    return np.degrees(np.arccos(cosine))[seen], np.abs(lit[0] - lit[1])[seen]


CODINGS = {"8 gl": 0.5, "8 dx": 0.5, "16 gl": 0.01, "16 dx": 0.01, "signed gl": 0.01, "unsigned dx": 0.01}
"""How normals are stored -> degrees that rounding may turn them, on average."""


@pytest.mark.parametrize("coding", CODINGS)
def test_normals_agree_with_the_height_in_every_pose(coding: str) -> None:
    angle, light = angles(grown(coding), coding, 0)
    assert angle.mean() < CODINGS[coding]
    assert angle.max() < 8 * CODINGS[coding]
    assert light.mean() < CODINGS[coding] / 50


def test_the_axis_of_green_changes_no_map() -> None:
    """The same relief grows the same, stored for OpenGL or for DirectX."""
    one, two = grown("16 gl"), grown("16 dx")
    assert np.array_equal(one.map.yx, two.map.yx)
    assert np.array_equal(one.map.turns, two.map.turns)


def test_normals_agree_within_the_feather_of_pieces() -> None:
    """Away from seams by more than the feather nothing is mixed; all over the picture the light stays on one side."""
    made = grown("16 gl", 4)
    angle, _ = angles(made, "16 gl", 4)
    assert angle.mean() < 0.01
    drawn, from_height = vectors(made.render("normal"), "16 gl"), normals_of(made.render("height").pixels)
    shades = [np.clip(n @ LIGHT, 0, 1).ravel() for n in (drawn, from_height)]
    assert np.corrcoef(*shades)[0, 1] > 0.95


@pytest.mark.parametrize("coding", ["16 gl", "16 dx", "signed gl", "signed dx", "unsigned dx"])
@pytest.mark.parametrize("pose", range(8))
def test_what_is_compared_is_turned_as_what_is_drawn(pose: int, coding: str) -> None:
    """Features of the posed relief are those of a relief that is posed before its normals are taken."""
    alone = ia.Exemplar.of({"normal": relief(coding).planes["normal"]})
    turned = features.transformed(bumps(), pose)
    other = ia.Exemplar.of({"normal": coded(normals_of(np.ascontiguousarray(turned), wrap=True), coding)})
    here, there = features.features([alone]).posed(0, pose), features.features([other]).pictures[0]
    assert np.abs(here.astype(int) - there).max() <= 1
