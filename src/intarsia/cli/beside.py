"""What lies beside a picture and was used to make it, by its usual name: a recipe names no files, and knows hashes."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

from .. import files

DONE = re.compile(r"_(grown|extended|healed|painted|tiled)(_[0-9]+)?$")
"""How the name of an output ends that was given none; before it stands that of its exemplar."""


class Neighbours:
    """The pictures in the folder of one, no links and no folders among them: `floor.png` beside `floor_grown.png`."""

    def __init__(self, picture: str) -> None:
        self.folder, name = os.path.split(picture)
        here = list[str]()
        with suppress(OSError), os.scandir(self.folder or os.curdir) as found:
            here += [e.name for e in found if e.is_file(follow_symlinks=False) and e.name != name]
        self._names = sorted(n for n in here if os.path.splitext(n)[1].lower() in files.sets.READABLE)
        stem = Path(name.removesuffix(".recipe.json")).stem
        self._exemplar = DONE.sub("", stem) if DONE.search(stem) else None

    def exemplar(self, recipe: dict[str, Any]) -> tuple[str, ...]:
        """The picture, or the planes of a set, that the name of the output begins with; of one exemplar alone."""
        if self._exemplar is None or len(recipe["exemplars"]) != 1:
            return ()
        alone = self._paths(n for n in self._names if Path(n).stem == self._exemplar)
        split = ((n, *files.sets.name_of(n)) for n in self._names)
        planes = self._paths(n for n, own, word in split if own == self._exemplar and word not in (None, "mask"))
        return alone[:1] or planes

    def called(self, word: str) -> str | None:
        """The file `word.png`, or, behind the name of the exemplar, `floor_word.png`, in any format."""
        for stem in (f"{self._exemplar}_{word}", word):
            for path in self._paths(n for n in self._names if Path(n).stem == stem):
                return path
        return None

    def _paths(self, names: Any) -> tuple[str, ...]:
        return tuple(os.path.join(self.folder, n) for n in names)
