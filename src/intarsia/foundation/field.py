"""Spatially varying parameters: a constant, a gray picture, or a function of the place."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from . import InputError, IntarsiaError, Pair, lazy, said

if TYPE_CHECKING:
    import numpy as np

    from .arrays import Array, Floats, Int64
else:  # the command line makes methods before any work
    np = lazy("numpy")
arrays = lazy("intarsia.foundation.arrays")

FULL = {"bool": 1, "uint8": 255, "uint16": 65535}
"""Types of pictures whose range is mapped linearly to `low` to `high`, and their largest value."""

ROWS = 256  # rows of a picture that are hashed at a time
TRIED = (3, 2)  # rows and columns at which a function is evaluated once before any work, to see that it gives numbers


@dataclass(frozen=True, eq=False, repr=False)
class Field:
    """A number for every pixel: a spatially varying parameter.

    Constants and pictures are equal if they give the same numbers. A function equals only itself, as its values cannot
    be enumerated; recipes hold a hash of the values that were used.

    Parameters
    ----------
    value : number, array of shape (H, W), or function
        A gray picture of type bool, uint8 or uint16 is scaled: 0 means `low`, white means `high`. Other arrays are
        taken as they are. Beyond a picture its border pixels are repeated. A function f(y, x) is given rows (n, 1) and
        columns (1, m) in px, float64, also outside of the output, and returns numbers (n, m). It must be
        deterministic; one at the top level of a module can be sent to other processes.
    low, high : float, optional
        The least and the greatest number that is allowed. None, the default: those of the parameter that it is given
        to; pictures are then scaled to that range, or to 0 to 1 without one.

    Raises
    ------
    InputError
        if numbers are NaN, infinite or out of range, or the array is no picture.
    """

    value: float | Array | Callable[[Any, Any], Any]
    low: float | None = None
    high: float | None = None

    def __post_init__(self) -> None:
        if callable(self.value):
            self._asked(*(np.arange(n, dtype=np.int64) for n in TRIED))
            return
        given = arrays.pixels_of(self.value)
        if given.dtype.kind not in "buif" or (given.ndim == 0 and given.dtype.kind == "b"):
            raise InputError(f"{type(self.value).__name__} is no field; give a number, a gray picture or a function.")
        if given.ndim == 3 and given.shape[2] == 1:
            given = given[:, :, 0]
        if given.ndim not in (0, 2) or 0 in given.shape:
            raise InputError(f"an array of shape {given.shape} is no field; give a gray picture, (height, width).")
        if given.ndim == 0:
            object.__setattr__(self, "value", float(given))
        else:
            own = np.array(given, order="C")
            own.flags.writeable = False
            object.__setattr__(self, "value", own)
        stretched = given.ndim == 2 and given.dtype.name in FULL
        ends = np.zeros(1) if stretched else np.array([given.min(), given.max()], np.float64)
        if not np.isfinite(ends).all():
            raise InputError("it holds NaN or infinite numbers; give finite ones.")
        low, high = (None, None) if stretched else (self.low, self.high)
        if (low is not None and ends[0] < low) or (high is not None and ends[1] > high):
            raise InputError(f"it holds numbers from {ends[0]:g} to {ends[1]:g}; give {low:g} to {high:g}.")

    def __reduce__(self) -> Any:
        return Field, (self.value, self.low, self.high)

    def __repr__(self) -> str:
        return f"<field: {self.as_recipe}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Field) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def is_function(self) -> bool:
        """Whether the values come from a function."""
        return callable(self.value)

    @property
    def number(self) -> float | None:
        """The value of a constant field; else None."""
        return self.value if isinstance(self.value, float) else None

    @property
    def size(self) -> Pair | None:
        """Height and width of a picture in px; else None."""
        return None if callable(self.value) or isinstance(self.value, float) else self.value.shape[:2]

    def within(self, low: float | None, high: float | None) -> Field:
        """Return the field limited to the range of a parameter; InputError if its own range goes beyond."""
        if self.low is None and self.high is None:
            return replace(self, low=low, high=high)
        for own, end, sign in ((self.low, low, 1), (self.high, high, -1)):
            if own is None or (end is not None and sign * own < sign * end):
                raise InputError(f"the field goes from {self.low} to {self.high}, {low} to {high} is allowed.")
        return self

    def at(self, rows: Int64, columns: Int64, around: bool = False) -> Floats:
        """Return the values at rows (n,) and columns (m,) in px: float64 (n, m).

        Values of a function are clipped to the allowed range, as it is evaluated outside of the output, too; but not
        if they are periodic, as angles are (`around`).
        """
        if isinstance(self.value, float):
            return np.full((len(rows), len(columns)), self.value)
        if callable(self.value):
            numbers = self._asked(rows, columns)
            if not np.isfinite(numbers).all():
                raise InputError(f"the function {self._name} gives NaN or infinite numbers; give finite ones.")
            return numbers if around or self.low is self.high is None else np.clip(numbers, self.low, self.high)
        height, width = self.value.shape
        return self._stretched(self.value[np.clip(rows, 0, height - 1)][:, np.clip(columns, 0, width - 1)])

    @property
    def as_recipe(self) -> float | dict[str, Any]:
        """The field as saved in recipes: a number, size and hash of a picture, or the name of a function."""
        if isinstance(self.value, float):
            return self.value
        if callable(self.value):
            return {"function": self._name, "replayable": False}
        height, width = self.value.shape
        return {"size": [width, height], "sha256": self.digest}

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the values of a constant or a picture, as 64 hexadecimal digits.

        Pictures with the same values have the same digest, whatever their depth.
        """
        assert not callable(self.value)
        if isinstance(self.value, float):
            return hashlib.sha256(repr(self.value).encode()).hexdigest()
        hashed = hashlib.sha256(f"{self.value.shape}".encode())
        for row in range(0, len(self.value), ROWS):
            hashed.update((self._stretched(self.value[row : row + ROWS]) + 0.0).astype("<f8").tobytes())
        return hashed.hexdigest()

    @property
    def _key(self) -> tuple[Any, ...]:
        return (id(self.value), self.low, self.high) if self.is_function else (self.digest,)

    @property
    def _name(self) -> str:
        return function_name(self.value)

    def _asked(self, rows: Int64, columns: Int64) -> Floats:
        assert callable(self.value)
        y, x = rows.astype(np.float64)[:, None], columns.astype(np.float64)[None, :]
        try:
            found = np.asarray(self.value(y, x), np.float64)
            return np.array(np.broadcast_to(found, (len(rows), len(columns))))
        except IntarsiaError:
            raise
        except Exception as e:  # errors of the user's function are reported as such
            raise InputError(
                f"the function {self._name} gives no numbers for rows (n, 1) and columns (1, m): {said(e)}"
            ) from e

    def _stretched(self, numbers: Array) -> Floats:
        full = FULL.get(numbers.dtype.name)
        if full is None:
            return numbers.astype(np.float64)
        low, high = (0.0 if self.low is None else self.low), (1.0 if self.high is None else self.high)
        return np.asarray(low + (high - low) * (numbers.astype(np.float64) / full))


def function_name(function: Any) -> str:
    """Return the name of a function in messages and recipes: its module and qualified name."""
    kind = function if hasattr(function, "__qualname__") else type(function)
    return f"{kind.__module__}.{kind.__qualname__}"
