"""Built-in exemplars: three CC0 photographs that scikit-image carries, and four surfaces painted by formula."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path

from ..errors import InputError
from ..image import Plane
from .decode import decode
from .paint import pebbles, planks, stones, tiles
from .source import look

PREFIX = "sample:"
_PHOTOS = ("brick", "grass", "gravel")
_PAINTED: dict[str, Callable[[], Plane]] = {"tiles": tiles, "pebbles": pebbles, "stones": stones, "planks": planks}


def sample_names() -> list[str]:
    """List the built-in exemplars, as in ``sample:tiles``."""
    return sorted([*_PHOTOS, *_PAINTED])


def sample(name: str) -> Plane:
    """Return a built-in exemplar; nothing is downloaded.

    Raises InputError for an unknown name.
    """
    word = name.removeprefix(PREFIX)
    if word in _PAINTED:
        return _PAINTED[word]()
    if word not in _PHOTOS:
        raise InputError(f"there is no sample {word[:40]!r}; choose one of {', '.join(sample_names())}.")
    # Its files are read by their place: scikit-image itself is slow to import, and might try to download.
    found = importlib.util.find_spec("skimage")
    path = Path(found.origin or "").parent / "data" / f"{word}.png" if found else None
    if path is None or not path.is_file():
        raise InputError(f"this scikit-image carries no {word}.png; choose a painted one, such as sample:tiles.")
    return Plane(decode(look(path)).pixels, meta={"name": "png"})
