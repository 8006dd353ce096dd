"""Analysis of an exemplar: lattice, element size, segments, illumination gradient, and a suggested method.

    found = ia.analyze("weave.png")
    found.suggested.method, found.suggested.parameters
    ia.write("seen.png", found.overlay())
    ia.write("tile.png", found.best_tile().planes["albedo"])
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.elements import ElementSize
from ..analysis.illumination import Illumination
from ..choosing.auto import Auto
from ..choosing.facts import Facts
from ..foundation import OVERLAYS, MethodError, ParameterError, Record, said
from ..foundation.arrays import Pair
from ..foundation.blend import Blend
from ..foundation.geometry import UNIT, Wrap
from ..foundation.run import Run
from ..lattice import vectors_of
from ..lattice.decision import Lattice, Lattices
from ..methods import make
from ..model import Exemplar
from ..model.canvas import Canvas
from ..model.image import Plane
from ..model.sourcemap import SourceMap
from ..regular.rectify import Rectification
from ..regular.tile_search import BAND, Tiling, periods_along
from ..rendering.render import render
from ..segments import Segments, segments
from ..synthesis import ExemplarLike, as_exemplars

CELLS = 8  # most periods in a tile; oblique lattices need more for a rectangle


@dataclass(frozen=True)
class Suggestion:
    """A suggested method for an exemplar, with the reasons.

    Attributes
    ----------
    method : str
        Name of the method.
    parameters : dict
        Its parameters that differ from the defaults; vectors are (x, y) in px.
    flatten : bool
        Whether uneven illumination should be removed first (:func:`flattened`).
    why : tuple of str
        Reasons and warnings, in sentences.
    rule : str
        Name of the rule of the automatic choice that decided.
    """

    method: str
    parameters: Record
    flatten: bool
    why: tuple[str, ...]
    rule: str = ""


@dataclass(frozen=True, eq=False)
class TilePicture:
    """The best tile as pictures: a rectangle of whole periods that can be repeated side by side.

    Attributes
    ----------
    corner : (x, y)
        Its origin in the exemplar, px.
    cost : int
        Sum of squared differences between its opposite borders, in feature units.
    planes : dict of str to Plane
        One picture for every plane of the exemplar, packed maps as one.
    """

    corner: Pair
    cost: int
    planes: dict[str, Plane]


@dataclass(frozen=True, eq=False)
class Analysis:
    """The results of :func:`analyze`.

    Attributes
    ----------
    exemplar : Exemplar
        The exemplar that was analysed.
    lattices : Lattices
        The accepted lattice, if there is one, and all candidates.
    elements : ElementSize
        The size of its elements, px.
    light : Illumination
        The strength of its uneven illumination.
    suggested : Suggestion
        The method and parameters that the automatic choice would take.
    straight : (Rectification, Lattice) or None
        The rectification of its courses and the lattice after it, if the confidence of that lattice is much higher.
    """

    exemplar: Exemplar
    lattices: Lattices
    elements: ElementSize
    light: Illumination
    suggested: Suggestion
    straight: tuple[Rectification, Lattice] | None = None

    def __repr__(self) -> str:
        kind = "no lattice" if self.lattice is None else f"a {self.lattice.kind} lattice"
        return f"<findings: {self.exemplar.name}, {kind}, elements of {self.elements.size} px, {self.suggested.method}>"

    @property
    def segments(self) -> Segments:
        """Its segments and the groups of similar ones, with patch size and overlap region for the chosen group."""
        return segments(self.exemplar)

    @property
    def lattice(self) -> Lattice | None:
        """The accepted lattice; None if there is none."""
        return self.lattices.accepted

    def overlay(self, kind: str = "lattice") -> Plane:
        """Return the exemplar with its lattice or its segments drawn over it, as an 8-bit RGB plane.

        `kind`: "lattice" (default) or "segments"; ParameterError for others, MethodError if it has no lattice.
        """
        if not isinstance(kind, str) or kind not in OVERLAYS:
            raise ParameterError(f"overlay={said(kind)} is unknown; choose one of {', '.join(OVERLAYS)}.")
        from .drawings import lattice_lines, segment_overlay

        if kind == "segments":
            return Plane(segment_overlay(self.exemplar, self.segments))
        return lattice_lines(self.exemplar, self.found_lattice("overlay"))

    def found_lattice(self, wanted: str) -> Lattice:
        """Return the lattice; MethodError, naming what is `wanted` and a method that needs none, if there is none."""
        if self.lattice is not None:
            return self.lattice
        best = max((one.confidence for one in self.lattices.ranked), default=0.0)
        raise MethodError(
            f"{self.exemplar.name} has no lattice (confidence {best:.2f}), so there is no {wanted}; grow it with "
            f"method {self.suggested.method}."
        )

    def best_tile(self, band: int = BAND) -> TilePicture:
        """Return the rectangle of whole periods around the period whose opposite borders, `band` px wide, differ least.

        Raises MethodError if there is no lattice or such rectangle, ParameterError if `band` is not 1 to 256.
        """
        lattice = vectors_of(self.found_lattice("best tile"))
        make("best-tile", {"lattice": lattice, "band": band})  # raises if they are out of range
        tiling = Tiling.of(lattice, None, band, self.exemplar)
        box = _rectangle(tiling, self.exemplar)
        if box is None:
            wanted = f"no rectangle of at most {CELLS} periods of {self.exemplar.name} repeats"
            raise MethodError(f"{wanted}; grow it with method best-tile.")
        y, x = tiling.tile.anchor
        yx = tiling.layout(Canvas(*box, Wrap.BOTH)).window(y, x, *box)
        smap, drawn = SourceMap(yx, None, None, (self.exemplar.source,), Wrap.BOTH, Blend(0)), (self.exemplar,)
        planes = {name: render(drawn, smap, name, Blend(0), None, Run()) for name in self.exemplar.pictures}
        return TilePicture((x, y), tiling.tile.cost, planes)

    def as_dict(self) -> Record:
        """Return the results for JSON: sizes and vectors x before y, in px."""
        e = self.exemplar
        return {
            "exemplar": {"name": e.name, "size": [e.width, e.height], "sha256": e.digest},
            "lattice": None if self.lattice is None else _as_dict(self.lattice),
            "candidates": [{**_as_dict(one), "verdict": one.verdict} for one in self.lattices.ranked],
            "reason": self.lattices.reason,
            "straightened": None if self.straight is None else _bent(*self.straight),
            "feature_size": self.elements.size,
            "elements": {
                "size": [self.elements.width, self.elements.height],
                "found": self.elements.found,
            },
            "segments": _grouped(self.segments),
            "light": _rounded(self.light, share=3, factor=2) | {"strong": self.light.strong},
            "suggested": {
                "method": self.suggested.method,
                "parameters": {
                    k: [list(v) for v in value] if k == "lattice" else value
                    for k, value in self.suggested.parameters.items()
                },
                "flatten": self.suggested.flatten,
                "why": list(self.suggested.why),
                "rule": self.suggested.rule,
            },
        }


def analyze(exemplar: ExemplarLike) -> Analysis:
    """Analyse an exemplar: lattice, element (texel) size, uneven illumination, segments, and a suggested method.

    Parameters
    ----------
    exemplar : as for :func:`synthesize`
        One picture or one set of planes; all planes are used together.

    Returns
    -------
    Analysis
        Segments are computed when they are asked for.

    Raises
    ------
    InputError
        if it cannot be read, or has no usable pixels.
    """
    found = as_exemplars([exemplar])[0]
    facts = Facts([found], Canvas(2 * found.height, 2 * found.width))
    return Analysis(found, facts.lattices, facts.element, facts.light, _suggested(facts), facts.straight)


def _as_dict(one: Lattice) -> Record:
    return {
        "vectors": [list(v) for v in vectors_of(one)],
        "periods": [round(math.hypot(*v) / UNIT, 2) for v in one.vectors],
        "angles": [round(math.degrees(math.atan2(y, x)), 1) % 360 for y, x in one.vectors],  # 0 to the right, 90 down
        **_rounded(one, confidence=4, contrast=4, points=0, residual=3),
        "reasons": list(one.reasons),
    }


def _rounded(found: Any, **places: int) -> Record:
    """Return attributes by name, rounded to the given places."""
    return {name: round(getattr(found, name), digits) for name, digits in places.items()}


def _bent(straight: Rectification, lattice: Lattice) -> Record:
    """Return slant, convergence and bow of courses, and the lattice after rectification, for JSON."""
    vectors = [list(v) for v in vectors_of(lattice)]
    return _rounded(straight, slant=4, converging=3, off=2) | {"vectors": vectors} | _rounded(lattice, confidence=4)


def _grouped(found: Segments) -> Record:
    """Return segments, groups with shares of the area, patch size and overlap of the chosen group, px, for JSON."""
    areas = np.bincount(found.group_map[found.group_map >= 0], minlength=int(found.groups.max(initial=-1)) + 1)
    counts = np.bincount(found.groups, minlength=len(areas))
    whole = max(int(areas.sum()), 1)
    groups = [{"segments": int(n), "share": round(int(a) / whole, 4)} for n, a in zip(counts, areas, strict=True)]
    return {
        "count": len(found.groups),
        "groups": groups,
        "chosen": found.chosen,
        "patch": found.patch,
        "zone": found.zone,
        "rule": found.rule.value,
        "why": found.why,
    }


def _suggested(facts: Facts) -> Suggestion:
    """Return the choice of ``method="auto"``, by the table of rules."""
    choice = Auto().decide(facts)
    values = {k: v for k, v in choice.decided.items() if k != "overlap"}
    flatten = not facts.constant and facts.light.strong and not facts.exemplar.toroidal
    why = [*choice.why, *(w[0].upper() + w[1:] for w in choice.warnings)]
    return Suggestion(choice.method.slug, values, flatten, tuple(why), choice.rule)


def _rectangle(tiling: Tiling, exemplar: Exemplar) -> Pair | None:
    """Return the least (height, width), px, of a rectangle of whole periods; None if it holds more than CELLS."""
    sides = exemplar.shape
    found = [periods_along(tiling.vectors, axis, side) for axis, side in enumerate(sides)]
    if not (found[0] and found[1]):
        return None
    height, width = found[0][0][2], found[1][0][2]
    (p, q), (r, s) = tiling.vectors
    return (height, width) if height * width * UNIT**2 <= (CELLS + 0.5) * abs(p * s - q * r) else None
