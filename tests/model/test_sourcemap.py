"""The map: what it holds, how it is cut, saved, counted; and that a damaged one is refused."""

from __future__ import annotations

import json
from dataclasses import FrozenInstanceError, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import intarsia as ia
from intarsia.foundation.blend import Blend, Mixing
from intarsia.foundation.geometry import Box, Wrap
from intarsia.model import Exemplar
from intarsia.model.sourcemap import HOLE, Source, SourceMap, identity
from intarsia.testing import noise, texture

SOURCES = (Source("a", 9, 11, "0" * 64), Source("b", 5, 30, "1" * 64))


def random_map(height: int, width: int, seed: int = 0, wrap: str = "none", pose: bool = True) -> SourceMap:
    """A map without any order, with some holes."""
    bits = noise(height, width, seed).astype(np.int64) & 0xFFFFFF
    which = (bits % 2).astype(np.uint8)
    yx = np.stack([bits // 2 % np.array([9, 5])[which], bits // 64 % np.array([11, 30])[which]], axis=2)
    holes = bits // 4096 % 7 == 0
    yx[holes] = 0
    poses = np.where(holes, 0, bits // 512 % 8).astype(np.uint8) if pose else None
    return SourceMap(yx, np.where(holes, HOLE, which), poses, SOURCES, Wrap(wrap), Blend(3, Mixing.SOURCE))


@given(st.integers(1, 20), st.integers(1, 20), st.integers(0, 99), st.booleans(), st.sampled_from(list(Wrap)))
def test_saving_and_loading_gives_the_same_map(height: int, width: int, seed: int, pose: bool, wrap: Wrap) -> None:
    """All arrays, sources, wrap and blend; equal maps give equal bytes."""
    smap = random_map(height, width, seed, wrap.value, pose)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "map.npz"
        path.write_bytes(smap.to_bytes())
        again = SourceMap.load(path)
    assert again.to_bytes() == smap.to_bytes()
    assert (again.sources, again.wrap, again.blend) == (smap.sources, smap.wrap, smap.blend)
    assert again.digest == smap.digest
    assert (again.pose is None) == (not pose)


def test_a_saved_map_is_a_plain_npz_and_a_missing_one_is_named(tmp_path: Path) -> None:
    """The arrays stand under their names; no pickle."""
    random_map(7, 5).save(tmp_path / "map.npz")
    with np.load(tmp_path / "map.npz", allow_pickle=False) as data:
        assert set(data) == {"yx", "which", "pose", "about"}
        assert data["yx"].shape == (7, 5, 2)
        assert json.loads(bytes(data["about"]))["wrap"] == "none"
    with pytest.raises(ia.InputError, match=r"gone\.npz does not exist"):
        SourceMap.load(tmp_path / "gone.npz")


@pytest.mark.parametrize("change", ["row", "column", "negative", "exemplar", "pose"])
def test_a_map_that_points_outside_is_found(change: str) -> None:
    smap = random_map(8, 8)
    smap.check_sources()
    yx, which, pose = np.array(smap.yx), np.array(smap.which), np.array(smap.pose)
    which[3, 3], yx[3, 3], pose[3, 3] = 0, (0, 0), 0
    if change == "pose":
        pose[3, 3] = 8
    elif change == "exemplar":
        which[3, 3] = 2
    else:
        yx[3, 3] = {"row": (9, 0), "column": (0, 11), "negative": (-1, 0)}[change]
    with pytest.raises(ia.InputError, match="damaged") as caught:
        replace(smap, yx=yx, which=which, pose=pose).check_sources()
    assert "\n" not in str(caught.value)


def test_maps_cannot_be_changed_and_their_shapes_must_agree() -> None:
    smap = random_map(4, 4)
    with pytest.raises(FrozenInstanceError):
        smap.wrap = Wrap.BOTH
    for array in (smap.yx, smap.which, smap.pose):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 0
    with pytest.raises(ia.InputError, match="is no map"):
        SourceMap(np.zeros((4, 4)))
    with pytest.raises(ia.InputError, match="does not fit"):
        SourceMap(np.zeros((4, 4, 2)), which=np.zeros((4, 5)))


def test_windows_are_crops_and_go_round_where_the_map_does() -> None:
    """Law 5: negative and far coordinates along wrapped axes; outside them a window is refused."""
    smap = random_map(9, 7, wrap="x")
    part = smap.window(Box(2, -10, 8, 25))
    columns = np.arange(-10, 25) % 7
    np.testing.assert_array_equal(part.yx, smap.yx[2:8][:, columns])
    np.testing.assert_array_equal(part.which, smap.which[2:8][:, columns])
    np.testing.assert_array_equal(part.pose, smap.pose[2:8][:, columns])
    assert part.wrap is Wrap.NONE
    far = smap.window(Box(0, 7 * 2**40 - 2, 9, 7 * 2**40 + 5))
    np.testing.assert_array_equal(far.yx, smap.yx[:, np.arange(-2, 5) % 7])
    for box in (Box(-1, 0, 3, 3), Box(0, 0, 10, 3), Box(3, 0, 3, 3), Box(0, 4, 2, 2)):
        with pytest.raises(ia.ParameterError, match="window") as caught:
            smap.window(box)
        assert "\n" not in str(caught.value)


def test_the_digest_sees_every_pixel_and_the_wrap() -> None:
    smap = random_map(6, 6)
    yx, which = np.array(smap.yx), np.array(smap.which)
    yx[5, 5, 1] ^= 1
    which[0, 0] ^= 1
    others = [replace(smap, yx=yx), replace(smap, which=which), replace(smap, pose=None), replace(smap, wrap=Wrap.X)]
    assert len({m.digest for m in (smap, *others)}) == 5


def test_what_is_left_out_means_zero() -> None:
    """Exemplar 0 everywhere, upright everywhere."""
    yx = np.zeros((3, 4, 2), np.int32)
    plain, said = SourceMap(yx), SourceMap(yx, np.zeros((3, 4)), np.zeros((3, 4)))
    assert plain.digest == said.digest
    assert plain.poses == said.poses == (0,)
    assert not plain.holes.any()


def test_the_identity_shows_the_exemplar() -> None:
    one, two = Exemplar.of(texture(5, 6, 3)), Exemplar.of(texture(7, 4, 3))
    smap = identity((one.source, two.source), 1)
    assert (smap.height, smap.width) == (7, 4)
    assert (smap.which == 1).all()
    np.testing.assert_array_equal(smap.yx, np.stack(np.mgrid[:7, :4], axis=2))
    assert [int(u.sum()) for u in smap.usage()] == [0, 28]


def test_usage_counts_every_shown_pixel() -> None:
    """The counts of all exemplars add up to the pixels that are no holes."""
    smap = random_map(30, 20)
    counts = smap.usage()
    assert [c.shape for c in counts] == [(9, 11), (5, 30)]
    assert sum(int(c.sum()) for c in counts) == int((~smap.holes).sum())
    y, x = smap.yx[smap.which == 1].T
    expected = np.zeros((5, 30), int)
    np.add.at(expected, (y, x), 1)
    np.testing.assert_array_equal(counts[1], expected)


def test_an_st_map_points_at_pixel_centres_with_t_upward() -> None:
    e = Exemplar.of(texture(4, 8, 3))
    st_map = identity((e.source,), 0).st_map()
    assert st_map.dtype == np.float32
    np.testing.assert_allclose(st_map[0, 0], (0.5 / 8, 1 - 0.5 / 4))
    np.testing.assert_allclose(st_map[3, 7], (7.5 / 8, 0.5 / 4))
    with pytest.raises(ia.ParameterError, match="one exemplar"):
        random_map(3, 3).st_map()


def test_pieces_are_connected_runs_of_one_copy() -> None:
    """Neighbours that continue one another are one piece; a map of the identity is a single one."""
    e = Exemplar.of(texture(20, 20))
    assert len(np.unique(identity((e.source,), 0).pieces())) == 1
    tiles = ia.synthesize(e, (20, 30), ia.RandomTiling(patch=10), seed=5).map
    pieces = tiles.pieces()
    assert len(np.unique(pieces)) == 6
    assert (pieces[:10, :10] == pieces[0, 0]).all()


def test_a_blend_is_checked() -> None:
    assert Blend(5).mixing is Mixing.MEAN
    for feather in (-1, 1025, True):
        with pytest.raises(ia.ParameterError, match="feather="):
            Blend(feather)
