"""Built-in exemplars: three CC0 photographs that scikit-image carries, four surfaces and a material painted by formula.

These lie in the folder `painted`, wrap around, and are made by ``tools/make_samples.py`` of the repository.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path

from ..arguments import MATERIALS, PAINTED, PHOTOS, SAMPLES
from ..errors import InputError
from ..exemplar import KIND_OF_NAME
from ..image import Kind, Plane
from .decode import decode
from .layers import MARK
from .source import look

PREFIX = "sample:"
FOLDER = Path(__file__).with_name("painted")


def sample_names() -> list[str]:
    """List the built-in exemplars, as in ``sample:tiles``."""
    return [*SAMPLES]


def sample(name: str) -> Plane:
    """Return a built-in exemplar, of a material its albedo, or as ``setts::normal`` another map; nothing is downloaded.

    Raises InputError for an unknown name.
    """
    word, mark, plane = name.removeprefix(PREFIX).partition(MARK)
    if planes := MATERIALS.get(word):
        plane = plane or planes[0]
        if plane not in planes:
            raise InputError(f"sample:{word} has no plane {plane[:40]!r}; its planes are {', '.join(planes)}.")
        return _painted(f"{word}_{plane}", KIND_OF_NAME.get(plane, Kind.COLOUR))
    word += mark + plane
    if word in PAINTED:
        return _painted(word, Kind.COLOUR)
    if word not in PHOTOS:
        raise InputError(f"there is no sample {word[:40]!r}; choose one of {', '.join(sample_names())}.")
    # Its files are read by their place: scikit-image itself is slow to import, and might try to download.
    found = importlib.util.find_spec("skimage")
    path = Path(found.origin or "").parent / "data" / f"{word}.png" if found else None
    if path is None or not path.is_file():
        raise InputError(f"this scikit-image carries no {word}.png; choose a painted one, such as sample:tiles.")
    return Plane(decode(look(path)).pixels, meta={"name": "png"})


def _painted(stem: str, kind: Kind) -> Plane:
    """Read a file of the folder."""
    return Plane(decode(look(FOLDER / f"{stem}.png")).pixels, kind, meta={"name": "sample"})
