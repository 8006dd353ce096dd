"""The pictures of Robinson 2004: random tiling beside quilting, in the report's settings, in its order."""

from __future__ import annotations

from collections.abc import Callable

from ...exemplar import Exemplar
from ..figures import Figure, Panel, given, grown

TITLE = "Robinson 2004, An Implementation of the Efros and Freeman Image Quilting Algorithm"
USUAL = "sample:pebbles"
SETTINGS = ((26, 4, "concrete"), (42, 7, "brick, pebbles, wood, apples"), (84, 14, "fence"),
            (24, 4, "scales, text, weave"), (48, 8, "water"))  # fmt: skip


def pair(patch: int, overlap: int) -> Callable[[Exemplar], list[Panel]]:
    """Random tiling beside quilting, of twice the exemplar's size."""

    def panels(exemplar: Exemplar) -> list[Panel]:
        size = 2 * exemplar.height, 2 * exemplar.width
        tiled = grown("b", exemplar, size, "random-tiling", {"patch": patch})
        settings = {"patch": patch, "overlap": overlap}
        return [given(exemplar), tiled, grown("c", exemplar, size, "raster-quilting", settings)]

    return panels


FIGURES = tuple(
    Figure(str(n), f"Patches of {patch} px, {overlap} px of them shared ({names}).", pair(patch, overlap), USUAL)
    for n, (patch, overlap, names) in enumerate(SETTINGS, 1)
)
