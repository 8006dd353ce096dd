"""``intarsia export``: materials as engines read them. Imports nothing heavy before the work."""

from __future__ import annotations

from os.path import join
from typing import Any

from ...request import Request
from .. import Report
from ..verbs import HelpfulCommand


def export(request: Request, report: Report) -> None:
    """Write a material as an engine reads it: names of files, green of the normals, packed maps.

    \b
    intarsia export grown/ --for unreal -o Content/
    intarsia export wall_albedo.png wall_normal.png wall_roughness.png --for unity -o Assets/
    """
    from ...materials.engines import for_engine
    from ..outputs import write_sets

    def made(exemplar: Any, found: Any) -> Any:
        pictures, told = for_engine(exemplar, request.engine or "")
        return {join(request.out or "", name): plane for name, plane in pictures.items()}, told

    write_sets(request, report, made)


command = HelpfulCommand("export", export)
