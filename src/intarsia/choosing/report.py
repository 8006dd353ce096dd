"""All measurements in one list, for people and JSON, and what no method can mend."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..analysis.oriented import CLEAR
from ..analysis.symmetry import SLACK
from ..image import Kind
from ..lattice.vectors import UNIT, vectors_of
from ..lattice.verdict import Lattice
from .facts import SIGNS, Facts
from .rules import BOUNDS, courses_of

SURE = 0.3  # confidence of a lattice beyond which nobody doubts it
NEAR = 0.03  # of a bound: twice what a tenth cropped off changes of most exemplars
CLOSE = 0.1  # of a bound: what a tenth cropped off changes of lattices, numbers of elements and turned halves


@dataclass(frozen=True)
class Measured:
    """One fact: its value as JSON holds it, how sure it is from 0 to 1, and what it means in a few words."""

    value: Any
    confidence: float
    says: str

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON."""
        return {"value": self.value, "confidence": round(self.confidence, 3), "says": self.says}


def measurements(f: Facts) -> dict[str, Measured]:
    """Return every fact with its confidence and what it means, in the order in which they are printed."""
    out = {"lattice": _lattice(f), "variation": _variation(f), "elements": _elements(f)}
    out |= {"structure": _structure(f), "outlines": _outlines(f), "courses": _courses(f)}
    out |= {"regions": _regions(f), "symmetry": _symmetry(f)}
    out |= {"border": _border(f), "light": _light(f), "size": _size(f), "kind": _kind(f)}
    if f.reduction > 1:
        said = f"structure, outlines, regions, symmetry, border and light are those of a copy 1/{f.reduction}"
        out["reduced"] = Measured(f.reduction, 1.0, said)
    return out


def _lattice(f: Facts) -> Measured:
    tie = _lattice_tie(f)
    if f.lattice is None:
        best = max((one.confidence for one in f.lattices.ranked), default=0.0)
        about = "" if f.about is None else f", but elements lie about steps of {_shown(f.about)} px"
        return Measured(None, max(0.0, 1 - best / SURE), f"none (best candidate {best:.2f}){tie}{about}")
    vectors = [[x / UNIT, y / UNIT] for y, x in f.lattice.vectors]
    said = f"{_shown(f.lattice)} px, confidence {f.lattice.confidence:.2f}{tie}"
    return Measured(vectors, min(1.0, f.lattice.confidence / SURE), said)


def _shown(found: Lattice) -> str:
    return " and ".join(f"{x:.2f},{y:.2f}" for x, y in vectors_of(found))


def _tie(value: float, bound: float, said: str) -> str:
    """What is said of a value so close to a bound that a slightly other exemplar may get another rule; else nothing."""
    return f", but {said}: nearly a tie" if abs(value - bound) < CLOSE * bound else ""


def _lattice_tie(f: Facts) -> str:
    """Whether the lattice is nearly none, or was nearly one: by its confidence, or by how much repeats by it."""
    found = f.lattices.accepted
    if found is not None and found.kind == "2-D" and found.residual >= SIGNS.loose:
        partly = f"{found.repeats:.2f} of the exemplar repeats, and {SIGNS.partly} makes a lattice"
        if said := _tie(found.repeats, SIGNS.partly, partly):
            return said
    sure = found or max(f.lattices.ranked, key=lambda one: one.share, default=None)
    return "" if sure is None else _tie(sure.share, 1.0, f"it has {sure.share:.2f} of the confidence that makes one")


def _variation(f: Facts) -> Measured:
    if f.lattice is None or f.lattice.kind == "1-D":
        return Measured(None, 1.0, "no periods to compare")
    said = f"periods differ by {100 * f.variation:.0f} % of the contrast; cuts in joints cost {f.joints:.2f} of others"
    return Measured(round(f.variation, 4), min(1.0, f.lattice.confidence / SURE), said)


