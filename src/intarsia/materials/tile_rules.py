"""Wang tiles by corners: where a tile lies in the atlas, which one a place of a field gets, and files that say so.

The colour of a corner of the field is a hash of its coordinates, so a field has no end and is stored nowhere. The four
corners of a place name its tile.

The tiles lie in the atlas so that neighbours there, too, share corners, around its borders as well: a de Bruijn torus,
by the construction of Cock, "Toroidal tilings from de Bruijn-Good cyclic sequences", Discrete Mathematics 70, 1988. So
filters that reach over the border of a tile read what may lie beside it in a field.

Hash: the last steps of MurmurHash3 (Appleby, public domain) on a sum of multiples. Format of Godot: the classes TileSet
and TileSetAtlasSource of its manual, version 4.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..foundation.arrays import Array, Pair
from ..version import VERSION

FACTORS = 0x9E3779B1, 0x6A09E667, 0xBB67AE85
"""Of column, row and seed: the first 32 bits of the golden ratio and of the roots of 2 and 3, made odd."""

STEPS = (16, 0x85EBCA6B), (13, 0xC2B2AE35)
"""Of the hash h, in turn: h = (h ^ h >> shift) * factor; last h ^ h >> 16, of which the upper 16 bits count."""

# The square of two colours in which every 2 x 2 part is another one; by the construction there is none for even numbers
PAIRED = [1, 0, 1, 1], [1, 0, 0, 0], [0, 0, 0, 1], [1, 1, 0, 1]

SIDES = "top_left_corner", "top_right_corner", "bottom_left_corner", "bottom_right_corner"
"""The corners of a tile in Godot, in the order of the rule."""

GLSL = """\
// The tiles of {name}, by intarsia {version}: for GLSL 1.30 and ES 3.00, or later.
// The first row of {name} lies at v = 0, and it repeats along both axes. `cells` counts tiles to the right and down.
// Where tiles meet `cells` goes on and the returned place jumps, so give the gradients of `cells`:
//     textureGrad(atlas, intarsia_tile(cells, 0u), dFdx(cells) / {side}.0, dFdy(cells) / {side}.0)
const int INTARSIA_TILES[{count}] = int[{count}]({tiles});

int intarsia_corner(ivec2 at, uint seed) {{
    uint h = uint(at.x) * {factors[0]}u + uint(at.y) * {factors[1]}u + seed * {factors[2]}u;
    h = (h ^ (h >> {steps[0][0]})) * {steps[0][1]}u;
    h = (h ^ (h >> {steps[1][0]})) * {steps[1][1]}u;
    return int(((h ^ (h >> 16)) >> 16) * {colours}u >> 16);
}}

