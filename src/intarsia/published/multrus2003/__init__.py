"""Patch-based sampling as in Multrus 2003: candidate bounds, repetition counters and marks, pyramid search."""

PRESET = {
    "method": "patch-sampling",
    "patch": "25",
    "overlap": "5",
    "search": "exact",
    "repetition": "none",
    "channel_weights": "1",
    "boundary_patch": "0",
    "boundary_isometries": "none",
    "boundary_tolerance": "10000",
    "boundary_join": "same",
    "mixing": "source",
}
"""Options that `grow --as multrus2003` sets, with their values as strings."""
