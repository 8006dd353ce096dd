"""The pictures of Robinson 2004: random tiling beside quilting, in the report's settings, in its order."""

from __future__ import annotations

from collections.abc import Callable

from ...model import Exemplar
from ..figures import Figure, Panel, Way, grown, row

TITLE = "Robinson 2004, An Implementation of the Efros and Freeman Image Quilting Algorithm"
USUAL = "sample:pebbles"
SETTINGS = ((26, 4, "concrete"), (42, 7, "brick, pebbles, wood, apples"), (84, 14, "fence"),
            (24, 4, "scales, text, weave"), (48, 8, "water"))  # fmt: skip


def quilted(letter: str, patch: object, overlap: object) -> Way:
    """A panel by quilting, of twice the exemplar's size."""
    return grown(letter, None, "raster-quilting", {"patch": patch, "overlap": overlap})


def pair(patch: int, overlap: int) -> Callable[[Exemplar], list[Panel]]:
    """Random tiling beside quilting, of 160 px of the exemplar."""
    return row(grown("b", None, "random-tiling", {"patch": patch}), quilted("c", patch, overlap), side=160)


def beside(*settings: tuple[object, object]) -> Callable[[Exemplar], list[Panel]]:
    """Quilting with several patches and overlaps."""
    return row(*(quilted(k, *s) for k, s in zip("bcd", settings, strict=False)), side=160)


FIGURES = (
    *(
        Figure(
            str(n), f"Patches of {patch} px, {overlap} px of them shared ({names}).",
            pair(patch, overlap), USUAL, "seams c b",
        )
        for n, (patch, overlap, names) in enumerate(SETTINGS, 1)
    ),
    Figure("6", "Too small a patch misses the structure.", beside((12, 2), (42, 7)), "sample:tiles", "seams c b"),
    Figure(
        "7", "A wider overlap is better for bricks.",
        beside((24, 4), (24, 8), (24, 12)), "sample:tiles", "seams d c b",
    ),
    Figure("8", "Rectangles do not help.", beside((42, 7), ((30, 60), (5, 10))), "sample:tiles", "seams b c"),
)
