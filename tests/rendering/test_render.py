"""Tests of the laws of rendering: exact copies, uniform exemplars, poses, planes of other sizes, refusals."""

from __future__ import annotations

from threading import Event

import numpy as np
import pytest
from numpy.typing import NDArray

from intarsia.foundation import CancelledError, InputError, ParameterError
from intarsia.foundation.blend import Blend, Levelling, Mixing
from intarsia.foundation.geometry import ISOMETRIES, Box, Isometry, Wrap
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.image import Kind, Plane, Transfer
from intarsia.model.sourcemap import HOLE, SourceMap
from intarsia.rendering import from_linear, to_linear
from intarsia.rendering.render import render

DTYPES = ["uint8", "uint16", "float16", "float32", "float64"]


def laid(isometry: Isometry, height: int, width: int) -> SourceMap:
    """Lay a whole exemplar down in a pose."""
    (a, b), (c, d) = isometry.j
    y0, x0 = isometry.start(height, width)
    i, j = np.mgrid[:width, :height] if isometry.swaps else np.mgrid[:height, :width]
    yx = np.stack([y0 + a * i + b * j, x0 + c * i + d * j], axis=2).astype(np.int32)
    return SourceMap(yx, pose=np.full(i.shape, isometry.id, np.uint8))


def noise_map(size: tuple[int, int], exemplar: tuple[int, int], seed: int = 0) -> SourceMap:
    """Draw a map without any order."""
    rng = np.random.default_rng(seed)
    yx = np.stack([rng.integers(0, n, size) for n in exemplar], axis=2).astype(np.int32)
    return SourceMap(yx, pose=rng.integers(0, 8, size).astype(np.uint8))


def cut_map(height: int, width: int, cut: int, jump: int) -> SourceMap:
    """Continue the exemplar `jump` px further right from column `cut` on, all 20 px inside it."""
    yx = np.stack(np.mgrid[20 : 20 + height, 20 : 20 + width], axis=2).astype(np.int32)
    yx[:, cut:, 1] += jump
    return SourceMap(yx)


def pixels_of(dtype: str, shape: tuple[int, ...], seed: int = 0) -> NDArray[np.generic]:
    """Draw pixels over the range of a type."""
    bits = np.random.default_rng(seed)
    if dtype == "bool":
        return bits.integers(0, 2, shape).astype(bool)
    if dtype[0] == "u":
        return bits.integers(0, np.iinfo(dtype).max + 1, shape).astype(dtype)
    return bits.random(shape).astype(dtype)


@pytest.mark.parametrize("dtype", [*DTYPES, "bool", "uint32"])
@pytest.mark.parametrize("channels", [None, 1, 4, 64])
def test_without_feather_every_pixel_is_an_exact_copy(dtype: str, channels: int | None) -> None:
    pixels = pixels_of(dtype, (11, 13) if channels is None else (11, 13, channels))
    smap = noise_map((17, 19), (11, 13))
    out = render([Exemplar.of(Plane(pixels, Kind.LABEL if dtype in ("bool", "uint32") else Kind.COLOUR))], smap)
    assert out.pixels.dtype == pixels.dtype
    assert out.pixels.tobytes() == pixels[smap.yx[..., 0], smap.yx[..., 1]].tobytes()


def test_kind_transfer_and_meta_are_kept() -> None:
    plane = Plane(pixels_of("uint16", (9, 9, 3)), Kind.COLOUR, Transfer.LINEAR, {"icc": b"profile"})
    for f in (0, 4):
        out = render([Exemplar.of(plane)], noise_map((6, 7), (9, 9)), blend=Blend(f))
        assert (out.kind, out.transfer, out.meta) == (plane.kind, plane.transfer, plane.meta)
        assert out.pixels.shape == (6, 7, 3)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("kind", [Kind.COLOUR, Kind.DATA, Kind.NORMAL, Kind.LABEL])
@pytest.mark.parametrize("mixing", list(Mixing))
def test_a_uniform_exemplar_stays_uniform(dtype: str, kind: Kind, mixing: Mixing) -> None:
    smap = noise_map((15, 16), (9, 8))
    smap = SourceMap(smap.yx) if kind is Kind.NORMAL else smap
    for seed in range(4):
        for channels in (3, 4) if kind is Kind.COLOUR else (3,):
            value = pixels_of(dtype, (1, 1, channels), seed)
            exemplar = Exemplar.of(Plane(np.tile(value, (9, 8, 1)), kind))
            assert (render([exemplar], smap, blend=Blend(5, mixing)).pixels == value).all()


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("kind", [Kind.COLOUR, Kind.DATA, Kind.NORMAL])
def test_one_piece_is_an_exact_copy_whatever_the_feather(dtype: str, kind: Kind) -> None:
    for channels in (3, 4) if kind is Kind.COLOUR else (3,):
        pixels = pixels_of(dtype, (12, 12, channels))
        for isometry in ISOMETRIES:
            smap, exemplar = laid(isometry, 12, 12), Exemplar.of(Plane(pixels, kind))
            for mixing in Mixing:
                sharp = render([exemplar], smap)
                soft = render([exemplar], smap, blend=Blend(5, mixing))
                assert sharp.pixels.tobytes() == soft.pixels.tobytes()


