"""Pictures that were drawn lately are kept a while."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

HELD = 64 << 20  # bytes of pictures that are kept


class Pictures:
    """Pictures that were drawn lately, by what they are of."""

    def __init__(self, most: int = HELD) -> None:
        self._held: OrderedDict[tuple[Any, ...], bytes] = OrderedDict()
        self._most, self._size = most, 0

    def get(self, key: tuple[Any, ...]) -> bytes | None:
        """Return a picture, if it is kept."""
        if key in self._held:
            self._held.move_to_end(key)
        return self._held.get(key)

    def keep(self, key: tuple[Any, ...], data: bytes) -> bytes:
        """Keep a picture; those that were asked for longest ago give way."""
        self._size += len(data) - len(self._held.pop(key, b""))
        self._held[key] = data
        while self._size > self._most:
            self._size -= len(self._held.popitem(last=False)[1])
        return data
