"""What is measured before a method is chosen, and what is measured of a picture that was made."""

from .facts import Facts, Measured
from .selfcheck import Score, score

__all__ = ["Facts", "Measured", "Score", "score"]
