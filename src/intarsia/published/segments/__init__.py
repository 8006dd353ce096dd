"""Patches chosen by the segments in their boundary zone, as fragments without author or title have it."""
