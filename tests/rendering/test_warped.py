"""Tests of maps with frames and fractions: the twin, exact cases, turned and scaled pictures, masks, windows, files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from long import going_round
from numpy.typing import NDArray
from rendering.naive_warped import NaiveWarped, flowing_pieces
from rendering.test_render import DTYPES, laid, noise_map, pixels_of

import intarsia as ia
from intarsia import files
from intarsia.analysis.features import features
from intarsia.cli import cli
from intarsia.foundation import InputError, ParameterError
from intarsia.foundation.blend import Blend, Levelling
from intarsia.foundation.geometry import ISOMETRIES, Box, Wrap
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.image import Kind, Plane
from intarsia.model.sourcemap import HOLE, SourceMap
from intarsia.rendering.render import render
from intarsia.tasks.completion import with_hole
from unweighed import seam_total

J = np.array([i.j for i in ISOMETRIES], np.float32)


def as_frames(smap: SourceMap, sub: bool = True) -> SourceMap:
    """Say the same in frames, and in fractions of 0."""
    pose = np.zeros(smap.yx.shape[:2], np.uint8) if smap.pose is None else smap.pose
    none = np.zeros(smap.yx.shape, np.float32) if sub else None
    return replace(smap, pose=None, frame=J[pose], sub=none)


def turn(angle: float, scale: float = 1.0) -> NDArray[np.float64]:
    """Return the frame that shows a picture turned by an angle in degrees, `scale` px of it in each px."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return scale * np.array([[c, s], [-s, c]])


def laid_by(j: NDArray[np.float64], size: tuple[int, int], exemplar: tuple[int, int]) -> SourceMap:
    """Lay an exemplar down by one frame, its middle in the middle; beyond its border its border pixels are named."""
    d = np.stack(np.mgrid[: size[0], : size[1]], axis=2) - (np.array(size) - 1) / 2
    u = d @ j.T + (np.array(exemplar) - 1) / 2
    yx = np.clip(np.floor(u + 0.5), 0, np.array(exemplar) - 1)
    return SourceMap(yx, frame=np.broadcast_to(j, (*size, 2, 2)), sub=np.clip(u - yx, -1, 1))


def wild_map(size: tuple[int, int], exemplar: tuple[int, int], seed: int = 0, wrap: Wrap = Wrap.NONE) -> SourceMap:
    """Draw a map without any order, with frames of all scales, some of them mirrored."""
    rng = np.random.default_rng(seed)
    n = size[0] * size[1]
    scales = np.clip(4.0 ** rng.normal(0, 0.5, n), 0.2, 7)
    frame = np.stack([turn(a, s) for a, s in zip(rng.random(n) * 360, scales, strict=True)])
    frame[::3, :, 0] *= -0.7
    yx = np.stack([rng.integers(0, n, size) for n in exemplar], axis=2)
    return SourceMap(yx, frame=frame.reshape(*size, 2, 2), sub=rng.random((*size, 2)) - 0.5, wrap=wrap)


def field_map(size: tuple[int, int], exemplar: tuple[int, int]) -> SourceMap:
    """Bend an exemplar smoothly, two pieces of it side by side."""
    d = np.stack(np.mgrid[: size[0], : size[1]], axis=2).astype(float)
    angle = 0.4 * np.sin(d[..., 1] / 7) + np.where(d[..., 1] > size[1] / 2, 0.5, 0)
    frame = np.stack([np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)], axis=2).reshape(*size, 2, 2)
    u = np.einsum("yxab,yxb->yxa", frame, d * 0.6) + np.array(exemplar) * 0.3
    u = np.clip(u, 0, np.array(exemplar) - 1)
    yx = np.floor(u + 0.5)
    return SourceMap(yx, frame=frame, sub=u - yx)


