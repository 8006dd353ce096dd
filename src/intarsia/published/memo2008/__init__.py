"""The correction operation as a memorandum of 2008 defines it: a setting of parallel-controllable."""

PRESET = {
    "method": "parallel-controllable",
    "neighbourhood": "colour",
    "rule": "memo",
    "snap": "off",
    "channel_weights": "1",
}
"""What `grow --as memo2008` sets: options, and their values as they are written."""
