"""The correction operation as a memorandum of 2008 defines it: 5 x 5 colours, proximity and jump sets."""

PRESET = {
    "method": "correction-2008",
    "snap": "off",
    "channel_weights": "1",
}
"""What `grow --as correction2008` sets: options, and their values as they are written."""
