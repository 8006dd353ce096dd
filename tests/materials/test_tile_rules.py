"""The rule of tiles by corners: every tile once, legal neighbours in the atlas, and one choice in four languages."""

from __future__ import annotations

import itertools
import json
import re
from typing import Any

import numpy as np
import pytest

from intarsia.materials.tile_rules import SIDES, TileRule, colour_at, cycle

BOTH = pytest.mark.parametrize("colours", [2, 3])
MASK = 0xFFFFFFFF


def chosen(said: dict[str, Any], x: int, y: int, seed: int) -> int:
    """The number of the tile of a place, by the words of the JSON and nothing else."""

    def colour(x: int, y: int) -> int:
        h = (x * said["factors"][0] + y * said["factors"][1] + seed * said["factors"][2]) & MASK
        for shift, factor in said["steps"]:
            h = ((h ^ h >> shift) * factor) & MASK
        h ^= h >> 16
        return (h >> 16) * int(said["colours"]) >> 16

    corners = [colour(x, y), colour(x + 1, y), colour(x, y + 1), colour(x + 1, y + 1)]
    number: int = said["corners"].index(corners)
    return number


def as_read(rule: TileRule) -> dict[str, Any]:
    said: dict[str, Any] = json.loads(rule.as_json({"albedo": "a.png"}, {"seed": 4}, 8))
    return said


@BOTH
def test_every_pair_follows_each_other_once(colours: int) -> None:
    line = cycle(colours)
    assert sorted(zip(line, line[1:] + line[:1], strict=True)) == [*itertools.product(range(colours), repeat=2)]


@BOTH
def test_every_tile_is_in_the_atlas_once_and_meets_legal_neighbours_there(colours: int) -> None:
    rule = TileRule(colours, 40, 50)
    n = rule.side
    assert sorted(map(tuple, rule.order.tolist())) == [*itertools.product(range(colours), repeat=4)]
    at = rule.order.reshape(n, n, 4)
    for y, x in np.ndindex(n, n):
        assert (at[y, x, [1, 3]] == at[y, (x + 1) % n, [0, 2]]).all()
        assert (at[y, x, [2, 3]] == at[(y + 1) % n, x, [0, 1]]).all()
    for number, own in enumerate(rule.order.tolist()):
        assert rule.tiles[tuple(own)] == number


@BOTH
@pytest.mark.parametrize("seed", [0, 7, MASK])
def test_a_field_is_what_the_json_says(colours: int, seed: int) -> None:
    rule = TileRule(colours, 40, 50)
    said = as_read(rule)
    assert said["tiles"] == colours**4
    assert (said["size"], said["atlas"], said["pictures"]) == ([50, 40], [rule.side] * 2, {"albedo": "a.png"})
    assert (said["seed"], said["alike_px"]) == (4, 8)
    field = rule.field(9, 12, seed)
    assert field.tolist() == [[chosen(said, x, y, seed) for x in range(12)] for y in range(9)]
    y0, x0 = -(2**31), 2**31 - 5
    part = rule.field(3, 4, seed, (y0, x0))
    assert part.tolist() == [[chosen(said, x0 + x, y0 + y, seed) for x in range(4)] for y in range(3)]


@BOTH
def test_all_colours_are_about_equally_frequent_and_seeds_differ(colours: int) -> None:
    y, x = np.ogrid[-100:100, -100:100]
    found = colour_at(y, x, colours)
    share = np.bincount(found.ravel(), minlength=colours) / found.size
    assert len(share) == colours
    assert abs(share - 1 / colours).max() < 0.02
    assert (found != colour_at(y, x, colours, 1)).mean() > 0.4
    for axis in (0, 1):  # no stripes: neighbours are equal as often as by chance
        assert abs((found == np.roll(found, 1, axis)).mean() - 1 / colours) < 0.02


@BOTH
def test_godot_gets_every_tile_with_its_corners(colours: int) -> None:
    rule = TileRule(colours, 40, 50)
    text = rule.godot('my "tiles".png')
    assert text.startswith('[gd_resource type="TileSet" load_steps=3 format=3]\n')
    assert 'path="my \\"tiles\\".png"' in text
    assert "texture_region_size = Vector2i(50, 40)" in text
    assert "\ntile_size = Vector2i(50, 40)\nterrain_set_0/mode = 1\n" in text
    assert len(re.findall(r"terrain_set_0/terrain_\d/name", text)) == colours
    for number, own in enumerate(rule.order.tolist()):
        place = f"{number % rule.side}:{number // rule.side}/0"
        assert f"\n{place} = 0\n{place}/terrain_set = 0\n" in text
        (terrain,) = re.findall(rf"^{place}/terrain = (\d)$", text, re.MULTILINE)
        assert own.count(int(terrain)) == max(map(own.count, own))
        for side, colour in zip(SIDES, own, strict=True):
            assert f"\n{place}/terrains_peering_bit/{side} = {colour}\n" in text


def integers(text: str, pattern: str) -> list[int]:
    return [int(n) for n in re.findall(pattern, text)]


@BOTH
def test_the_function_in_glsl_takes_the_same_tile(colours: int) -> None:
    """Its numbers, put into its own steps, name the tiles of the field."""
    rule = TileRule(colours, 40, 50)
    text, said = rule.glsl("a_tiles.png"), as_read(rule)
    listed = re.search(r"INTARSIA_TILES\[(\d+)\] = int\[\1\]\((.*)\);", text)
    assert listed is not None
    tiles = [int(n) for n in listed[2].split(",")]
    assert int(listed[1]) == len(tiles) == colours**4
    assert integers(text, r"uint\(at\.x\) \* (\d+)u \+ uint") == [said["factors"][0]]
    assert integers(text, r"uint\(at\.y\) \* (\d+)u") == [said["factors"][1]]
    assert integers(text, r"seed \* (\d+)u") == [said["factors"][2]]
    assert re.findall(r"h = \(h \^ \(h >> (\d+)\)\) \* (\d+)u", text) == [(f"{s}", f"{f}") for s, f in said["steps"]]
    assert integers(text, r">> 16\) \* (\d+)u >> 16") == [colours]
    assert f"tile % {rule.side}, tile / {rule.side}" in text
    y, x = np.ogrid[:6, :7]
    c = colour_at(y, x, colours).tolist()
    for row, column in np.ndindex(5, 6):
        upper, lower = (c[r][column] * colours + c[r][column + 1] for r in (row, row + 1))
        assert tiles[upper * colours**2 + lower] == rule.field(5, 6)[row, column]
