"""What was laid lately, for windows that lie side by side: a course of a chunk is laid and cut once for all of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from threading import Lock
from typing import Any, Generic, TypeVar

from numpy.typing import NDArray

Made = TypeVar("Made", bound=tuple[NDArray[Any], ...])


class Lately(Generic[Made]):
    """Tuples of arrays by where they are, in so many bytes; those that were used longest ago give way."""

    def __init__(self, most: int) -> None:
        self._most, self._size, self._held = most, 0, dict[tuple[int, int], Made]()
        self._lock = Lock()

    def __reduce__(self) -> Any:
        return Lately, (self._most,)

    def all(
        self, keys: Sequence[tuple[int, int]], make: Callable[[Sequence[tuple[int, int]]], Sequence[Made]]
    ) -> list[Made]:
        """Return what belongs to the keys; `make` is asked for those that are not there."""
        with self._lock:
            found = {key: self._held[key] for key in keys if key in self._held}
        missing = [key for key in keys if key not in found]
        found |= zip(missing, make(missing), strict=True)
        with self._lock:
            for key, made in found.items():
                self._size += _bytes(made) - _bytes(self._held.pop(key, None))
                self._held[key] = made
            while self._size > self._most:
                self._size -= _bytes(self._held.pop(next(iter(self._held))))
        return [found[key] for key in keys]


def _bytes(made: tuple[NDArray[Any], ...] | None) -> int:
    return 0 if made is None else sum(array.nbytes for array in made)
