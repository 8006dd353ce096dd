"""Patches chosen by the segments in their boundary zone, as fragments without author or title have it."""

PRESET = {
    "method": "segment-based",
    "energy": "sum",
    "layout": "raster",
    "points": "1",
    "usage": "0",
}
"""What `grow --as segments` sets: options, and their values as they are written."""
