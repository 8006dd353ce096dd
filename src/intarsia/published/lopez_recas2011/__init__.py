"""Near-regular texture synthesis by random sampling and gap filling (Lopez Recas 2011)."""

PRESET = {
    "method": "gap-filling",
    "detector": "goodness",
    "channel_weights": "1",
    "mixing": "source",
}
"""Options that `grow --as lopez_recas2011` sets, with their values as strings."""
