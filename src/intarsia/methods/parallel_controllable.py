"""Parallel controllable texture synthesis: coordinates upsampled from coarse to fine, jittered, and corrected.

Lefebvre and Hoppe, "Parallel controllable texture synthesis", SIGGRAPH 2005, and "Appearance-space texture synthesis",
SIGGRAPH 2006. The variant of a memorandum of 2008 is a method of its own, correction-2008.

Every pixel is a function of its coordinates, the seed and the parameters: any window of an endless texture can be
computed on its own.

Departures: distances are integers; the 32 numbers of a neighbourhood are compared in full, not projected again; jumps
(candidates of the k-coherence search) are searched in a kd-tree and ranked exactly, on coarse levels for every (h /
2)-th pixel, where h is the spacing of the level in px; the jumps of a pixel are those of its different continuations,
not those of its neighbours, then shifted; an exemplar that is not toroidal is mirrored beyond its borders for
comparisons only: no pixel at the border is a candidate; for a piece as large as half the exemplar several places are
drawn, and the one that repeats its neighbours least is used.

Cost: for each pixel, pass and level about five comparisons of 32 numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from .. import methods
from ..foundation import ParameterError
from ..foundation.field import Field
from ..foundation.params import AUTO, Steps, Weights, functions_of, param

if TYPE_CHECKING:
    from ..foundation.geometry import Box
    from ..model import Exemplars
    from ..model.canvas import Canvas


@dataclass(frozen=True)
class ParallelControllable(methods.EndlessBase):
    """Parallel controllable synthesis: refine an endless map from coarse to fine by random jitter and correction.

    Fields are numbers, gray pictures, functions of (y, x) or Field.

    Parameters
    ----------
    jitter : float or tuple of float, optional
        How far pixels move at random on each level, 0 to 1 in spacings of that level, the finest first, the last
        for all coarser ones; default: little on fine levels, 1 from half the exemplar on.
    jitter_output, jitter_exemplar : field, optional
        Factor of the jitter, 0 to 1, over the output, and by the place in the exemplar; default: 1.
    keep_lattice : {"auto", "on", "off"}
        Whether pixels move by whole periods of the lattice only, but on the levels of 1 and 2 px.
    lattice : one or two vectors (x, y), px, optional
        The periods of the texture; default: found in the exemplar.
    kappa : float or "inf"
        A jump counts as so many times farther than a continuation, 1 to 1000, default 2.
    passes : int
        How often every pixel of a level is corrected, 0 to 8, default 2.
    feature : field or "edges", optional
        Outlines to keep: the edges of the exemplar, or those of a mask over it; default: none.
    feature_weight : float
        How much the distance to the outlines counts, 0 to 100, default 1: as much as all colours.
    pin : tuple of (x, y, x, y, radius), px, optional
        Places of the exemplar to show at places of the output.
    angle, zoom : field
        Rotation, -180 to 180 degrees counterclockwise, default 0, and magnification, 0.25 to 4, default 1.
    channel_weights : tuple of float, optional
        How much each channel counts; default: 0.3, 0.59, 0.11 for red, green, blue.

    Raises
    ------
    ParameterError
        for a value out of range, or a lattice with ``keep_lattice="off"``.
    """

    slug = "parallel-controllable"
    paper = "Lefebvre and Hoppe 2005, 2006"
    summary = "coarse to fine, endless: any window alone, randomness set for each scale"
    engine = "intarsia.corrections.parallel_controllable"
    supports = methods.abilities("wrap", "mask", "guide", "window")

    jitter: float | tuple[float, ...] | None = param(
        AUTO, "levels", "how far pixels move at random on each level, in steps of that level (1, 2, 4, ... px), the "
        "finest first, the last for all coarser ones; automatic: 0,0,0.1,0.2, 0.2 on up to a quarter of an "
        "element (of clouds, and with keep_lattice, feature, angle or zoom: on all), then 0, and 1 from half the "
        "exemplar on",
        low=0, high=1,
    )  # fmt: skip
    jitter_output: Field | float | None = param(
        AUTO, "field", "factor of the jitter over the output, black none, white all of it; automatic: all",
        low=0, high=1, over="output",
    )  # fmt: skip
    jitter_exemplar: Field | float | None = param(
        AUTO, "field", "factor of the jitter by the place in the exemplar that pixels come from, so that black parts "
        "are kept intact; automatic: all", low=0, high=1, over="exemplar",
    )  # fmt: skip
    keep_lattice: str = param(
        "auto", "choice", "on: pixels move by whole periods of the lattice only, but on the levels of 1 and 2 px, so "
        "that courses and weaves stay in step; auto: where there is a lattice, and no guide",
        choices=("auto", "on", "off"),
    )  # fmt: skip
    lattice: Steps | None = methods.lattice_vectors(
        "the lattice vectors of the texture, if pixels keep to it; automatic: found in the exemplar"
    )
    kappa: float | str = param(
        2, "price", "a jump counts as so many times farther than a continuation, distances not squared; 1: no "
        "preference, inf: never jump",
        low=1, high=1000,
    )  # fmt: skip
    passes: int = param(2, "int", "how often every pixel of a level is corrected", low=0, high=8)
    feature: Field | str | None = param(
        AUTO, "picture", "outlines to keep: the edges of the picture, or those of what is white in a mask of yours; "
        "how far they are is compared as well; automatic: none",
        low=0, high=1, over="exemplar", choices=("edges",),
    )  # fmt: skip
    feature_weight: float = param(
        1, "float", "with feature: how much the distance to the outlines counts; 1: as much as all the colours", low=0,
        high=100,
    )  # fmt: skip
    pin: tuple[tuple[int, ...], ...] | None = param(
        AUTO, "pins", "places of the exemplar to show at places of the output, within a radius, cut along a seam; "
        "automatic: nothing", low=-(1 << 40), high=1 << 40, unit="px",
    )  # fmt: skip
    angle: Field | float = param(
        0, "field", "rotation of the texture, counterclockwise; pixels are then interpolated",
        low=-180, high=180, unit="degrees", over="output",
    )  # fmt: skip
    zoom: Field | float = param(
        1, "field", "magnification of the texture; pixels are then interpolated",
        low=0.25, high=4, over="output",
    )  # fmt: skip
    channel_weights: Weights = methods.channel_weights()

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lattice is not AUTO and self.keep_lattice == "off":
            raise ParameterError("keep_lattice=off moves pixels by no lattice; leave the lattice out, or turn it on.")

    @property
    def exact(self) -> bool:
        """Whether pixels are exact copies: not if the texture is rotated or scaled."""
        return (self.angle, self.zoom) == (0, 1)

    def asked(self, exemplars: Exemplars, where: Canvas | Box) -> dict[str, str]:
        """Return for each function among the parameters a hash of its values at all places that a picture needs."""
        found: dict[str, str] = methods.engine_of(self).asked(self, exemplars, where) if functions_of(self) else {}
        return found