@pytest.mark.parametrize("dtype", ["uint16", "float64"])
def test_a_feather_of_the_overlap_is_the_classical_ramp(dtype: str) -> None:
    top = 60000 if dtype == "uint16" else 1.0
    pixels = np.zeros((60, 100), dtype)
    pixels[:, 50:] = top  # the left piece reads zeros, the right one the top
    out = render([Exemplar.of(Plane(pixels, Kind.DATA))], cut_map(10, 20, 8, 40), blend=Blend(5)).pixels
    # an overlap of columns 5..9 is cut at column 5 + ceil(5 / 2)
    want = np.concatenate([np.zeros(5), np.arange(1, 6) / 6, np.ones(10)]) * top
    assert (out == want.astype(dtype)).all()


def test_opposite_normals_leave_the_own_pixel() -> None:
    pixels = np.tile(np.array([[[1.0, 0, 0]]]), (60, 100, 1))
    pixels[:, 50:] = (-1.0, 0, 0)
    out = render([Exemplar.of(Plane(pixels, Kind.NORMAL))], cut_map(4, 20, 10, 40), blend=Blend(1)).pixels
    assert (out[:, :10] == (1, 0, 0)).all()
    assert (out[:, 10:] == (-1, 0, 0)).all()


def enlarged(smap: SourceMap, s: int) -> SourceMap:
    """Enlarge a map by laying down every pixel as a block of s x s in its pose."""
    yx = np.zeros((smap.height * s, smap.width * s, 2), np.int32)
    for y, x in np.ndindex(smap.height, smap.width):
        block = laid(ISOMETRIES[0 if smap.pose is None else smap.pose[y, x]], s, s).yx
        yx[y * s : y * s + s, x * s : x * s + s] = block + s * smap.yx[y, x]
    pose = None if smap.pose is None else smap.pose.repeat(s, 0).repeat(s, 1)
    return SourceMap(yx, pose=pose, wrap=smap.wrap)


@pytest.mark.parametrize("s", [2, 3])
def test_a_larger_plane_is_rendered_by_the_enlarged_map(s: int) -> None:
    large = pixels_of("uint16", (9 * s, 9 * s, 3))
    exemplar = Exemplar.of({"albedo": pixels_of("uint8", (9, 9)), "fine": large}, usable=pixels_of("bool", (9, 9), 4))
    usable = exemplar.usable.repeat(s, 0).repeat(s, 1)
    noise = noise_map((7, 8), (9, 9))
    smap = SourceMap(noise.yx, pose=noise.pose, wrap=Wrap.X)
    for f in (0, 3):
        out = render([exemplar], smap, "fine", Blend(f))
        want = render([Exemplar.of(large, usable=usable)], enlarged(smap, s), blend=Blend(f * s))
        assert (out.pixels == want.pixels).all()
    window = render([exemplar], smap, "fine", Blend(3), Box(2, -3, 6, 6))
    columns = np.arange(-3 * s, 6 * s) % (8 * s)
    assert (window.pixels == out.pixels[2 * s : 6 * s][:, columns]).all()


@pytest.mark.parametrize("kind", [Kind.COLOUR, Kind.DATA])
@pytest.mark.parametrize(("dtype", "channels"), [("uint8", 3), ("uint16", 4), ("float32", 1), ("float32", 4)])
def test_a_smaller_plane_is_averaged_in_blocks(kind: Kind, dtype: str, channels: int) -> None:
    small = Plane(pixels_of(dtype, (6, 5, channels)), kind)
    exemplar = Exemplar.of({"albedo": pixels_of("uint8", (12, 10)), "small": small})
    smap = noise_map((8, 12), (12, 10))
    out = render([exemplar], smap, "small", Blend(2))
    fine = render([Exemplar.of(Plane(small.pixels.repeat(2, 0).repeat(2, 1), kind))], smap, blend=Blend(2))
    light = to_linear(fine).astype(np.float64).reshape(4, 2, 6, 2, channels)
    if fine.alpha:
        alpha = light[..., -1:]
        mean = np.concatenate(
            [(light * alpha).sum(axis=(1, 3))[..., :-1] / alpha.sum(axis=(1, 3)), alpha.mean((1, 3))], 2
        )
    else:
        mean = light.mean(axis=(1, 3))
    np.testing.assert_allclose(out.samples, from_linear(mean, fine), rtol=1e-6)
    window = render([exemplar], smap, "small", Blend(2), Box(2, 4, 6, 10))
    assert (window.pixels == out.pixels[1:3, 2:5]).all()


@pytest.mark.parametrize("kind", Kind)
@pytest.mark.parametrize("f", [0, 3])
def test_a_smaller_plane_of_a_straight_map_is_a_copy(kind: Kind, f: int) -> None:
    small = Plane(pixels_of("uint8", (5, 6, 3)), kind)
    exemplar = Exemplar.of({"albedo": pixels_of("uint8", (15, 18)), "small": small})
    assert (render([exemplar], laid(ISOMETRIES[0], 15, 18), "small", Blend(f)).pixels == small.pixels).all()


