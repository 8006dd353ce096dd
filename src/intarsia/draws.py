"""Randomness without a generator: a draw is a hash of where and for what it is made.

The same (seed, stage, level, y, x) gives the same 64 bits on every machine, in any order, from any thread.
Coordinates may be negative and as large as 2**63. Nothing else in the package makes randomness.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .arguments import called, whole
from .errors import ParameterError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MASK = (1 << 64) - 1
STEP = 0x9E3779B97F4A7C15
SEED_LIMIT = 1 << 64


def draw(seed: int, stage: int, level: int = 0, y: int = 0, x: int = 0) -> int:
    """Return 64 well mixed bits, a function of the five numbers only."""
    state = seed_state(seed, stage, level)
    for word in (y, x):
        state = _mix(((state ^ (word & MASK)) + STEP) & MASK)
    return state


def draw_many(seed: int, stage: int, level: int, at: Sequence[tuple[int, int]] | NDArray[np.int64]) -> list[int]:
    """Return ``draw(seed, stage, level, y, x)`` for many places (y, x) at once."""
    import numpy as np

    place = np.array(at, np.int64).reshape(-1, 2).astype(np.uint64)  # two's complement, as in draw
    state = np.full(len(place), seed_state(seed, stage, level), np.uint64)
    for word in place.T:
        state = _mix((state ^ word) + np.uint64(STEP))
    drawn: list[int] = state.tolist()
    return drawn


def seed_state(seed: int, stage: int, level: int) -> int:
    """The state of a draw before its place is mixed in."""
    state: int = _mix((seed ^ 0x6A09E667F3BCC909) & MASK)  # so that seed and stage are not interchangeable
    for word in (stage, level):
        state = _mix(((state ^ (word & MASK)) + STEP) & MASK)
    return state


def below(n: int, bits: int) -> int:
    """Turn 64 drawn bits into a number in 0 .. n-1 (n at most 2**32; the bias is below 2**-32)."""
    return ((bits >> 32) * n) >> 32


def deck(count: int, seed: int, stage: int, level: int, y: int, x: int) -> list[int]:
    """Return the numbers below `count`, shuffled by the draws of a place (Fisher and Yates).

    Card k changes with one that is drawn on level ``level + k``.
    """
    order = list(range(count))
    for k in range(count - 1, 0, -1):
        other = below(k + 1, draw(seed, stage, level + k, y, x))
        order[k], order[other] = order[other], order[k]
    return order


def _mix(z: Any) -> Any:
    # The finaliser of splitmix64 (Steele, Lea and Flood 2014).
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
    return z ^ (z >> 31)


def check_seed(seed: int) -> int:
    """Return the seed as an int, or refuse it."""
    try:
        number = whole(seed)
    except ValueError:
        number = -1
    if not 0 <= number < SEED_LIMIT:
        raise ParameterError(f"seed={called(seed)} is no whole number from 0 to 2**64 - 1; choose one, such as 7.")
    return number