vec2 intarsia_tile(vec2 cells, uint seed) {{
    ivec2 at = ivec2(floor(cells));
    int upper = intarsia_corner(at, seed) * {colours} + intarsia_corner(at + ivec2(1, 0), seed);
    int lower = intarsia_corner(at + ivec2(0, 1), seed) * {colours} + intarsia_corner(at + ivec2(1, 1), seed);
    int tile = INTARSIA_TILES[upper * {pairs} + lower];
    return (vec2(tile % {side}, tile / {side}) + fract(cells)) / {side}.0;
}}
"""


@dataclass(frozen=True)
class TileRule:
    """The rule of a set of tiles.

    Parameters
    ----------
    colours : int
        Colours of corners K, 2 or 3; there are K**4 tiles.
    height, width : int
        Size of a tile, px.
    """

    colours: int
    height: int
    width: int

    @property
    def side(self) -> int:
        """Tiles along a side of the atlas, K**2."""
        return self.colours**2

    @cached_property
    def corners(self) -> Array:
        """The colours of the upper left corners of the tiles in the atlas, (K**2, K**2); further ones repeat them."""
        if self.colours == 2:
            return np.array(PAIRED)
        line, n = np.array(cycle(self.colours)), np.arange(self.side)
        return np.asarray(line[(n[:, None] + n * (n - 1) // 2) % self.side])

    @cached_property
    def order(self) -> Array:
        """The colours of the four corners of every tile, (K**4, 4): upper left, upper right, lower left, lower right.

        Tiles are numbered along the rows of the atlas.
        """
        shifted = [np.roll(self.corners, (-down, -right), (0, 1)) for down in (0, 1) for right in (0, 1)]
        return np.stack(shifted, axis=2).reshape(-1, 4)

    @cached_property
    def tiles(self) -> Array:
        """The number of the tile of four corners, (K, K, K, K)."""
        out = np.empty((self.colours,) * 4, np.int64)
        out[tuple(self.order.T)] = np.arange(len(self.order))
        return out

    def field(self, rows: int, columns: int, seed: int = 0, first: Pair = (0, 0)) -> Array:
        """Return the numbers of the tiles of a part of a field, (rows, columns).

        `seed`: 0 to 2**32 - 1; `first`: row and column of the first, within 2**31 of the origin.
        """
        y, x = np.ogrid[first[0] : first[0] + rows + 1, first[1] : first[1] + columns + 1]
        c = colour_at(y, x, self.colours, seed)
        return np.asarray(self.tiles[c[:-1, :-1], c[:-1, 1:], c[1:, :-1], c[1:, 1:]])

    def as_json(self, pictures: dict[str, str], about: dict[str, object], kept: int) -> str:
        """Return the rule as JSON; `pictures`: file of each plane; `about`: what made them."""
        said = {
            "intarsia": VERSION, **about, "pictures": pictures, "tiles": len(self.order), "colours": self.colours,
            "size": [self.width, self.height], "atlas": [self.side, self.side], "alike_px": kept,
            "corners": self.order.tolist(),
            "choose": "The tile of column x and row y has the colours of the corners (x, y), (x + 1, y), (x, y + 1) "
            "and (x + 1, y + 1), in the order of corners, whose n-th entry is tile n: column n % atlas, row n / atlas "
            "of each picture. The colour of a corner: h = x * factors[0] + y * factors[1] + seed * factors[2]; for "
            "each step h = (h ^ h >> step[0]) * step[1]; h = h ^ h >> 16; (h >> 16) * colours >> 16; all modulo 2**32.",
            "factors": FACTORS, "steps": STEPS,
        }  # fmt: skip
        return json.dumps(said, indent=1) + "\n"

    def godot(self, picture: str) -> str:
        """Return a TileSet of Godot 4 with a terrain for each colour, matched by corners; `picture`: the atlas."""
        size = f"Vector2i({self.width}, {self.height})"
        lines = [
            '[gd_resource type="TileSet" load_steps=3 format=3]', "",
            f'[ext_resource type="Texture2D" path={json.dumps(picture, ensure_ascii=False)} id="1"]', "",
            '[sub_resource type="TileSetAtlasSource" id="1"]', 'texture = ExtResource("1")',
            f"texture_region_size = {size}", "use_texture_padding = false",
        ]  # fmt: skip
        for n, own in enumerate(self.order.tolist()):
            tile = f"{n % self.side}:{n // self.side}/0"
            lines += [f"{tile} = 0", f"{tile}/terrain_set = 0", f"{tile}/terrain = {max(own, key=own.count)}"]
            lines += [f"{tile}/terrains_peering_bit/{s} = {c}" for s, c in zip(SIDES, own, strict=True)]
        lines += ["", "[resource]", f"tile_size = {size}", "terrain_set_0/mode = 1"]
        for c in range(self.colours):
            shown = ", ".join(f"{float(k == c):g}" for k in range(3))
            lines += [f'terrain_set_0/terrain_{c}/name = "corner {c}"']
            lines += [f"terrain_set_0/terrain_{c}/color = Color({shown}, 1)"]
        return "\n".join([*lines, 'sources/0 = SubResource("1")', ""])

    def glsl(self, picture: str) -> str:
        """Return a function in GLSL that returns the place in the atlas; `picture`: its name."""
        return GLSL.format(
            name=picture, version=VERSION, side=self.side, count=len(self.order), colours=self.colours,
            pairs=self.colours**2, tiles=", ".join(map(str, self.tiles.ravel())), factors=FACTORS, steps=STEPS,
        )  # fmt: skip


def cycle(colours: int) -> list[int]:
    """Return the de Bruijn cycle of pairs: colours in a circle, in which each follows each once."""
    return [c for a in range(colours) for c in (a, *(n for b in range(a + 1, colours) for n in (a, b)))]


def colour_at(y: Array, x: Array, colours: int, seed: int = 0) -> Array:
    """Return the colours, 0 to `colours` - 1, of the corners at rows `y` and columns `x`, also negative ones."""
    total = sum(np.asarray(n, np.int64) * factor for n, factor in zip((x, y, seed), FACTORS, strict=True))
    h: Array = np.asarray(total, np.int64).astype(np.uint32)
    for shift, factor in STEPS:
        h = (h ^ h >> shift) * np.uint32(factor)
    return np.asarray(((h ^ h >> 16) >> 16) * np.uint32(colours) >> 16).astype(np.int64)