def test_a_block_of_labels_takes_the_most_frequent_and_then_the_smallest() -> None:
    ids = Plane(np.array([[5, 9]], np.uint8), Kind.LABEL)
    exemplar = Exemplar.of({"albedo": np.zeros((2, 4), np.uint8), "id": ids})
    yx = np.zeros((2, 4, 2), np.int32)
    yx[..., 1] = [[0, 3, 2, 2], [3, 0, 2, 0]]
    assert render([exemplar], SourceMap(yx), "id").pixels.tolist() == [[5, 9]]


@pytest.mark.parametrize("blend", [*(Blend(6, mixing) for mixing in Mixing), Blend(finish=(Levelling(6),))], ids=str)
@pytest.mark.parametrize("toroidal", [False, True])
def test_masked_pixels_are_never_read(blend: Blend, toroidal: bool) -> None:
    usable = np.random.default_rng(1).random((30, 30)) < 0.7
    spots = np.argwhere(usable)
    smap = SourceMap(spots[np.random.default_rng(2).integers(0, len(spots), (20, 20))].astype(np.int32))
    pictures = []
    for junk in (np.nan, 1e30, -5.0):
        pixels = np.random.default_rng(0).random((30, 30, 3))
        pixels[~usable] = junk
        pictures.append(render([Exemplar.of(pixels, usable=usable, toroidal=toroidal)], smap, blend=blend).pixels)
    assert np.isfinite(pictures[0]).all()
    assert all((picture == pictures[0]).all() for picture in pictures)


def test_where_nobody_votes_the_pixel_speaks_for_itself() -> None:
    pixels = pixels_of("uint8", (6, 6, 3))
    usable = np.zeros((6, 6), bool)
    usable[0, 0] = True
    smap = SourceMap(np.full((3, 3, 2), 4, np.int32))
    assert (render([Exemplar.of(pixels, usable=usable)], smap, blend=Blend(2)).pixels == pixels[4, 4]).all()


def test_several_exemplars_must_fit() -> None:
    a = Exemplar.of({"albedo": pixels_of("uint8", (6, 6, 3)), "fine": pixels_of("uint8", (12, 12))}, name="a")
    b = Exemplar.of(pixels_of("uint8", (7, 5, 3)), name="b")
    c = Exemplar.of(pixels_of("uint16", (7, 5, 3)), name="c")
    yx, which = np.zeros((2, 2, 2), np.int32), np.array([[0, 1], [1, 0]], np.uint8)
    out = render([a, b], SourceMap(yx, which)).pixels
    assert (out[0, 0] == a.base.pixels[0, 0]).all()
    assert (out[0, 1] == b.base.pixels[0, 0]).all()
    with pytest.raises(InputError, match="b has no plane fine"):
        render([a, b], SourceMap(yx, which), "fine")
    with pytest.raises(InputError, match="albedo of c differs from that of a"):
        render([a, c], SourceMap(yx, which))


def test_refusals_are_one_line_and_say_what_to_do() -> None:
    sides = {"albedo": 6, "small": 3, "fine": 24}
    exemplar = Exemplar.of({name: pixels_of("uint8", (side, side)) for name, side in sides.items()})
    smap = SourceMap(np.zeros((5, 4, 2), np.int32), sources=(exemplar.source,))
    which = np.zeros((5, 4), np.uint8)
    which[2, 3] = HOLE
    far = SourceMap(np.full((5, 4, 2), 6, np.int32))
    cases = [
        (ParameterError, lambda: render([exemplar], smap, "gloss"), "albedo, small, fine"),
        (ParameterError, lambda: render([exemplar], smap, "small"), "multiples of 2"),
        (ParameterError, lambda: render([exemplar], smap, "fine", Blend(600)), "at most 500 px"),
        (ParameterError, lambda: render([exemplar], smap, box=Box(0, 0, 6, 4)), "0..5"),
        (InputError, lambda: render([exemplar], SourceMap(smap.yx, which)), "1 holes"),
        (InputError, lambda: render([exemplar], far), "outside"),
        (InputError, lambda: render([], smap), "0 are given"),
        (InputError, lambda: render([Exemplar.of(np.zeros((6, 7), np.uint8))], smap), "7x6"),
    ]
    for error, call, words in cases:
        with pytest.raises(error, match=words) as caught:
            call()
        assert "\n" not in str(caught.value)


def test_rendering_reports_and_can_be_cancelled() -> None:
    exemplar, smap = Exemplar.of(pixels_of("uint8", (9, 9))), noise_map((200, 5), (9, 9))
    heard: list[tuple[int, int]] = []
    render([exemplar], smap, run=Run(threads=1, step=lambda done, total, _: heard.append((done, total))))
    assert heard[-1][0] == heard[-1][1]
    stop = Event()
    stop.set()
    with pytest.raises(CancelledError):
        render([exemplar], smap, run=Run(cancel=stop))