def _elements(f: Facts) -> Measured:
    e = f.element
    said = f"about {e.size} px ({e.width} wide, {e.height} high)" if e.found else f"not seen; {e.size} px is a guess"
    return Measured({"size": e.size, "width": e.width, "height": e.height}, e.found / 12, said)


def _structure(f: Facts) -> Measured:
    s = f.structure
    directed = f"edges run at {s.angle:.0f} degrees ({s.coherence:.2f})" if s.coherence > 0.25 else "no direction"
    value = {"kurtosis": round(s.kurtosis, 2), "coherence": round(s.coherence, 3), "angle": s.angle}
    return Measured(value, s.coherence, f"{directed}, kurtosis {s.kurtosis:.1f}")


def _outlines(f: Facts) -> Measured:
    far = abs(f.outlines - BOUNDS.outlines)
    kept = "joints or lines that must be kept" if f.outlines >= BOUNDS.outlines else "no outline that must be kept"
    tie = f", but {BOUNDS.outlines} parts the two: nearly a tie" if far < NEAR else ""
    said = f"along outlines filters answer by {f.outlines:.2f} of the mean more: {kept}{tie}"
    return Measured(round(f.outlines, 3), min(1.0, far / (4 * NEAR)), said)


def _courses(f: Facts) -> Measured:
    lines = f.courses
    if lines is None:
        return Measured(None, 0.5, "no lines across it that part courses")
    value = {"axis": ("rows", "columns")[lines.axis], "heights": lines.heights, "clear": round(lines.clear, 2)}
    return Measured(value, min(1.0, lines.clear / (2 * CLEAR)), courses_of(lines))


def _regions(f: Facts) -> Measured:
    r = f.regions
    value = {"two": r.two, "apart": round(r.apart, 3), "together": round(r.together, 3), "smaller": round(r.smaller, 3)}
    return Measured(value, r.apart, "two textures side by side" if r.two else "one texture")


def _symmetry(f: Facts) -> Measured:
    kept = list(f.symmetry)
    said = "keeps its look in all isometries" if len(kept) == 8 else f"keeps its look in isometries {kept}"
    most = SLACK[0] / SLACK[1]
    tie = _tie(f.turned, most, f"quarter turns lay halves {f.turned:.2f} times as far apart, and {most:.2f} may be")
    return Measured(kept, 0.5 if f.regions.two else 1.0, (said if len(kept) > 1 else "upright only") + tie)


def _border(f: Facts) -> Measured:
    worst = max(f.border.rows, f.border.columns)
    said = "continues across its borders" if f.border.closed else "does not continue across its borders"
    value = {"rows": _finite(f.border.rows), "columns": _finite(f.border.columns), "closed": f.border.closed}
    return Measured(value, 1.0 if worst > 2 or worst < 1 else 0.5, said)


def _finite(value: float) -> float | None:
    return round(value, 3) if value < 1e9 else None


def _light(f: Facts) -> Measured:
    said = f"a slope, {f.light.factor:.1f} times brighter on one side" if f.light.strong else "no strong slope"
    return Measured({"share": round(f.light.share, 3), "factor": round(f.light.factor, 3)}, f.light.share, said)


def _size(f: Facts) -> Measured:
    value = {"enlargement": round(f.enlargement, 2), "across": round(f.across, 2)}
    said = f"{f.across:.1f} elements across, grown to {f.enlargement:.1f} times the area"
    if f.element.found:
        said += _tie(f.elements, BOUNDS.few, f"{f.elements:.1f} in all, and fewer than {BOUNDS.few} are few")
    return Measured(value, f.element.found / 12, said)


def _kind(f: Facts) -> Measured:
    base = f.exemplar.base
    kind = "names" if f.names else base.kind.value
    said = {"names": "a few exact colours in patches", Kind.NORMAL.value: "directions"}.get(kind, kind)
    deep = str(base.pixels.dtype)
    return Measured(kind, 1.0, f"{said}, {base.channels} channels of {deep}{' with opacity' if base.alpha else ''}")


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
