"""What no method can mend, told before anything is grown."""

from __future__ import annotations

from ..lattice.vectors import UNIT
from .facts import Facts
from .rules import BOUNDS


def warnings_of(f: Facts) -> tuple[str, ...]:
    """What no method can mend, in sentences that say what to do."""
    out: list[str] = []
    if f.side < BOUNDS.side:
        out.append(f"the exemplar is only {f.side} px on its shorter side; a larger one gives more to choose from.")
    if f.constant or f.canvas.start is not None or f.canvas.guide is not None:
        return tuple(out)
    if f.side >= BOUNDS.side and f.lattice is not None:
        longest = max((y * y + x * x) ** 0.5 for y, x in f.lattice.vectors) / UNIT
        if f.side < BOUNDS.periods * longest:
            out.append(f"the exemplar holds fewer than two periods of {longest:.0f} px; a larger one varies more.")
    elif f.side >= BOUNDS.side and f.across < BOUNDS.across:
        out.append(
            f"the exemplar is {f.across:.1f} elements of {f.element.size} px across, so repeats will show; "
            "a larger exemplar varies more."
        )
    if f.regions.two:
        out.append(
            "the exemplar seems to show two textures side by side; crop it to one (--crop), or paint with both "
            "(intarsia paint)."
        )
    if f.light.strong and not f.exemplar.toroidal:
        out.append(
            f"{100 * f.light.share:.0f} % of what its parts differ by is one slope of light, {f.light.factor:.1f} "
            "times brighter on one side: flatten it (--flatten), if that is light and not the texture."
        )
    return tuple(out)
