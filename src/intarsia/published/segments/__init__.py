"""Patch-based synthesis with candidates chosen by segment histograms of the boundary zone (anonymous fragments)."""

PRESET = {
    "method": "segment-based",
    "energy": "sum",
    "layout": "raster",
    "points": "1",
    "repeat_penalty": "0",
}
"""Options that `grow --as segments` sets, with their values as strings."""
