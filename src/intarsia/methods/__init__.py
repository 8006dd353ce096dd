"""Synthesis methods, one file each: their interface, the list of methods, and shared parameters.

Imports nothing heavy: listings must be quick.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import cache, partial
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, Self

from ..foundation import InputError, ParameterError, Record, called
from ..foundation.blend import Blend
from ..foundation.geometry import Wrap
from ..foundation.params import AUTO, Parameter, check, extent, param, parameters

if TYPE_CHECKING:
    from ..foundation.geometry import Box
    from ..foundation.run import Run
    from ..model import Exemplar, Exemplars
    from ..model.canvas import Canvas
    from ..model.sourcemap import SourceMap

FARTHEST = 1 << 40
"""Largest distance, in px along each axis, of windows of an endless plane from the origin."""


class Ability(StrEnum):
    """What a method supports beyond filling an empty, aperiodic canvas; a test checks every claim."""

    WRAP = "wrap"  # a periodic canvas
    START = "start"  # a canvas that is partly filled
    MASK = "mask"  # exemplars with pixels that must not be sampled
    GUIDE = "guide"  # labels or a target picture
    ISOMETRIES = "isometries"  # mirrored and turned pieces
    SEVERAL = "several"  # more than one exemplar
    WINDOW = "window"  # random access: any window of an endless plane is computed on its own


def abilities(*names: str) -> frozenset[Ability]:
    """Return the abilities of these names."""
    return frozenset(map(Ability, names))


class Method(Protocol):
    """A synthesis method: a frozen dataclass of its parameters that fills a canvas."""

    @property
    def slug(self) -> str:
        """Its name in listings and recipes."""

    @property
    def paper(self) -> str:
        """The papers that it follows, short."""

    @property
    def summary(self) -> str:
        """What it does, in a few words."""

    @property
    def supports(self) -> frozenset[Ability]:
        """Its abilities."""

    @property
    def blend(self) -> Blend:
        """How its pieces are blended by default; depends on its parameters alone."""

    def resolved(self, exemplars: Exemplars, canvas: Canvas) -> Self:
        """Return the method with every automatic parameter decided.

        Raises ParameterError, InputError or MethodError if it cannot serve exemplars and canvas.
        """

    def synthesize(self, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
        """Fill the canvas and return the map; the same arguments give the same map, whatever `run` is."""


class Traits(NamedTuple):
    """Optional attributes of a method, with their defaults.

    exact : its maps name whole pixels, neither scaled nor rotated.
    pitch, footprint : (rows, columns) px from patch to patch, and of the exemplar that a patch needs; None: no patches.
    hangs : placement of patches at the borders, as in :func:`intarsia.foundation.geometry.patch_starts`.
    channel_weights, isometries, keep_lattice : as the parameters of these names.
    asked : returns, by name, for parameters that are functions a hash of their values over a canvas or a box.
    """

    exact: bool = True
    pitch: tuple[int, int] | None = None
    footprint: tuple[int, int] | None = None
    hangs: int | None = None
    channel_weights: tuple[float, ...] | None = None
    isometries: str | tuple[int, ...] = "none"
    keep_lattice: str = "on"
    asked: Callable[[Exemplars, Canvas | Box], Mapping[str, str]] = lambda exemplars, where: {}


def traits(method: Method) -> Traits:
    """Return the optional attributes of a method, with defaults for those that it does not have."""
    return Traits(**{name: getattr(method, name) for name in Traits._fields if hasattr(method, name)})


def recipe_settings(
    method: Method, exemplars: tuple[Exemplar, ...] = (), where: Canvas | Box | None = None
) -> Record:
    """Return the parameters as saved in recipes: JSON, extents x before y, tuples as lists.

    Functions are given by name, and for a picture (`where`) also by a hash of their values.
    """
    out: Record = {}
    for p in parameters(method):
        value = getattr(method, p.name)
        if isinstance(value, tuple):
            value = list(reversed(value)) if p.kind == "extent" else list(value)
        out[p.name] = getattr(value, "as_recipe", value)
    for name, digest in ({} if where is None else traits(method).asked(exemplars, where)).items():
        out[name] |= {"sha256": digest}
    return out


RENAMED = {
    "boundary_slack": "boundary_tolerance", "heights": "course_heights", "level": "even_tone",
    "slack": "lattice_tolerance", "snap": "keep_lattice", "structure": "edge_weight", "usage": "repeat_penalty",
}  # fmt: skip
"""Name of a parameter or option in version 0.1 -> its name now; version 0.2 accepts both."""


def renamed(given: Mapping[str, Any]) -> Record:
    """Return parameters or options under the names that they have now."""
    return {RENAMED.get(name, name): value for name, value in given.items()}


def method_of(slug: str, settings: Record) -> Method:
    """Return a method from its parameters as saved in recipes; ParameterError if they are invalid."""
    settings = renamed(settings)
    extents = {p.name for p in parameters(method_class(slug)) if p.kind == "extent"}
    flipped = {n: v[::-1] if n in extents else v for n, v in settings.items() if isinstance(v, list)}
    return make(slug, settings | {n: tuple(v) for n, v in flipped.items()})


def keeps_lattice(method: Method) -> bool:
    """Whether a method aligns its pieces to a lattice."""
    return any(p.name == "lattice" for p in parameters(method)) and traits(method).keep_lattice == "on"


class MethodBase:
    """Base class of methods: checks parameters, copies exactly, and delegates to an engine.

    Methods of other packages need not inherit from it.

    ``engine``: name of the module whose functions `resolved`, `synthesize` and `window` implement those of the method;
    empty for a method that implements them itself. They get the method as first argument, `synthesize` a resolved one.
    """

    engine: ClassVar[str] = ""

    def __post_init__(self) -> None:
        check(self)

    @property
    def blend(self) -> Blend:
        """Exact copies."""
        return Blend(0)

    def resolved(self, exemplars: Exemplars, canvas: Canvas) -> Self:
        """Return the method with automatic parameters decided by the engine; itself without an engine."""
        found: Self = engine_of(self).resolved(self, exemplars, canvas) if self.engine else self
        return found

    def synthesize(self, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
        """Return the map made by the engine."""
        method = self.resolved(exemplars, canvas)
        smap: SourceMap = engine_of(method).synthesize(method, exemplars, canvas, seed, run)
        return smap


class EndlessBase(MethodBase):
    """Base class of methods whose engine makes single windows of an endless plane."""

    def window(self, exemplars: Exemplars, box: Box, seed: int, run: Run) -> SourceMap:
        """Return the map of a box of the endless plane, made by the engine."""
        smap: SourceMap = engine_of(self).window(self, exemplars, box, seed, run)
        return smap


class WindowMethod(Method, Protocol):
    """A method with the ability WINDOW: any window of its map can be computed on its own."""

    def window(self, exemplars: Exemplars, box: Box, seed: int, run: Run) -> SourceMap:
        """Return the map of a box of the endless plane, at most FARTHEST px away; it depends on nothing outside.

        A plain canvas of H x W px, filled by `synthesize`, is the box (0, 0, H, W).
        """


REFUSED = {
    Ability.WRAP: "cannot wrap the output; drop wrap",
    Ability.START: "cannot continue a start map; drop it",
    Ability.GUIDE: "cannot follow a guide; drop it",
    Ability.MASK: "cannot avoid masked pixels; drop the mask",
    Ability.SEVERAL: "grows from one exemplar; give one",
}
"""Messages for abilities that a method does not have, in order of precedence."""


def needed(exemplars: Exemplars, canvas: Canvas) -> frozenset[Ability]:
    """Return the abilities that exemplars and canvas need."""
    asked = {
        Ability.WRAP: canvas.wrap is not Wrap.NONE,
        Ability.START: canvas.start is not None,
        Ability.GUIDE: canvas.guide is not None,
        Ability.MASK: any(e.usable is not None for e in exemplars),
        Ability.SEVERAL: len(exemplars) > 1,
    }
    return frozenset(ability for ability, yes in asked.items() if yes)


def check_start(start: SourceMap, exemplars: Exemplars) -> None:
    """Raise InputError if a start map does not point into the given exemplars, at whole pixels."""
    if not start.exact:
        raise InputError(
            "the map's pieces are turned, scaled or moved by fractions of a pixel (frame, sub), which no method can "
            "continue or repair; give one without."
        )
    if [s.shape for s in start.sources] != [e.shape for e in exemplars]:
        raise InputError(
            "the start map was made of exemplars of other sizes; give the same exemplars in the same order."
        )
    start.check_sources()


def check_abilities(method: Method, exemplars: Exemplars, canvas: Canvas) -> None:
    """Raise ParameterError if exemplars or canvas need an ability that the method does not have."""
    missing = needed(exemplars, canvas) - method.supports
    for ability, words in REFUSED.items():
        if ability in missing:
            raise ParameterError(f"{method.slug} {words}, or choose another method.")


METHODS = {
    "image-quilting": ("methods.image_quilting", "ImageQuilting"),
    "patch-sampling": ("published.multrus2003.patch_sampling", "PatchSampling"),
    "graphcut": ("methods.graphcut", "Graphcut"),
    "segment-based": ("published.segments.segment_based", "SegmentBased"),
    "near-regular": ("methods.near_regular", "NearRegular"),
    "gap-filling": ("published.lopez_recas2011.gap_filling", "GapFilling"),
    "best-tile": ("methods.best_tile", "BestTile"),
    "random-tiling": ("methods.random_tiling", "RandomTiling"),
    "repeat": ("methods.repeat", "Repeat"),
    "parallel-controllable": ("methods.parallel_controllable", "ParallelControllable"),
    "raster-quilting": ("published.robinson2004.raster_quilting", "RasterQuilting"),
    "efros-leung": ("published.pixels.efros_leung", "EfrosLeung"),
    "wei-levoy": ("published.pixels.wei_levoy", "WeiLevoy"),
    "ashikhmin": ("published.pixels.ashikhmin", "Ashikhmin"),
    "correction-2008": ("published.correction2008.correction_2008", "Correction2008"),
}
"""Slug -> (module below the package, name of the class), in the order of the listings."""


PRESETS = ("multrus2003", "lopez_recas2011", "robinson2004", "segments", "correction2008")
"""Documents with presets of all settings: packages of `published`."""


def preset(document: str) -> dict[str, str]:
    """Return the preset of a document: options of grow, with values as on the command line."""
    found: dict[str, str] = importlib.import_module(f"..published.{document}", __package__).PRESET
    return dict(found)


def engine_of(method: MethodBase) -> Any:
    """Return the engine module of a method, imported at the first call."""
    return importlib.import_module(method.engine)


def method_class(slug: str) -> type[Any]:
    """Return the class of the method named `slug`."""
    if slug not in METHODS:
        raise ParameterError(f"method={slug} is unknown; choose one of {', '.join(METHODS)}.")
    module, name = METHODS[slug]
    cls: type[Any] = getattr(importlib.import_module(f"..{module}", __package__), name)
    return cls


def parameters_of(slug: Any) -> dict[str, Parameter]:
    """Return the parameters of a method by name; empty if `slug` is no method, or "auto"."""
    known = isinstance(slug, str) and slug in METHODS
    return {p.name: p for p in parameters(method_class(slug))} if known else {}


@cache
def known_parameters(slug: str | None = None) -> dict[str, tuple[Parameter, list[str]]]:
    """Return all parameters by name with the methods that have them; only those of `slug` if it is a method."""
    found: dict[str, tuple[Parameter, list[str]]] = {}
    for one in (slug,) if slug in METHODS else METHODS:
        for name, p in parameters_of(one).items():
            found.setdefault(name, (p, []))[1].append(str(one))
    return found


def check_method(given: Any) -> Method:
    """Return the method; ParameterError if it is none, such as a class of methods."""
    if isinstance(given, type) or not (hasattr(given, "resolved") and hasattr(given, "synthesize")):
        able = isinstance(given, type) and hasattr(given, "resolved")
        means = f"{given.__name__}()" if able else "a method, or its name"
        raise ParameterError(f"method={called(given)} is no method; give {means}, or 'auto'.")
    method: Method = given
    return method


def make(slug: str, values: Record) -> Method:
    """Return the method `slug` with the given parameters; ParameterError for any that it does not have."""
    cls = method_class(slug)
    known = [p.name for p in parameters(cls)]
    for name in values:
        if name not in known:
            raise ParameterError(f"{name}: {slug} has no such parameter; it has {', '.join(known) or 'none'}.")
    method: Method = cls(**values)
    return method


patch_side = partial(
    param, AUTO, "extent",
    "side of the copied square, overlaps included; automatic: the size of the texture's elements",
    low=1, high=1 << 16, unit="px",
)  # fmt: skip
channel_weights = partial(
    param, AUTO, "weights", "how much each channel counts; automatic: 0.3, 0.59, 0.11 for red, green, blue",
    low=0, high=1e6,
)  # fmt: skip
edge_weight = partial(
    param, 1.0, "float", "how much outlines and slow colour count beside colour; 0: colour alone", low=0, high=4
)
poses = partial(
    param, "none", "isometries", "which mirrored and turned patches may be used; auto: those that keep the look"
)
repeat_penalty = partial(param, 0.05, "float", "price of using a patch again, in usual distances", low=0, high=100)
lattice_vectors = partial(param, AUTO, "vectors", low=-65536, high=65536, unit="px")
search_ways = partial(
    param, "fast", "choice", "short-list at reduced resolution, or at full resolution", choices=("fast", "exact")
)
cut_cost = partial(
    param, kind="choice", help="cost of a cut: colour difference, that divided by the gradient, or sharp: its square, "
    "truncated, so that many faint steps are cheaper than a strong one",
    choices=("difference", "gradient", "sharp"),
)  # fmt: skip
layout = partial(
    param, "spread", "choice", "spread: overlaps widen evenly, so that patches end at the border; raster: patch and "
    "overlap as they are given, cropped at the right and lower border (where the output does not wrap)",
    choices=("spread", "raster"),
)  # fmt: skip
boundary_patch = partial(
    param, AUTO, "int", "side of the patches along boundaries of painted labels; automatic: half; 0: like all others",
    low=0, high=1 << 16, unit="px",
)  # fmt: skip
boundary_poses = partial(
    param, AUTO, "isometries", "poses that patches on such boundaries may have besides; automatic: all of a square"
)
boundary_tolerance = partial(
    param, AUTO, "int", "how far a label may reach over such a boundary, else it is cut there; automatic: half a patch",
    low=0, high=1 << 16, unit="px",
)  # fmt: skip


class CutSquares(MethodBase):
    """Base class of methods with overlapping square patches: attributes that follow from `patch` and `overlap`."""

    patch: int | tuple[int, int] | None
    overlap: int | tuple[int, int] | None
    layout: str = "spread"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.patch is AUTO or self.overlap is AUTO:
            return
        for side, overlap in zip(extent(self.patch), extent(self.overlap), strict=True):
            if overlap >= side:
                raise ParameterError(f"overlap={overlap} is not below patch={side} px; choose 0 to {side - 1} px.")

    @property
    def pitch(self) -> tuple[int, int]:
        """Step from patch to patch, (rows, columns) px; meaningful once patch and overlap are decided."""
        patch, overlap = extent(self.patch or 0), extent(self.overlap or 0)
        return patch[0] - overlap[0], patch[1] - overlap[1]

    @property
    def hangs(self) -> int | None:
        """0: patches at their exact pitch from pixel 0, cropped at the border; None: spread to end at the border."""
        return 0 if self.layout == "raster" else None

    @property
    def footprint(self) -> tuple[int, int]:
        """Rows and columns of the exemplar that a patch needs."""
        return extent(self.patch or 0)
