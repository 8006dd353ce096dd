"""Tests of pieces and of rendering with a feather, against the direct sum over all taps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rendering.naive_votes import NaiveRenderer, pieces

from intarsia.foundation.blend import Blend, Mixing
from intarsia.foundation.geometry import ISOMETRIES, Box, Wrap
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.image import Kind, Plane, Transfer
from intarsia.model.sourcemap import HOLE, SourceMap
from intarsia.rendering.render import render

ONE = Run(threads=1)


def random_pixels(rng: np.random.Generator, shape: tuple[int, ...], dtype: str) -> np.ndarray:
    """Draw pixels of any dtype; few values, so that some agree."""
    if dtype == "bool":
        return rng.random(shape) < 0.4
    if dtype.startswith("u"):
        return rng.choice(rng.integers(0, np.iinfo(dtype).max + 1, 40), shape).astype(dtype)
    return rng.choice(rng.random(40), shape).astype(dtype)


def random_map(
    rng: np.random.Generator, exemplars: list[Exemplar], size: tuple[int, int], wrap: Wrap, noise: float
) -> SourceMap:
    """Draw a map of a few pieces in any pose, with a share of stray pixels."""
    height, width = size
    region = rng.integers(0, 4, (-(-height // 4), -(-width // 5))).repeat(4, 0).repeat(5, 1)[:height, :width]
    which, pose = np.zeros(size, np.uint8), np.zeros(size, np.uint8)
    yx = np.zeros((*size, 2), np.int32)
    keys = [(rng.integers(len(exemplars)), rng.integers(8), rng.integers(0, 20), rng.integers(0, 20)) for _ in range(4)]
    for y, x in np.ndindex(size):
        w, p, oy, ox = keys[region[y, x]]
        if rng.random() < noise:
            w, p, oy, ox = (rng.integers(len(exemplars)), rng.integers(8), rng.integers(0, 20), rng.integers(0, 20))
        (a, b), (c, d) = ISOMETRIES[p].j
        e = exemplars[w]
        which[y, x], pose[y, x] = w, p
        yx[y, x] = (oy + a * y + b * x) % e.height, (ox + c * y + d * x) % e.width
    return SourceMap(yx, which, pose, tuple(e.source for e in exemplars), wrap)


def scene(
    seed: int, dtype: str, channels: int, kind: Kind = Kind.COLOUR, transfer: str = "srgb"
) -> tuple[list[Exemplar], SourceMap]:
    """Draw two exemplars of unequal size, one or both with a mask or toroidal, and a map of them."""
    rng = np.random.default_rng(seed)
    exemplars = []
    for height, width in ((9, 12), (7, 6)):
        usable = rng.random((height, width)) < 0.95 if rng.random() < 0.5 else None
        pixels = random_pixels(rng, (height, width, channels), dtype)
        plane = Plane(pixels, kind, Transfer(transfer))
        exemplars.append(Exemplar({"albedo": plane}, usable, bool(rng.random() < 0.5)))
    wrap = list(Wrap)[rng.integers(4)]
    size = (int(rng.integers(5, 10)), int(rng.integers(5, 12)))
    return exemplars, random_map(rng, exemplars, size, wrap, float(rng.choice([0, 0.05, 0.7])))


seeds = st.integers(0, 1 << 20)
feathers = st.sampled_from([1, 2, 3, 5, 8])


@settings(max_examples=25, deadline=None)
@given(seeds)
def test_pieces_are_found_as_by_flooding(seed: int) -> None:
    _, smap = scene(seed, "uint8", 1)
    which = smap.which.copy()
    which[np.random.default_rng(seed).random(which.shape) < 0.1] = HOLE
    smap = SourceMap(smap.yx, which, smap.pose)
    assert (smap.pieces() == pieces(smap)).all()


COLOUR = [Kind.COLOUR]
PICTURES = {
    "integers": ([("uint8", 3), ("uint16", 1), ("uint8", 4), ("uint16", 2)], COLOUR, [Mixing.MEAN, Mixing.SOURCE]),
    "data": ([(d, c) for d in ("uint8", "uint16") for c in (1, 2, 3)], [Kind.DATA], [Mixing.MEAN]),
    "floats": ([(d, c) for d in ("float16", "float32", "float64") for c in (1, 2, 3, 4)], COLOUR, [Mixing.MEAN]),
    "normals": ([(d, 3) for d in ("uint8", "uint16", "float32", "float64")], [Kind.NORMAL], [Mixing.MEAN]),
    "labels": ([("uint8", 1), ("uint32", 1), ("uint8", 2), ("bool", 1)], [Kind.LABEL], [Mixing.MEAN]),
}


@pytest.mark.parametrize("name", PICTURES)
def test_pictures_equal_the_sum_over_taps(name: str) -> None:
    """Whole numbers exactly, but for normals; floats to their precision."""
    depths, kinds, mixings = PICTURES[name]

    @settings(max_examples=25, deadline=None)
    @given(
        seeds, feathers, st.sampled_from(depths), st.sampled_from(kinds), st.sampled_from(mixings),
        st.sampled_from(["srgb", "linear"] if name in ("integers", "floats") else ["srgb"]),
    )  # fmt: skip
    def check(seed: int, f: int, depth: tuple[str, int], kind: Kind, mixing: Mixing, transfer: str) -> None:
        exemplars, smap = scene(seed, *depth, kind=kind, transfer=transfer)
        got = render(exemplars, smap, blend=Blend(f, mixing), run=ONE).samples
        want = NaiveRenderer(exemplars, smap, f, mixing).render()
        assert got.dtype == np.dtype(depth[0])
        if name == "normals":
            np.testing.assert_allclose(got, want, rtol=1e-6, atol=1e-7 if depth[0][0] == "f" else 0)
        else:
            loose = {"float16": 2e-3, "float32": 3e-7, "float64": 1e-12}.get(depth[0], 0)
            np.testing.assert_allclose(got, want, rtol=loose)

    check()


@settings(max_examples=25, deadline=None)
@given(seeds, st.sampled_from([0, 1, 5, 8]), st.sampled_from([("uint8", 3), ("float32", 3), ("float64", 4)]), st.data())
def test_a_window_is_the_crop_of_the_whole(seed: int, f: int, depth: tuple[str, int], data: st.DataObject) -> None:
    exemplars, smap = scene(seed, *depth)
    whole = render(exemplars, smap, blend=Blend(f), run=ONE).samples
    spans = []
    for length, wraps in ((smap.height, smap.wrap.y), (smap.width, smap.wrap.x)):
        start = data.draw(st.integers(-2 * length, 2 * length) if wraps else st.integers(0, length - 1))
        spans.append((start, data.draw(st.integers(start + 1, start + 2 * length if wraps else length))))
    (y0, y1), (x0, x1) = spans
    window = render(exemplars, smap, blend=Blend(f), box=Box(y0, x0, y1, x1), run=ONE).samples
    crop = whole[np.ix_(np.arange(y0, y1) % smap.height, np.arange(x0, x1) % smap.width)]
    assert window.tobytes() == crop.tobytes()


@pytest.mark.parametrize("depth", [("uint8", 3), ("float32", 4), ("float64", 3)])
def test_cells_and_threads_change_no_byte(depth: tuple[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    exemplars, _ = scene(5, *depth)
    smap = random_map(np.random.default_rng(3), exemplars, (70, 50), Wrap.X, 0.02)
    results = {render(exemplars, smap, blend=Blend(7), run=Run(threads=n)).pixels.tobytes() for n in (1, 2, 4)}
    for rows, columns in ((9, 13), (1, 200)):
        monkeypatch.setattr("intarsia.rendering.render._ROWS", rows)
        monkeypatch.setattr("intarsia.rendering.render._COLUMNS", columns)
        results.add(render(exemplars, smap, blend=Blend(7), run=Run(threads=2)).pixels.tobytes())
    assert len(results) == 1


def test_holes_in_the_surroundings_do_not_vote() -> None:
    exemplars, smap = scene(8, "uint8", 3)
    smap = random_map(np.random.default_rng(1), exemplars, (9, 10), Wrap.NONE, 0.0)
    which = smap.which.copy()
    which[:, 7:] = HOLE
    holed = SourceMap(smap.yx, which, smap.pose, smap.sources)
    got = render(exemplars, holed, blend=Blend(5), box=Box(0, 0, 9, 7), run=ONE).samples
    naive = NaiveRenderer(exemplars, holed, 5)
    assert all((got[y, x] == naive.pixel(y, x)).all() for y in range(9) for x in range(7))


def test_more_labels_than_slots() -> None:
    rng = np.random.default_rng(0)
    labels = rng.integers(0, 1 << 32, (20, 20), dtype=np.uint32)
    exemplars = [Exemplar({"id": Plane(labels, Kind.LABEL)})]
    smap = random_map(rng, exemplars, (12, 13), Wrap.BOTH, 1.0)
    assert (
        render(exemplars, smap, blend=Blend(6), run=ONE).samples == NaiveRenderer(exemplars, smap, 6).render()
    ).all()


def test_the_largest_feather_of_16_bit_opacity_stays_within_64_bits() -> None:
    pixels = np.full((40, 40, 4), 65535, np.uint16)
    pixels[:, 20:] = (65535, 12345, 1, 65535)
    yx = np.stack(np.mgrid[:30, :30], axis=2).astype(np.int32)
    yx[:, 15:, 1] += 5
    exemplar = Exemplar.of(pixels, toroidal=True)
    out = render([exemplar], SourceMap(yx, wrap=Wrap.BOTH), blend=Blend(1024), run=ONE).samples
    assert (out[..., [0, 3]] == 65535).all()
    assert (out[..., 1] >= 12345).all()
