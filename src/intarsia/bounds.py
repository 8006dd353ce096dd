"""Limits and usual values that stand in help texts, too. Imports nothing."""

PHOTOS = ("brick", "grass", "gravel")
PAINTED = ("tiles", "pebbles", "stones", "planks")
SAMPLES = tuple(sorted(PHOTOS + PAINTED))
"""The built-in exemplars: photographs, and surfaces painted by formula."""

MAX_PIXELS = 1 << 31
"""Of an output that is held in memory."""

FEATHER = 1024
"""Px over which seams may be softened, or steps at them evened out, at most."""

TIMES = 64
"""How many times larger than they are grown pictures are drawn at most."""

MARGIN = 100
"""Px by which a picture is extended to the right if no side is named (Multrus 2003, A.1)."""

PASSES, MOST_PASSES = 4, 1000
"""How often a repair looks for the worst seams: usually, and at most."""