def assert_near(got: NDArray[np.generic], want: NDArray[np.generic]) -> None:
    """Equal but for the last bits; integers, where these decide a rounding, differ by 1 in at most 1 of 200."""
    if got.dtype.kind == "f":
        loose = {2: 2e-3, 4: 1e-5, 8: 1e-9}[got.dtype.itemsize]
        np.testing.assert_allclose(got.astype(float), want.astype(float), rtol=loose, atol=loose / 10)
    else:
        off = np.abs(got.astype(int) - want.astype(int))
        assert off.max() <= 1
        assert (off > 0).mean() <= 0.005


@pytest.mark.parametrize(
    ("dtype", "kind"), going_round(DTYPES, [Kind.NORMAL, Kind.COLOUR, Kind.DATA, Kind.LABEL])
)
def test_it_is_what_the_formula_says(dtype: str, kind: Kind) -> None:
    """Every pixel of wild maps, with masks, on a torus, around a wrapped canvas, equals the slow twin."""
    for channels in (1, 3, 4) if kind is Kind.COLOUR else (3,):
        pixels = pixels_of(dtype, (9, 8, channels))
        if kind is Kind.LABEL:
            pixels = np.round(pixels * (3 if dtype[0] == "f" else 1)).astype(dtype) % 4
        if channels == 4:
            pixels[:5, :, 3] = pixels[0, 0, 3]  # opacity varies in one half only
            pixels[7, :, 3] = 0
        usable = np.random.default_rng(5).random((9, 8)) < 0.9
        for mask, toroidal in ((None, False), (usable, False), (None, True), (usable, True)):
            exemplar = Exemplar.of(Plane(pixels, kind), usable=mask, toroidal=toroidal)
            smap = wild_map((5, 5), (9, 8), wrap=Wrap.X)
            if mask is not None:
                spots = np.argwhere(usable)
                smap = replace(smap, yx=spots[np.random.default_rng(1).integers(0, len(spots), (5, 5))])
            assert_near(render([exemplar], smap).samples, NaiveWarped([exemplar], smap).render())


def test_fractions_alone_and_several_exemplars_are_what_the_formula_says() -> None:
    """With poses and fractions, with pieces of two exemplars."""
    exemplars = [Exemplar.of(pixels_of("uint8", (9, 8, 3), n), name=str(n)) for n in range(2)]
    rng = np.random.default_rng(0)
    smap = replace(noise_map((8, 9), (9, 8)), which=rng.integers(0, 2, (8, 9)), sub=rng.random((8, 9, 2)) - 0.5)
    assert_near(render(exemplars, smap).samples, NaiveWarped(exemplars, smap).render())


@pytest.mark.parametrize("kind", list(Kind))
@pytest.mark.parametrize("green", ["gl", "dx"])
def test_bent_fields_are_what_the_formula_says(kind: Kind, green: str) -> None:
    meta = {"normals": green}
    pixels = pixels_of("uint8", (12, 12, 3))
    pixels = np.repeat(np.repeat(pixels[:4, :4], 3, 0), 3, 1) // 2 + 60 if kind is not Kind.LABEL else pixels % 3
    exemplar = Exemplar.of(Plane(pixels, kind, meta=meta))
    smap = field_map((9, 14), (12, 12))
    assert_near(render([exemplar], smap).samples, NaiveWarped([exemplar], smap).render())


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("kind", list(Kind))
def test_frames_that_are_isometries_are_exact(dtype: str, kind: Kind) -> None:
    """Bit for bit what poses give, identity included."""
    smap = noise_map((17, 19), (11, 13))
    usable = np.random.default_rng(7).random((11, 13)) < 0.8
    for channels in (1, 2, 3, 4) if kind is Kind.COLOUR else (3,):
        plane = Plane(pixels_of(dtype, (11, 13, channels)), kind)
        for mask in (None, usable):
            exemplar = Exemplar.of(plane, usable=mask)
            want, got = (render([exemplar], m).pixels for m in (smap, as_frames(smap)))
            assert got.tobytes() == want.tobytes()
    upright = SourceMap(smap.yx)
    exemplar = Exemplar.of(plane)
    for same in (as_frames(upright, sub=False), replace(upright, sub=np.zeros(smap.yx.shape))):
        assert render([exemplar], same).pixels.tobytes() == render([exemplar], upright).pixels.tobytes()


