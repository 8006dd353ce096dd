"""Near-regular textures as Lopez Recas 2011 lays them: square blocks at random, the gaps between them filled."""

PRESET = {
    "method": "gap-filling",
    "detector": "goodness",
    "channel_weights": "1",
    "mixing": "source",
}
"""What `grow --as lopez_recas2011` sets: options, and their values as they are written."""
