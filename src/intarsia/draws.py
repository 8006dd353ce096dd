"""Randomness without a generator: a draw is a hash of where and for what it is made.

The same (seed, stage, level, y, x) gives the same 64 bits on every machine, in any order, from any thread.
Coordinates may be negative and as large as 2**63. Nothing else in the package makes randomness.
"""

from __future__ import annotations

from .errors import ParameterError

MASK = (1 << 64) - 1
SEED_LIMIT = 1 << 64


def draw(seed: int, stage: int, level: int = 0, y: int = 0, x: int = 0) -> int:
    """Return 64 well mixed bits, a function of the five numbers only."""
    state = seed & MASK
    for word in (stage, level, y, x):
        state = _mix(((state ^ (word & MASK)) + 0x9E3779B97F4A7C15) & MASK)
    return state


def below(n: int, bits: int) -> int:
    """Turn 64 drawn bits into a number in 0 .. n-1 (n at most 2**32; the bias is below 2**-32)."""
    return ((bits >> 32) * n) >> 32


def _mix(z: int) -> int:
    # The finaliser of splitmix64 (Steele, Lea and Flood 2014).
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
    return z ^ (z >> 31)


def check_seed(seed: int) -> int:
    """Return the seed as an int, or refuse it."""
    if isinstance(seed, bool) or not hasattr(seed, "__index__") or not 0 <= int(seed) < SEED_LIMIT:
        raise ParameterError(f"seed={seed!r} is no whole number from 0 to 2**64 - 1; choose one, such as 7.")
    return int(seed)
