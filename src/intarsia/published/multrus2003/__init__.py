"""Patch-based sampling with all that Multrus 2003 has: candidates, counters and marks, and the pyramid search."""

PRESET = {
    "method": "patch-sampling",
    "patch": "25",
    "overlap": "5",
    "search": "exact",
    "repetition": "none",
    "channel_weights": "1",
    "boundary_patch": "0",
    "boundary_isometries": "none",
    "boundary_slack": "10000",
    "boundary_join": "same",
    "mixing": "source",
}
"""What `grow --as multrus2003` sets: options, and their values as they are written."""
