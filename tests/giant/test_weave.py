"""Endless textures: any window alone; streamed into files that are checked, and the same however they are cut."""

from __future__ import annotations

import re
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest
from giant.giants import SMALL, files_below, needs, small
from hypothesis import given, settings
from hypothesis import strategies as st

import intarsia as ia
from intarsia.files import read_plane, read_recipe
from intarsia.foundation import ParameterError, ResourceError
from intarsia.foundation.geometry import Box
from intarsia.giant import exports, zarrays
from intarsia.testing import as_depth, texture
from intarsia.testing.cases import noise

FAR = (0, -7, 2**31 - 20, -(2**31) - 20, 2**40 - 400, -(2**40) + 300)
WHERE = st.sampled_from(FAR)
METHODS = [SMALL, ia.NearRegular(lattice=((0, 16),)), ia.BestTile(lattice=((20, 0), (3, 17))), ia.Repeat()]


@settings(max_examples=12)
@given(st.sampled_from(METHODS), WHERE, WHERE, st.integers(0, 9), st.integers(0, 60), st.integers(1, 70))
def test_a_window_is_a_crop_of_a_larger_one(
    method: Any, y: int, x: int, feather: int, down: int, side: int
) -> None:
    """Law 5, drawn: with feathers, at the origin, across 2**31 and as far as 2**40; an exemplar of 137 x 200 px."""
    woven = ia.weave(texture(137, 200, 3, 4), method, 9, blend=ia.Blend(feather))
    large = woven[y : y + 140, x : x + 150]
    small = woven[y + down : y + down + side, x + down // 2 : x + down // 2 + side]
    assert (small == large[down : down + side, down // 2 : down // 2 + side]).all()


@settings(max_examples=4)
@given(st.integers(0, 2), st.sampled_from(list(ia.Mixing)))
def test_levelled_windows_are_crops(feather: int, mixing: ia.Mixing) -> None:
    """A finish reaches far beyond a window."""
    blend = ia.Blend(feather, mixing, (ia.Levelling(11),))
    woven = ia.weave(texture(80, 77, 4, 1), SMALL, 5, blend=blend)
    large = woven[-40:80, -30:100]
    assert (woven[10:31, 20:77] == large[50:71, 50:107]).all()


def test_windows_larger_than_a_cell_are_filled_by_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = small(3)[-50:70, -40:60]
    for module in ("intarsia.giant", "intarsia.giant.picture"):
        monkeypatch.setattr(f"{module}.SIDE", 16)
    assert (small(3)[-50:70, -40:60] == whole).all()
    assert (small(3).draw(Box(-50, -40, 70, 60)) == whole).all()


def test_planes_by_name_and_in_their_own_size() -> None:
    """A larger plane has windows in its own px; each window is one of the plane that `synthesize` draws."""
    colour = texture(80, 77, 3, 1)
    planes = {"height": as_depth(texture(160, 154, 1, 2), "uint16")[:, :, 0], "normal": texture(80, 77, 3, 3)}
    woven = small(4, **planes)
    made = ia.synthesize({"albedo": colour} | planes, (120, 110), SMALL, seed=5, blend=ia.Blend(4))
    assert woven.planes == ("albedo", "height", "normal")
    tall = woven.plane("height")
    assert (tall.dtype, tall.channels, tall.scale) == (np.uint16, 1, (2, 1))
    whole = np.asarray(made.render("height"))
    assert (tall[21:170, 33:150] == whole[21:170, 33:150]).all()
    assert (woven.plane("normal")[20:80, 20:70] == np.asarray(made.render("normal"))[20:80, 20:70]).all()
    with pytest.raises(ParameterError, match="plane=rust is unknown; choose one of albedo, height, normal"):
        woven.plane("rust")


def test_a_smaller_plane_is_averaged_in_its_own_windows() -> None:
    woven = ia.weave({"albedo": texture(80, 76, 3, 1), "rough": texture(40, 38, 1, 2)[:, :, 0]}, SMALL, 5)
    rough = woven.plane("rough")
    assert rough.scale == (1, 2)
    assert (rough[-9:23, 5:40][9:20, 3:30] == rough[0:11, 8:35]).all()
    whole = rough[-9:40, 5:60]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("intarsia.giant.picture.SIDE", 16)
        assert (rough.draw(Box(-9, 5, 40, 60)) == whole).all()


@pytest.mark.parametrize("key", [
    slice(0, 4), (slice(0, 4), 3), 7, (slice(None), slice(0, 4)), (slice(0, 4, 2), slice(0, 4)), (slice(0, 4),) * 3,
    (slice(0, 4), slice(4, 4)), (slice(5, 4), slice(0, 4)), (slice(0.5, 4), slice(0, 4)), ("ab", "cd"), None,
])  # fmt: skip
def test_what_is_no_window_is_refused(key: Any) -> None:
    with pytest.raises(ParameterError, match=re.escape("give rows and columns as texture[y0:y1, x0:x1], whole num")):
        small()[key]


def test_windows_too_far_away_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"lie too far away; stay within 2\*\*40 px"):
        small()[2**40 : 2**40 + 1, 0:4]


def test_a_slice_larger_than_memory_says_how_to_stream() -> None:
    with pytest.raises(ResourceError) as caught:
        small()[0 : 2**24, -(2**24) : 2**24]
    assert "stream it with texture.to_zarr(" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_methods_without_windows_are_refused() -> None:
    with pytest.raises(ParameterError, match="image-quilting cannot make windows of an endless plane; choose one of"):
        ia.weave(texture(40, 40), "image-quilting")
    with pytest.raises(ParameterError, match="near-regular grows from one exemplar"):
        ia.weave([texture(40, 40), texture(40, 40)], SMALL)


def test_auto_chooses_among_methods_that_make_windows() -> None:
    woven = ia.weave("sample:tiles")
    assert woven.method.slug == "near-regular"
    assert woven[0:3, 0:3].shape == (3, 3, 3)


@pytest.fixture
def cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small cells, so that a small picture has several."""
    for module in (zarrays, exports):
        monkeypatch.setattr(module, "SIDE", 64)
    monkeypatch.setattr(exports, "AREA", 64 * 64)


@pytest.mark.usefixtures("cut")
@pytest.mark.parametrize(("dtype", "channels"), [("uint8", 2), ("uint8", 4), ("uint8", 7), ("float32", 6)])
def test_stores_hold_the_window(dtype: str, channels: int, tmp_path: Path) -> None:
    """Every depth and number of channels, read by the libraries of others."""
    zarr, tifffile = needs("zarr"), needs("tifffile")
    woven = ia.weave(as_depth(texture(80, 77, channels, 1), dtype), SMALL, 5, blend=ia.Blend(2))
    window = woven[-20:103, 9:154]
    woven.to_zarr(tmp_path / "o.zarr", (123, 145), origin=(-20, 9), chunk=32)
    stored = zarr.open_array(tmp_path / "o.zarr", mode="r")
    assert (stored.dtype, stored.chunks[:2], stored.shards[:2]) == (window.dtype, (32, 32), (64, 64))
    assert (stored[:] == window).all()
    assert stored.attrs["intarsia"]["seed"] == 5
    woven.to_tiff(tmp_path / "o.tif", (123, 145), origin=(-20, 9), tile=32)
    with tifffile.TiffFile(tmp_path / "o.tif") as file:
        assert file.is_bigtiff
        assert file.pages[0].is_tiled
        assert (file.asarray() == window.squeeze()).all()
    read = read_plane(tmp_path / "o.tif")
    assert (read.samples == window).all()
    assert read.alpha == (channels in (2, 4))
    recipe = read_recipe(tmp_path / "o.tif")
    assert recipe is not None
    assert (recipe["origin"], recipe["size"]) == ([9, -20], [145, 123])


@settings(max_examples=6)
@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 5))
def test_the_size_of_the_pieces_changes_no_byte(
    tmp_path_factory: pytest.TempPathFactory, one: int, two: int, feather: int
) -> None:
    """However many tiles are drawn together, a TIFF has the same bytes; however it is cut, a zarr array the pixels."""
    zarr = needs("zarr")
    folder = tmp_path_factory.mktemp("pieces")
    woven, found = small(feather), []
    for n, together in enumerate((one, two)):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(exports, "AREA", together * 32 * 32)
            patch.setattr(zarrays, "SIDE", 32 * together)
            woven.to_tiff(folder / f"{n}.tif", (90, 170), tile=32)
            woven.to_zarr(folder / f"{n}.zarr", (90, 170), chunk=32 + 13 * n)
        found.append(((folder / f"{n}.tif").read_bytes(), zarr.open_array(folder / f"{n}.zarr", mode="r")[:].tobytes()))
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("how", "more", "message"),
    [
        ("tiff", {"shape": (0, 5)}, "shape=(0, 5) is not allowed"),
        ("tiff", {"shape": 2**33}, "a TIFF holds at most 4294967295 px a side; write a zarr array."),
        ("tiff", {"shape": 2**31}, "cells of 2048x512; at most 4194304"),
        ("tiff", {"tile": 40}, "tile=40 is not allowed; give 16 to 4096 px, a multiple of 16."),
        ("tiff", {"origin": 4}, "origin=4 is no pixel; give (y, x)."),
        ("tiff", {"origin": (0, 2**40)}, "lie too far away"),
        ("zarr", {"chunk": True}, "chunk=True is not allowed"),
    ],
)
def test_what_cannot_be_stored_is_refused_before_work(how: str, more: dict, message: str, tmp_path: Path) -> None:
    if how == "zarr":
        needs("zarr")
    with pytest.raises(ParameterError, match=re.escape(message)):
        getattr(small(), f"to_{how}")(tmp_path / "o", **({"shape": 64} | more))
    assert not list(tmp_path.iterdir())


def test_labels_and_truth_values_are_stored(tmp_path: Path) -> None:
    zarr = needs("zarr")
    names = (noise(80, 77, 3) % np.uint64(5)).astype(np.uint32)
    woven = ia.weave({"albedo": texture(80, 77, 3, 1), "ids": ia.Plane(names, "label")}, SMALL, 5)
    woven.plane("ids").to_zarr(tmp_path / "ids.zarr", 90)
    assert (zarr.open_array(tmp_path / "ids.zarr", mode="r")[:] == woven.plane("ids")[0:90, 0:90]).all()
    bits = ia.weave({"albedo": texture(80, 77, 3, 1), "on": ia.Plane(names > 2, "label")}, SMALL, 5).plane("on")
    bits.to_tiff(tmp_path / "on.tif", 90)
    assert (read_plane(tmp_path / "on.tif").pixels == 255 * bits[0:90, 0:90]).all()


@pytest.mark.parametrize("how", ["zarr", "tiff"])
@pytest.mark.usefixtures("cut")
def test_cancelling_leaves_nothing_half_written(how: str, tmp_path: Path) -> None:
    """Law 12: of an array what is done stays, and is not drawn again; of a file there is nothing."""
    if how == "zarr":
        needs("zarr")
    event, drawn = Event(), list[tuple[int, int]]()

    def step(done: int, total: int, draft: object) -> None:
        drawn.append((done, total))
        if done == 2:
            event.set()

    def woven(name: str, run: ia.Run) -> None:
        getattr(small(), f"to_{how}")(tmp_path / name, 150, **{"chunk" if how == "zarr" else "tile": 32}, run=run)

    with pytest.raises(ia.CancelledError):
        woven("o", ia.Run(1, step, event))
    assert [done for done, _ in drawn] == [0, 1, 2]
    assert [p.name for p in tmp_path.iterdir()] == (["o"] if how == "zarr" else [])
    drawn.clear()
    woven("o", ia.Run(1, step))
    assert drawn[0][0] == (2 if how == "zarr" else 0)
    assert drawn[-1] == (len(drawn) - 1 + drawn[0][0],) * 2
    woven("whole", ia.Run(1))
    assert files_below(tmp_path / "o") == files_below(tmp_path / "whole")
