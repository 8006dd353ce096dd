"""Segments and groups: the sizes that the eye sees, the rules of the source, and answers for odd exemplars."""

SEEN = """
irregular_autumn-leaves_256, 40
irregular_daisies_320, 16
irregular_drystone-wall_384, 85
irregular_flagstone_320, 62
irregular_pebbles_256, 33
irregular_red-peppers_256, 52
irregular_reptile-scales_256, 46
irregular_typewriter-text_384x320, 22
near-regular_blue-tiles-defect_512, 128
near-regular_brick-gray_192, 92
near-regular_brick-large_256, 125
near-regular_brick-wall_256, 28
near-regular_burlap-cloth_256, 16
near-regular_chainmail_256, 85
near-regular_cobble-moss_320, 88
near-regular_fan-cobble_384, 30
near-regular_potato-rows_448, 140
near-regular_shingle-roof_256, 20
near-regular_stone-blocks_416, 95
near-regular_tile-floor-broken_320, 64
near-regular_wicker_192, 72
regular_azulejo_384, 128
regular_chainlink-fence-alpha_256, 85
regular_clay-roof_256, 26
regular_parquet-basket_320, 80
regular_wallpaper-diamond_256, 45
stochastic_gravel-gray_192, 25
stochastic_hedge_256, 22
"""
"""Sizes, px, read off the photographs with a ruler: the long side of a typical whole element and the gap to its
next neighbour. Written down before any rule was tuned."""


def test_the_table_of_sizes_reads() -> None:
    rows = [line.split(", ") for line in SEEN.split("\n") if line]
    assert len(rows) == 28
    assert all(8 <= int(size) <= 256 for _, size in rows)
