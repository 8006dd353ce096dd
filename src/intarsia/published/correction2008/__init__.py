"""The correction operation of a memorandum of 2008: 5 x 5 colour neighbourhoods, proximity and jump sets."""

PRESET = {
    "method": "correction-2008",
    "keep_lattice": "off",
    "channel_weights": "1",
}
"""Options that `grow --as correction2008` sets, with their values as strings."""
