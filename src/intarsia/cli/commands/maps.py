"""``intarsia maps``: maps proposed from those that are there. Imports nothing heavy before the work."""

from __future__ import annotations

from dataclasses import replace
from os.path import isdir, join, splitext
from typing import Any

from ...request import Request
from .. import Report
from ..verbs import HelpfulCommand


def propose(request: Request, report: Report) -> None:
    """Propose height, normal and roughness of a photograph, by its brightness: look at them before you trust them.

    Of normals the height is made, of a height the normals. What the recipe of a picture calls tileable stays so. Names
    of what is proposed end in _proposed, and are read as those of the set.

    \b
    intarsia maps stones.png -o stones/
    intarsia maps wall_albedo.png wall_height.png -o maps/wall --strength 2
    """
    from ... import files
    from ...materials.maps import proposed
    from ..exemplars import stem_of
    from ..outputs import files_of, filled_name, write_sets

    def made(exemplar: Any, found: Any) -> Any:
        exemplar = replace(exemplar, toroidal=exemplar.toroidal or files.tiles(next(iter(found.values()))))
        exemplar = proposed(exemplar, strength=request.strength)
        out, stem = request.out or "", stem_of(found)
        told = [f"{n}: proposed, {p.meta['proposed']}" for n, p in exemplar.planes.items() if "proposed" in p.meta]
        base = join(out, stem) if out.endswith("/") or isdir(out) else splitext(out)[0]
        return files_of(filled_name(base, {"stem": stem}), exemplar), told

    write_sets(request, report, made)


command = HelpfulCommand("maps", propose)
