"""The pictures of Robinson 2004: random tiling beside quilting, in the report's settings and order."""

from __future__ import annotations

from .figures import Figure, Panels, Way, row, synthesized

TITLE = "Robinson 2004, An Implementation of the Efros and Freeman Image Quilting Algorithm"
SETTINGS = ((26, 4, "concrete"), (42, 7, "brick, pebbles, wood, apples"), (84, 14, "fence"),
            (24, 4, "scales, text, weave"), (48, 8, "water"))  # fmt: skip


def quilted(patch: object, overlap: object) -> Way:
    """Return a panel by quilting, of twice the exemplar's size."""
    return synthesized(None, "raster-quilting", {"patch": patch, "overlap": overlap})


def pair(patch: int, overlap: int) -> Panels:
    """Return panels by random tiling and by quilting, from 160 px of the exemplar."""
    return row(synthesized(None, "random-tiling", {"patch": patch}), quilted(patch, overlap), side=160)


def beside(number: str, claim: str, rising: str, *settings: tuple[object, object]) -> Figure:
    """Return a figure of quilting with several patches and overlaps."""
    return Figure(number, claim, row(*(quilted(*s) for s in settings), side=160), rising, "sample:tiles", "bcd")


FIGURES = (
    *(
        Figure(
            str(n), f"Patches of {patch} px, {overlap} px of them shared ({names}).", pair(patch, overlap),
            "seams c b", letters="bc",
        )
        for n, (patch, overlap, names) in enumerate(SETTINGS, 1)
    ),
    beside("6", "Too small a patch misses the structure.", "seams c b", (12, 2), (42, 7)),
    beside("7", "A wider overlap is better for bricks.", "seams d c b", (24, 4), (24, 8), (24, 12)),
    beside("8", "Rectangles do not help.", "seams b c", (42, 7), ((30, 60), (5, 10))),
)  # fmt: skip
