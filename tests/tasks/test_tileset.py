"""Tile sets: legal tiles meet inside one strip, all is copied, insides differ, and what cannot be is refused."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli.commands import full_disk, run, told
from numpy.typing import NDArray

import intarsia as ia
from intarsia import files
from intarsia.foundation import InputError, MethodError, ParameterError
from intarsia.foundation.geometry import Wrap
from intarsia.lattice import lattices_of, misfit
from intarsia.tasks.tileset import closes, corners_of, planned
from intarsia.testing.cases import as_depth, looked_up, texture

ONE = ia.Run(1)
Pixels = NDArray[Any]


@cache
def made(tiles: int = 16) -> ia.TileSet:
    return ia.tileset(texture(72, 80, 3, 5), tiles, size=(44, 52) if tiles == 16 else 40, seed=3, run=ONE)


def parts(tiles: ia.TileSet, picture: Pixels) -> list[Pixels]:
    """The tiles, cut out of an atlas of pixels or places one by one."""
    n, h, w = tiles.rule.side, tiles.rule.height, tiles.rule.width
    return [picture[y * h : (y + 1) * h, x * w : (x + 1) * w] for y in range(n) for x in range(n)]


Edge = tuple[str, int, int]


def edges(tiles: ia.TileSet) -> Iterator[tuple[Edge, bool, Pixels]]:
    """Of every tile its four edges, whether it lies before them, and the places shown there, as deep as is kept.

    An edge is a direction and the colours at its ends. Those that run down are transposed.
    """
    k = tiles.kept
    for (a, b, c, d), own in zip(tiles.rule.order.tolist(), parts(tiles, tiles.atlas.map.yx), strict=True):
        yield ("across", a, b), False, own[:k]
        yield ("across", c, d), True, own[-k:]
        yield ("down", a, c), False, own[:, :k].swapaxes(0, 1)
        yield ("down", b, d), True, own[:, -k:].swapaxes(0, 1)


ALL = pytest.mark.parametrize("tiles", [16, 81])


@ALL
def test_all_tiles_of_an_edge_show_one_strip(tiles: int) -> None:
    """So any two that may meet show, on both sides of the joint, what was grown as one."""
    found: dict[tuple[Edge, bool], list[Pixels]] = {}
    for edge, before, shown in edges(made(tiles)):
        found.setdefault((edge, before), []).append(shown)
    colours = made(tiles).rule.colours
    assert made(tiles).kept >= 2
    assert len(found) == 4 * colours**2
    for same in found.values():
        assert len(same) == colours**2
        assert all((one == same[0]).all() for one in same)


@ALL
def test_corners_of_a_colour_show_one_square_in_every_direction(tiles: int) -> None:
    rule, places = made(tiles).rule, made(tiles).atlas.map.yx
    plan = planned(made(tiles).atlas.exemplars[0], tiles, (rule.height, rule.width), ONE)
    squares, reach, k = corners_of(plan, 3), range(-plan.strip, plan.strip), plan.kept
    for (row, column), colour in np.ndenumerate(rule.corners):
        for y, x in product(reach, repeat=2):
            if -k <= y < k or -k <= x < k:
                seen = places[(row * rule.height + y) % len(places), (column * rule.width + x) % places.shape[1]]
                assert (seen == squares[colour][plan.corner + y, plan.corner + x]).all()


def steps(places: Pixels) -> NDArray[np.bool_]:
    """Where a row of places is not continued by the next one."""
    return np.asarray((np.diff(places, axis=0) != (1, 0)).any(axis=2))


@ALL
def test_at_joints_places_go_on_as_often_as_inside(tiles: int) -> None:
    """Of every legal pair, along both axes. A strip that is shifted or exchanged goes on nowhere."""
    sides: dict[Edge, dict[bool, Pixels]] = {}
    for edge, before, shown in edges(made(tiles)):
        sides.setdefault(edge, {})[before] = shown
    for (way, *_), both in sides.items():
        strip = np.concatenate([both[True], both[False]])
        if way == "down":
            strip = strip[..., ::-1]
        cuts = steps(strip).mean(axis=1)
        joint = made(tiles).kept - 1
        assert cuts[joint] <= 0.15
        assert cuts[joint] <= cuts.max()


@ALL
def test_pixels_step_no_more_across_joints_than_along_lines_inside(tiles: int) -> None:
    pixels = made(tiles).render().pixels.astype(int)
    own = parts(made(tiles), pixels)
    inner = [abs(np.diff(p, axis=0)).mean(axis=(1, 2)) for p in own]
    legal, order = list[float](), made(tiles).rule.order
    for above, below in np.argwhere((order[:, None, 2:] == order[None, :, :2]).all(axis=2)):
        legal.append(abs(own[above][-1] - own[below][0]).mean())
    assert len(legal) == made(tiles).rule.colours ** 6
    assert max(legal) <= np.max(inner)
    assert np.mean(legal) <= 1.15 * np.mean(inner)


@ALL
def test_insides_differ(tiles: int) -> None:
    k = made(tiles).kept
    inner = [p[k:-k, k:-k] for p in parts(made(tiles), made(tiles).render().pixels)]
    assert all((one != other).mean() > 0.1 for one, other in combinations(inner, 2))


@ALL
def test_every_pixel_is_that_of_the_exemplar(tiles: int) -> None:
    atlas = made(tiles).atlas
    assert atlas.map.wrap is Wrap.BOTH
    assert not atlas.map.holes.any()
    assert made(tiles).render().pixels.tobytes() == looked_up(atlas.exemplars, atlas.map).tobytes()


def test_a_field_is_laid_tile_by_tile() -> None:
    field = made().rule.field(3, 5, seed=9)
    cut = parts(made(), made().render().pixels)
    naive = np.concatenate([np.concatenate([cut[n] for n in row], axis=1) for row in field.tolist()])
    shown = made().laid(field)
    assert (shown.pixels == naive).all()
    assert shown.kind is made().render().kind


def test_the_same_bytes_on_any_number_of_threads_and_others_for_another_seed() -> None:
    pixels = texture(72, 80, 3, 5)
    again, other = (ia.tileset(pixels, size=(44, 52), seed=s, run=ia.Run(2)) for s in (3, 4))
    assert again.atlas.map.digest == made().atlas.map.digest
    assert other.atlas.map.digest != made().atlas.map.digest
    assert again.atlas.recipe["tileset"] == {"tiles": 16, "size": [52, 44], "seed": 3}


def test_all_planes_follow_one_map() -> None:
    colour, height = texture(64, 64, 3, 5), as_depth(texture(64, 64, 1, 6), "uint16")
    small = texture(32, 32, 1, 7)
    tiles = ia.tileset({"albedo": colour, "height": height, "roughness": small}, size=40, run=ONE)
    yx = tiles.atlas.map.yx
    shown = tiles.render("height").pixels
    assert shown.dtype == np.uint16
    assert (shown.reshape(yx.shape[:2]) == height.reshape(64, 64)[yx[..., 0], yx[..., 1]]).all()
    assert tiles.render("roughness").shape == (80, 80)
    field = tiles.rule.field(2, 3)
    assert tiles.laid(field, "roughness").shape == (40, 60)
    first = tiles.render("roughness").samples[:20, :20]
    assert (tiles.laid(np.zeros((2, 2), int), "roughness").samples == np.tile(first, (2, 2, 1))).all()
    with pytest.raises(ParameterError, match="smaller plane; give multiples of 2"):
        ia.tileset({"albedo": colour, "roughness": small}, size=41)


def test_nothing_masked_is_shown() -> None:
    usable = np.ones((72, 80), bool)
    usable[:, 60:] = usable[50:60] = False
    tiles = ia.tileset(ia.Exemplar.of(texture(72, 80, 3, 5), usable=usable), size=40, run=ONE)
    yx = tiles.atlas.map.yx
    assert usable[yx[..., 0], yx[..., 1]].all()
    sparse = np.zeros((72, 80), bool)
    sparse[::2] = True
    with pytest.raises(MethodError, match="free of masked pixels"):
        ia.tileset(ia.Exemplar.of(texture(72, 80, 3, 5), usable=sparse), size=40)


class TestLattice:
    """Tiles of what repeats hold whole periods, and all corners are in step."""

    exemplar = ia.read("sample:tiles")

    def test_the_default_size_holds_whole_periods(self) -> None:
        run_, lattice = ia.Run(1), lattices_of(self.exemplar).accepted
        assert lattice is not None
        plan = planned(self.exemplar, 16, None, run_)
        assert plan.lattice == lattice
        assert all(misfit(lattice.vectors, n, axis) < 1 for axis, n in enumerate(plan.size))
        assert not run_.notes

    @pytest.mark.parametrize("seed", range(4))
    def test_corners_are_whole_steps_apart(self, seed: int) -> None:
        plan = planned(self.exemplar, 81, None, ONE)
        assert plan.lattice is not None
        a, *others = (square[0, 0] for square in corners_of(plan, seed))
        for b in others:
            steps = np.linalg.solve(np.array(plan.lattice.vectors).T / 256, b - a)
            assert abs(steps - np.rint(steps)).max() * np.abs(plan.lattice.vectors).max() / 256 < 1
        assert (a != others[0]).any()

    def test_it_closes_around_the_whole_atlas(self) -> None:
        found = lattices_of(self.exemplar).ranked[0]
        lattice = replace(found, vectors=((2560, 0), (0, 2560)))
        assert closes(lattice, (101, 100), 2)  # 4 px in four tiles, of a period of 10 px
        assert not closes(lattice, (101, 100), 3)
        assert not closes(lattice, (100, 98), 2)

    def test_a_size_that_holds_no_whole_periods_is_told(self) -> None:
        run_ = ia.Run(1)
        plan = planned(self.exemplar, 16, (150, 150), run_)
        assert plan.lattice is None
        assert "no whole courses fill tiles of 150x150 px" in run_.notes[0]  # its rows are lines, too


def test_corners_of_courses_are_on_one_course_and_tiles_hold_whole_ones() -> None:
    y = np.arange(200)
    line = 60 * ((y % 97 < 3) | (y % 97 > 37) & (y % 97 < 41))  # courses of 38 and 59 px
    wall = np.clip(160 + texture(200, 220, 1, 8).reshape(200, 220) // 8 - 2 * line[:, None], 0, 255).astype(np.uint8)
    run_ = ia.Run(1)
    plan = planned(ia.Exemplar.of(wall), 16, None, run_)
    lines = plan.facts.courses
    assert plan.lattice is None
    assert lines is not None
    ends = [0, *np.cumsum(lines.heights)]
    assert plan.size[0] in {b - a for a in ends for b in ends}
    first, second = (square[0, 0] for square in corners_of(plan, 1))
    assert first[0] == second[0]
    assert not run_.notes  # its slanted lattice is left aside
    planned(plan.facts.exemplar, 16, (plan.size[0] + 7, 100), run_)
    assert "no whole courses fill tiles of 100x" in run_.notes[0]
    assert first[1] != second[1]


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"tiles": 17}, "tiles=17 is not allowed; give 16 or 81"),
    ({"tiles": [16]}, "give 16 or 81"),
    ({"size": 15}, "size=15x15 is not allowed for a tile: give 16 px a side at least"),
    ({"size": (64, 300)}, "size=300x64 is not allowed for a tile: exemplar 1 .72x70 px. is too small for it; give 4"),
    ({"size": 1821, "tiles": 81}, "give at most 1820 px, so that 81 tiles fit"),
    ({"seed": -1}, "seed"),
]


@pytest.mark.parametrize(("asked", "line"), REFUSED)
def test_wrong_arguments_are_refused(asked: dict[str, Any], line: str) -> None:
    with pytest.raises(ParameterError, match=line) as refused:
        ia.tileset(texture(70, 72, 3, 5), **asked)
    assert "\n" not in str(refused.value)


def test_small_exemplars_are_refused() -> None:
    with pytest.raises(InputError, match=r"exemplar 1 \(40x15 px\) is too small for tiles; give 16 px a side"):
        ia.tileset(texture(15, 40, 3, 5))
    tiny = ia.tileset(texture(16, 17, 3, 5), size=16, run=ONE)
    assert tiny.render().shape == (64, 64)
    assert tiny.kept == 1


class TestCommand:
    @pytest.fixture(autouse=True)
    def _in_a_folder(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        files.write("stone_albedo.png", ia.Plane(texture(72, 80, 3, 5)))
        files.write("stone_height.png", ia.Plane(texture(72, 80, 1, 6), ia.Kind.DATA))

    def test_all_is_written_and_says_the_same(self) -> None:
        words = "tileset stone_albedo.png stone_height.png -o out --size 52x44 --seed 3"
        answer = told(words)
        names = ["", "_field", "_height"]
        assert answer["told"] == ["16 tiles of 52x44 px, seed 3"]
        assert [Path(p).name for p in answer["files"]] == sorted(
            [f"stone_tiles{n}.png" for n in names] + [f"stone_tiles.{e}" for e in ("json", "tres", "glsl")]
        )
        assert sorted(p.name for p in Path("out").iterdir()) == [Path(p).name for p in answer["files"]]
        said = json.loads(Path("out/stone_tiles.json").read_text("utf-8"))
        assert said["pictures"] == {"albedo": "stone_tiles.png", "height": "stone_tiles_height.png"}
        assert (said["seed"], said["size"], said["tiles"]) == (3, [52, 44], 16)
        assert said["exemplars"][0]["size"] == [80, 72]
        tiles = ia.tileset(ia.read("stone_albedo.png", height="stone_height.png"), size=(44, 52), seed=3, run=ONE)
        for name, file in said["pictures"].items():
            assert (files.read_plane(Path("out", file)).samples == tiles.render(name).samples).all()
        seen = files.read_plane("out/stone_tiles_field.png").samples
        assert (seen == tiles.laid(tiles.rule.field(16, 16)).samples).all()
        assert 'path="stone_tiles.png"' in Path("out/stone_tiles.tres").read_text("utf-8")
        assert "The tiles of stone_tiles.png" in Path("out/stone_tiles.glsl").read_text("utf-8")
        before = Path("out/stone_tiles.png").read_bytes()
        run(f"{words} --threads 2 --force")
        assert Path("out/stone_tiles.png").read_bytes() == before

    @pytest.mark.parametrize("taken", ["json", "tres", "glsl", "png"])
    def test_files_that_exist_are_kept_without_force(self, taken: str, monkeypatch: pytest.MonkeyPatch) -> None:
        """And nothing is grown before that is seen."""
        monkeypatch.setattr("intarsia.tasks.tileset.grown", None)
        Path("out").mkdir()
        Path(f"out/stone_albedo_tiles.{taken}").write_bytes(b"mine")
        error = run("tileset stone_albedo.png -o out --size 40", code=2).stderr
        assert f"stone_albedo_tiles.{taken}" in error
        assert "--force" in error
        assert error.count("\n") == 1
        assert [p.read_bytes() for p in Path("out").iterdir()] == [b"mine"]

    @pytest.mark.parametrize(
        ("words", "line"),
        [
            ("-o out --tiles 20", "'20' is not one of '16', '81'"),
            ("-o out --size 12", "size=12x12 is not allowed for a tile"),
            ("-o out --size 400", "is too small for it; give 4 times that at most"),
            ("-o -", "a set does not fit into a pipe"),
        ],
    )
    def test_what_cannot_be_is_refused_in_one_line(self, words: str, line: str) -> None:
        error = run(f"tileset stone_albedo.png {words}", code=2).stderr
        assert line in error
        assert error.count("\n") == 1
        assert sorted(p.name for p in Path().iterdir()) == ["stone_albedo.png", "stone_height.png"]

    def test_a_file_or_a_full_disk_in_place_of_the_folder_leaves_nothing(self) -> None:
        assert run("tileset stone_albedo.png -o stone_albedo.png", code=3).stderr.count("\n") == 1
        with full_disk(4000):
            assert "there is no room" in run("tileset stone_albedo.png -o out --size 40", code=1).stderr
        assert sorted(p.name for p in Path().iterdir()) == ["stone_albedo.png", "stone_height.png"]

    def test_a_note_on_the_lattice_is_a_warning(self) -> None:
        answer = told("tileset sample:tiles -o out --size 90 --crop 0,0,144,144")
        assert "no whole periods fill tiles of 90x90 px" in answer["warnings"][0]
