"""``intarsia tileset``: Wang tiles by corners, and how to lay them. Imports nothing heavy before the work."""

from __future__ import annotations

from os.path import basename, join
from typing import Any

from ...foundation.run import Run
from ...request import Request
from .. import CANCEL, Report
from ..verbs import HelpfulCommand

MOST, SEEN = 16, 2048
"""Most tiles along a side of the preview, and its longest side in px."""


def tileset(request: Request, report: Report) -> None:
    """Make tiles that fit wherever the colours of their corners agree: ground without end, without a seam.

    Beside the pictures NAME_tiles of all tiles, one of each plane, lie the rule as JSON, a preview of a field, a
    TileSet of Godot 4, and a function in GLSL.

    \b
    intarsia tileset pebbles.png -o tiles/
    intarsia tileset wall_albedo.png wall_normal.png -o tiles/ --tiles 81 --size 192
    """
    from ...synthesis import recipe_exemplars
    from ...tasks.tileset import grown, planned
    from ..exemplars import stem_of
    from ..outputs import check_all, check_depths, plane_files, usual_ending, write_sets

    def made(exemplar: Any, found: Any) -> Any:
        run = Run(request.threads, cancel=CANCEL)
        plan = planned(exemplar, int(request.tiles), request.size and request.size[::-1], run)
        height, width = (plan.colours**2 * n for n in plan.size)
        ending = usual_ending(next(iter(found.values())), exemplar.base, max(height, width) / max(exemplar.shape), None)
        stem = join(request.out or "", stem_of(found) + "_tiles")
        shown = {name: path for name, path in found.items() if exemplar.picture(name) is not None}
        pictures, field = plane_files(stem + ending, shown), f"{stem}_field{ending}"
        json, tres, glsl = (f"{stem}.{kind}" for kind in ("json", "tres", "glsl"))
        check_depths(pictures, exemplar, (width, height), request)
        check_all([*pictures.values(), field, json, tres, glsl], request.force, set(), making=True)
        with report.watching(1) as meter:
            stage = meter.stage("tiles", 0.0, 1.0, (exemplar,))
            tiles = grown(plan, request.seed or 0, Run(request.threads, stage, CANCEL, run.notes))
            meter.next_part()
        report.warn(*run.notes)
        rule, atlas = tiles.rule, basename(stem + ending)
        about = {"seed": tiles.seed, "exemplars": recipe_exemplars(tiles.atlas.exemplars)}
        count = min(MOST, max(SEEN // max(plan.size), 2))
        return {
            **{path: tiles.render(name) for name, path in pictures.items()},
            field: tiles.laid(rule.field(count, count)),
            json: rule.as_json({name: basename(path) for name, path in pictures.items()}, about, tiles.kept),
            tres: rule.godot(atlas), glsl: rule.glsl(atlas),
        }, [f"{request.tiles} tiles of {rule.width}x{rule.height} px, seed {tiles.seed}"]  # fmt: skip

    write_sets(request, report, made)


command = HelpfulCommand("tileset", tileset)