@pytest.mark.parametrize("isometry", ISOMETRIES, ids=lambda i: i.name)
@pytest.mark.parametrize("s", [2, 3])
def test_larger_planes_of_isometries_are_exact(isometry: ia.foundation.geometry.Isometry, s: int) -> None:
    planes = {"albedo": pixels_of("uint8", (8, 6)), "fine": pixels_of("uint8", (8 * s, 6 * s, 3))}
    planes |= {"normal": pixels_of("uint16", (8 * s, 6 * s, 3))}
    exemplar, smap = Exemplar.of(planes), laid(isometry, 8, 6)
    for name in ("fine", "normal"):
        want, got = (render([exemplar], m, name).pixels for m in (smap, as_frames(smap)))
        assert got.tobytes() == want.tobytes()


def waves(y: NDArray[np.float64], x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Paint a smooth picture anywhere; the shortest wave is 12 px long."""
    return 0.5 + 0.2 * np.sin(y / 2.5 + x / 4) + 0.2 * np.sin(x / 2 - y / 7)


def bumps(y: NDArray[np.float64], x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the slope of a smooth height, down and right."""
    return 0.4 * np.cos(y / 5 + x / 9) / 5 * 4, 0.4 * np.cos(y / 5 + x / 9) / 9 * 4 - 0.3 * np.sin(x / 6)


@pytest.mark.parametrize("green", ["gl", "dx"])
@pytest.mark.parametrize("j", [turn(30), turn(-50, 0.6), turn(10, 1.2) @ np.diag([1, -1])], ids=["30", "0.6", "mirror"])
def test_bumps_stay_lit_from_the_same_side(green: str, j: NDArray[np.float64]) -> None:
    """The slope of the turned height is J^T times its own, and a picture shown smaller is steeper."""
    sign = 1 if green == "dx" else -1

    def coded(slope: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
        n = np.stack([-slope[1], -sign * slope[0], np.ones_like(slope[0])], axis=2)
        return n / np.linalg.norm(n, axis=2, keepdims=True)

    smap = laid_by(j, (40, 40), (96, 96))
    at = smap.yx + smap.sub.astype(float)
    here = bumps(at[..., 0], at[..., 1])
    want = coded([j[0, a] * here[0] + j[1, a] * here[1] for a in (0, 1)])
    plane = Plane(coded(bumps(*np.mgrid[:96, :96].astype(float))), Kind.NORMAL, meta={"normals": green})
    got = render([Exemplar.of(plane)], smap).pixels
    np.testing.assert_allclose(got, want, atol=0.01)
    np.testing.assert_allclose(np.linalg.norm(got, axis=2), 1, atol=1e-12)


@pytest.mark.parametrize("kind", [Kind.COLOUR, Kind.DATA, Kind.NORMAL, Kind.LABEL])
def test_masked_pixels_are_never_read(kind: Kind) -> None:
    usable = np.random.default_rng(1).random((30, 30)) < 0.6
    spots = np.argwhere(usable)
    smap = replace(wild_map((20, 20), (30, 30)), yx=spots[np.random.default_rng(2).integers(0, len(spots), (20, 20))])
    pixels = np.random.default_rng(0).random((30, 30, 3))
    if kind is Kind.LABEL:
        pixels = np.where(usable[..., None], 1.0, 7.0) * np.ones(3)
    else:
        pixels[~usable] = np.nan
    for toroidal in (False, True):
        exemplar = Exemplar.of(Plane(pixels, kind), usable=usable, toroidal=toroidal)
        out = render([exemplar], smap).pixels
        assert np.isfinite(out).all()
        assert kind is not Kind.LABEL or (out == 1).all()


def test_where_nothing_may_be_read_the_own_pixel_is_copied() -> None:
    """A picture under a start map may be wholly masked."""
    pixels = pixels_of("uint8", (6, 6, 3))
    exemplar = Exemplar.of(pixels, usable=np.zeros((6, 6), bool))
    smap = wild_map((5, 5), (6, 6))
    assert (render([exemplar], smap).pixels == pixels[smap.yx[..., 0], smap.yx[..., 1]]).all()


def test_windows_are_crops_whatever_the_threads() -> None:
    planes = {
        "albedo": pixels_of("uint8", (12, 10, 4)), "fine": pixels_of("float32", (24, 20, 3)),
        "height": pixels_of("uint16", (6, 5)), "normal": pixels_of("uint8", (12, 10, 3)),
        "ids": pixels_of("uint8", (12, 10)) % 3,
    }  # fmt: skip
    exemplar, smap = Exemplar.of(planes), wild_map((150, 12), (12, 10), wrap=Wrap.BOTH)
    for name in planes:
        scale = {"fine": (2, 1), "height": (1, 2)}.get(name, (1, 1))
        whole = render([exemplar], smap, name, run=Run(1)).pixels
        assert whole.tobytes() == render([exemplar], smap, name, run=Run(3)).pixels.tobytes()
        for box in (Box(8, 2, 40, 6), Box(-10, -4, 20, 30), Box(2**30 * 150, 0, 2**30 * 150 + 4, 2)):
            part = render([exemplar], smap, name, box=box).pixels
            rows, columns = (
                np.arange(a * scale[0] // scale[1], b * scale[0] // scale[1]) % n
                for a, b, n in zip((box.y0, box.x0), (box.y1, box.x1), whole.shape, strict=False)
            )
            assert part.tobytes() == np.ascontiguousarray(whole[rows][:, columns]).tobytes()
        cut = smap.window(Box(100, 0, 140, 12))
        there = slice(100 * scale[0] // scale[1], 140 * scale[0] // scale[1])
        assert render([exemplar], cut, name).pixels.tobytes() == whole[there].tobytes()


def test_a_larger_plane_shows_the_same_place() -> None:
    """The plane twice as large of a smooth picture, averaged, is the picture."""
    fine = waves(*((np.mgrid[:192, :192] + 0.5) / 2 - 0.5))
    base = fine.reshape(96, 2, 96, 2).mean(axis=(1, 3))
    exemplar = Exemplar.of({"base": Plane(base, Kind.DATA), "fine": Plane(fine, Kind.DATA)})
    for j in (turn(30), turn(-20, 0.7), turn(45, 1.3)):
        smap = laid_by(j, (40, 40), (96, 96))
        large, own = render([exemplar], smap, "fine").pixels, render([exemplar], smap).pixels
        np.testing.assert_allclose(large.reshape(40, 2, 40, 2).mean(axis=(1, 3)), own, atol=0.01)


def test_a_smaller_plane_is_averaged() -> None:
    small = Plane(pixels_of("uint16", (6, 5)), Kind.DATA)
    exemplar = Exemplar.of({"albedo": pixels_of("uint8", (12, 10)), "small": small})
    wide = Exemplar.of(Plane(small.pixels.repeat(2, 0).repeat(2, 1), Kind.DATA))
    smap = wild_map((8, 12), (12, 10))
    fine = render([wide], smap).pixels.astype(int).reshape(4, 2, 6, 2).sum(axis=(1, 3))
    assert (render([exemplar], smap, "small").pixels == (fine + 2) // 4).all()


def test_a_map_keeps_its_frames(tmp_path: Path) -> None:
    """Saved, loaded, cut and compared; a map without them is told from one with them."""
    smap = wild_map((7, 9), (12, 10))
    smap.save(tmp_path / "map.npz")
    again = SourceMap.load(tmp_path / "map.npz")
    assert (again.frame == smap.frame).all()
    assert (again.sub == smap.sub).all()
    assert (again.digest, again.to_bytes()) == (smap.digest, smap.to_bytes())
    assert not again.exact
    assert SourceMap(smap.yx).exact
    part = smap.window(Box(2, 3, 5, 9))
    assert (part.frame == smap.frame[2:5, 3:9]).all()
    assert (part.sub == smap.sub[2:5, 3:9]).all()
    frame, sub = smap.frame.copy(), smap.sub.copy()
    frame[3, 3, 1, 0] += 0.01
    sub[6, 8, 1] += 0.01
    others = [replace(smap, **change) for change in ({"frame": frame}, {"sub": sub}, {"frame": None}, {"sub": None})]
    assert len({m.digest for m in (smap, SourceMap(smap.yx), *others)}) == 6
    with pytest.raises(ValueError, match="read-only"):
        smap.frame[0, 0] = 0


def test_a_map_without_frames_is_saved_as_before() -> None:
    """Digest and arrays of a file as they were before maps held frames."""
    smap = noise_map((6, 5), (9, 8))
    assert smap.digest == "9c4b08d96cabb1212e1986a7c007ef03287bad28d09b09c29acc04965e3bc693"
    with np.load(io.BytesIO(smap.to_bytes())) as data:
        assert list(data) == ["yx", "about", "pose"]


def test_what_no_picture_can_be_drawn_from_is_refused() -> None:
    smap = wild_map((4, 4), (8, 8))
    frame, sub = smap.frame.copy(), smap.sub.copy()
    cases = [
        ({"pose": np.zeros((4, 4))}, "both pose and frame"), ({"frame": np.ones((4, 4, 2))}, "does not fit"),
        ({"sub": np.ones((4, 3, 2))}, "does not fit"),
    ]  # fmt: skip
    for values, words in (
        ((np.nan, 0, 0, 1), "frame holds 1 matrices"), ((1, 1, 1, 1), "frame holds 1 matrices"),
        ((9, 0, 0, 9), "more than 64"), ((0.1, 0, 0, 0.1), "less than 1/64"), ((100, 0, 0, 0.1), "more than 64 px"),
    ):  # fmt: skip
        frame[1, 2] = np.reshape(values, (2, 2))
        cases.append(({"frame": frame.copy()}, words))
    for sub[1, 2, 0], words in ((np.inf, "sub holds 1 fractions"), (1.5, "beyond 1 px")):
        cases.append(({"sub": sub.copy()}, words))
    for change, words in cases:
        with pytest.raises(InputError, match=words) as caught:
            replace(smap, **change)
        assert "\n" not in str(caught.value)
    which = np.zeros((4, 4), np.uint8)
    which[1, 2] = HOLE
    frame[1, 2], sub[1, 2] = 0, np.nan
    assert replace(smap, which=which, frame=frame, sub=sub).holes.sum() == 1  # in holes nothing is read


def test_blends_that_need_whole_pixels_are_refused() -> None:
    exemplar = Exemplar.of({"albedo": pixels_of("uint8", (8, 8, 3)), "normal": pixels_of("uint8", (8, 8, 3))})
    smap = wild_map((4, 4), (8, 8))
    level = Blend(finish=(Levelling(4),))
    far = replace(smap, yx=np.full((4, 4, 2), 9))
    which, start = np.full((4, 4), HOLE, np.uint8), replace(smap, sources=(exemplar.source,))
    cases = [
        (ParameterError, lambda: render([exemplar], smap, blend=level), "even-tone 0"),
        (ParameterError, lambda: render([exemplar], smap, blend=Blend(2)), "--feather 0"),
        (ParameterError, lambda: render([exemplar], smap, "normal", Blend(2)), "--feather 0"),
        (InputError, lambda: render([exemplar], far), "outside"),
        (InputError, lambda: render([exemplar], replace(smap, which=which)), "16 holes"),
        (InputError, lambda: ia.synthesize(exemplar, None, "image-quilting", start=start), "no method"),
    ]
    for error, call, words in cases:
        with pytest.raises(error, match=words) as caught:
            call()
        assert "\n" not in str(caught.value)
    assert render([exemplar], smap, "normal", level).pixels.shape == (4, 4, 3)  # no finish touches normals


def test_pieces_go_on_by_their_frames() -> None:
    """One turned piece is one; what the kernel numbers is what flooding finds."""
    assert len(np.unique(laid_by(turn(30, 1 / 1.7), (30, 30), (96, 96)).pieces())) == 1
    posed = replace(noise_map((9, 9), (4, 4)), sub=np.zeros((9, 9, 2)))
    for smap in (wild_map((12, 13), (20, 20)), field_map((20, 30), (40, 40)), posed):
        which = np.random.default_rng(3).integers(0, 2, smap.yx.shape[:2]).astype(np.uint8)
        which[2:4] = HOLE
        for own in (smap, replace(smap, which=which)):
            assert (own.pieces() == flowing_pieces(own)).all()
    assert len(np.unique(field_map((20, 30), (40, 40)).pieces())) > 1


def test_the_st_map_has_fractions() -> None:
    exemplar = Exemplar.of(pixels_of("uint8", (8, 16)))
    smap = replace(laid_by(turn(30), (5, 6), (8, 16)), sources=(exemplar.source,))
    at = smap.yx + smap.sub.astype(float)
    np.testing.assert_allclose(smap.st_map()[..., 0], (at[..., 1] + 0.5) / 16, atol=1e-6)
    np.testing.assert_allclose(smap.st_map()[..., 1], 1 - (at[..., 0] + 0.5) / 8, atol=1e-6)


def test_seams_of_a_turned_piece_cost_nothing() -> None:
    """Measurements know such maps: one turned piece has no seam, pieces at random have many."""
    exemplar = Exemplar.of(pixels_of("uint8", (96, 96, 3)))
    whole = replace(laid_by(turn(30, 0.7), (48, 48), (96, 96)), sources=(exemplar.source,))
    torn = replace(wild_map((48, 48), (96, 96)), sources=(exemplar.source,))
    feats = features([exemplar])
    assert seam_total(feats, [exemplar], whole) == 0
    assert seam_total(feats, [exemplar], torn) > 48 * 48
    assert whole.usage()[0].sum() == 48 * 48


def test_a_hole_in_such_a_map_holds_nothing() -> None:
    out = with_hole(wild_map((5, 6), (8, 8)), np.arange(30).reshape(5, 6) == 15)
    assert out.holes.sum() == 1
    assert (out.frame[2, 3] == np.eye(2)).all()
    assert (out.sub[2, 3] == 0).all()


def test_the_command_draws_such_maps(tmp_path: Path) -> None:
    """`intarsia render` draws what the library draws, a window too, and refuses to level it in one line."""
    exemplar = ia.read("sample:stones")
    smap = replace(laid_by(turn(30, 1.7), (50, 60), (exemplar.height, exemplar.width)), sources=(exemplar.source,))
    saved, out = tmp_path / "map.npz", tmp_path / "out.png"
    smap.save(saved)
    for more, part in (([], np.s_[:]), (["--window", "10,20,30,16"], np.s_[20:36, 10:40])):
        told = CliRunner().invoke(cli, ["render", str(saved), "-o", str(out), "--force", *more])
        assert told.exit_code == 0, told.stderr
        assert (files.read_plane(out).pixels == render([exemplar], smap).pixels[part]).all()
    refused = CliRunner().invoke(cli, ["render", str(saved), "-o", str(out), "--force", "--even-tone", "8"])
    assert refused.exit_code == 2
    assert "--even-tone 0" in refused.stderr
