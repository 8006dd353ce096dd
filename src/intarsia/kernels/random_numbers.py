"""Counter-based random numbers in kernels: the same bits as in :mod:`intarsia.foundation.run`."""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import kernel

STEP = np.uint64(0x9E3779B97F4A7C15)
START = np.uint64(0x6A09E667F3BCC909)
FIRST, SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
S30, S27, S31, S32 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(32)


@kernel
def mixed(z: Any) -> Any:
    """Mix 64 bits (the finaliser of splitmix64)."""
    z = (z ^ (z >> S30)) * FIRST
    z = (z ^ (z >> S27)) * SECOND
    return z ^ (z >> S31)


@kernel
def draw(seed: Any, stage: int, level: int, y: int, x: int) -> Any:
    """Return the 64 bits that belong to (seed, stage, level, y, x); `seed` is a uint64."""
    z = mixed((mixed(seed ^ START) ^ np.uint64(stage)) + STEP)
    z = mixed((z ^ np.uint64(level)) + STEP)
    z = mixed((z ^ np.uint64(y)) + STEP)
    return mixed((z ^ np.uint64(x)) + STEP)


@kernel
def below(n: int, bits: Any) -> Any:
    """Turn 64 drawn bits into a number in 0 .. n-1."""
    return np.int64(((bits >> S32) * np.uint64(n)) >> S32)
