"""Parameters of a method that are functions of the place: their values at all places of a picture, and a hash of these.

A recipe cannot hold a function, and its name says nothing. But a picture depends on no more than the values that the
function gave: recipes and stores hold the hash of these.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exemplar import Exemplar
from ..field import Field
from ..params import parameters
from .jitter import jitter_shares
from .orientation import turns, zooms
from .outlines import painted

SIDE = 1024  # places whose numbers are in memory at a time, along each axis

Array = NDArray[Any]

USED: dict[str, Callable[[Field, Array, Array], Array]] = {
    "angle": turns,
    "feature": painted,
    "jitter_exemplar": jitter_shares,
    "jitter_output": jitter_shares,
    "zoom": zooms,
}
"""Parameter -> the whole numbers that it is used as, so that no machine tells them otherwise than its picture."""


def functions_of(method: Any) -> dict[str, Field]:
    """The functions among the parameters of a method, by name."""
    values = {p.name: getattr(method, p.name) for p in parameters(method)}
    return {name: value for name, value in values.items() if isinstance(value, Field) and value.is_function}


def hashes(method: Any, exemplar: Exemplar, places: Iterable[list[Array]]) -> dict[str, str]:
    """Return for each function of a method SHA-256, 64 hexadecimal digits, of its values.

    `places`: rows and columns in px that functions over the output are asked for, level by level; those over the
    exemplar are asked for all of its pixels.
    """
    inside, outside, over = [[np.arange(exemplar.height), np.arange(exemplar.width)]], list(places), {}
    for p in parameters(method):
        over[p.name] = inside if p.over == "exemplar" else outside
    return {name: _hash(field, USED[name], over[name]) for name, field in functions_of(method).items()}


def _hash(field: Field, used: Callable[[Field, Array, Array], Array], places: list[list[Array]]) -> str:
    found = hashlib.sha256()
    for rows, cols in places:
        found.update(f"{len(rows)}x{len(cols)}|".encode())
        for y in range(0, len(rows), SIDE):
            for x in range(0, len(cols), SIDE):
                numbers = used(field, rows[y : y + SIDE], cols[x : x + SIDE])
                found.update(numbers.astype("<i2").tobytes())
    return found.hexdigest()
