"""What rules ask of canvases that are filled in part."""

from __future__ import annotations

from ..geometry import Wrap
from .facts import Facts


def goes_on(f: Facts) -> bool:
    """A picture of a lattice is extended; in holes, whose edges must stay, patches fit better than blocks."""
    canvas = f.canvas
    begun = canvas.start is not None and canvas.rim != 0 and canvas.guide is None and len(f.exemplars) == 1
    return begun and f.lattice is not None and f.lattice.kind == "2-D"


def closes(f: Facts) -> bool:
    """A picture that is to continue in itself: empty where its borders meet, and what lies beside may change."""
    canvas = f.canvas
    if canvas.start is None or canvas.guide is not None or not canvas.rim or canvas.wrap is Wrap.NONE:
        return False
    holes = canvas.start.holes
    meet = [holes[[0, -1]]] * canvas.wrap.y + [holes[:, [0, -1]]] * canvas.wrap.x
    return all(bool(border.all()) for border in meet)
