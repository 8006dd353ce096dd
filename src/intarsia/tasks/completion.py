"""Image completion: extension (outpainting) and hole filling (inpainting) of pictures by texture synthesis.

The picture is a start map with holes, which is filled by any method that can continue one.

    wide = ia.extend("wall.png", right=200, top=50)
    whole = ia.heal("wall.png", mask)                      # mask: True where the picture is to be replaced
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.defect_rim import defect_rim
from ..analysis.features import features
from ..choosing.auto import Auto
from ..foundation import (
    AUTO_METHOD,
    MARGIN,
    InputError,
    IntarsiaError,
    ParameterError,
    Record,
    chosen,
    expect,
    ndimage,
    whole_within,
)
from ..foundation.arrays import Mask, marks
from ..foundation.blend import Blend
from ..foundation.geometry import Wrap
from ..foundation.params import AUTO, values_of
from ..foundation.run import Run, run_of
from ..methods import METHODS, Method, check_abilities, make, parameters_of, traits
from ..model import Exemplar, Exemplars, NotFiniteError
from ..model.canvas import Canvas
from ..model.image import MAX_SIDE
from ..model.sourcemap import HOLE, UPRIGHT, Source, SourceMap, identity
from ..seams import energy
from ..search import element_patch, patch_with_supply
from ..synthesis import ExemplarLike, Plan, Scene, Synthesis, as_exemplars, check_between, filled, named
from .repair import refined

LEAST_PATCH = 12  # px: least side of the patches that fill holes
ROOM = 2  # times the thickness of a hole: least side of a patch that covers it together with its surroundings
SIZES = (1.0, 0.75, 0.5, 0.375)  # patch sizes, relative to the automatic one, tried on holes that one patch covers
PIXELWISE = "efros-leung"  # the method that synthesises the edge of a hole again pixel by pixel


@dataclass(frozen=True)
class Margins:
    """Widths of the margins by which :func:`extend` enlarges a picture.

    Parameters
    ----------
    left, right, top, bottom : int
        px, at least 0, default 0.

    Raises
    ------
    ParameterError
        if a width is no whole number of at least 0, or all are 0.
    """

    left: int = 0
    right: int = 0
    top: int = 0
    bottom: int = 0

    def __post_init__(self) -> None:
        for side in ("left", "right", "top", "bottom"):
            object.__setattr__(self, side, whole_within(side, getattr(self, side), 0))
        if not (self.left or self.right or self.top or self.bottom):
            raise ParameterError("no side is extended; give at least one of left, right, top and bottom, in px.")


def extended(sources: Sequence[Source], number: int, margins: Margins) -> SourceMap:
    """Return the identity map of exemplar `number` surrounded by empty margins."""
    old = identity(sources, number)
    height, width = old.height + margins.top + margins.bottom, old.width + margins.left + margins.right
    Canvas(height, width)  # raises if it is too large
    yx, which = np.zeros((height, width, 2), np.int32), np.full((height, width), HOLE, np.uint8)
    inside = slice(margins.top, margins.top + old.height), slice(margins.left, margins.left + old.width)
    yx[inside], which[inside] = old.yx, number
    return replace(old, yx=yx, which=which)


def with_hole(smap: SourceMap, holes: Mask) -> SourceMap:
    """Return a map with holes where a mask (H, W) of its size is True."""
    empty: Record = {"yx": 0, "pose": 0, "frame": UPRIGHT, "sub": np.float32(0), "which": HOLE}
    parts = smap.arrays | {"which": smap.numbers}
    for name, part in parts.items():
        parts[name] = np.where(holes.reshape(*holes.shape, *[1] * (part.ndim - 2)), empty[name], part)
    return replace(smap, **parts)


def dilated_hole(hole: ArrayLike, px: int, wrap: Wrap = Wrap.NONE) -> Mask:
    """Return a mask dilated by `px` (Chebyshev distance), around the border along periodic axes."""
    side = 2 * whole_within("grow", px, 0, MAX_SIDE) + 1
    modes: list[Any] = ["wrap" if closed else "constant" for closed in wrap.closed]
    return ndimage.maximum_filter(marks(hole, "the hole's mask"), side, mode=modes)


def extension(
    picture: Exemplar, margins: Margins, donors: Exemplars = (), wrap: Wrap = Wrap.NONE
) -> Scene:
    """Return the scene to extend a picture, from the picture itself, or from `donors` alone if there are any."""
    exemplars = exemplars_of(picture, donors)
    start = replace(extended([e.source for e in exemplars], 0, margins), wrap=wrap)
    sides = [margins.left, margins.right, margins.top, margins.bottom]
    return Scene(exemplars, Canvas(*start.shape, wrap, start), {"extend": sides})


def scene_to_heal(
    picture: Exemplar, hole: ArrayLike, donors: Exemplars = (), wrap: Wrap = Wrap.NONE, grow: int = 0
) -> Scene:
    """Return the scene to fill the holes of a picture, from its other parts, or from `donors` alone.

    The holes are enlarged by `grow` px first. Nothing is sampled from the hole, and no pixel outside of it changes.

    Raises
    ------
    InputError
        if the hole is empty, covers the whole picture, or has another size.
    """
    holes = dilated_hole(hole, grow, wrap)
    if holes.shape != picture.shape:
        raise InputError(
            f"the hole's mask is {holes.shape[-1]}x{holes.shape[0]} px, {picture.name} "
            f"{picture.width}x{picture.height}; make them equal."
        )
    described = f"{picture.name} ({picture.width}x{picture.height} px)"
    if not holes.any():
        raise InputError(f"the hole of {described} is empty; mark in white what is to be healed.")
    if holes.all():
        raise InputError(f"the hole covers all of {described}; leave something of it to continue from.")
    usable = ~holes if picture.usable is None else picture.usable & ~holes
    if not donors and not usable.any():
        raise InputError(f"nothing of {picture.name} may be used for healing; mark less, or name another source.")
    exemplars = exemplars_of(picture if donors else replace(picture, usable=usable), donors)
    start = replace(with_hole(identity([e.source for e in exemplars], 0), holes), wrap=wrap)
    return Scene(exemplars, Canvas(*start.shape, wrap, start, rim=0), {"heal": {"grow": grow}})


def exemplars_of(picture: Exemplar, donors: Exemplars) -> tuple[Exemplar, ...]:
    """Return the exemplars: the picture, which is unusable for sampling if there are donors, and the donors."""
    if not donors:
        return (picture,)
    nothing = np.zeros(picture.shape, bool)
    return replace(picture, usable=nothing), *donors




def extend(
    picture: ExemplarLike,
    margins: Margins | None = None,
    method: Method | Auto | str = AUTO_METHOD,
    *,
    sources: Sequence[ExemplarLike] = (),
    seed: int = 0,
    wrap: Wrap | str = Wrap.NONE,
    blend: Blend | None = None,
    run: Run | None = None,
) -> Synthesis:
    """Outpainting: extend a picture beyond its borders by texture synthesis.

    Parameters
    ----------
    picture : as for :func:`synthesize`
        It is unchanged except within the method's overlap of the borders that are extended.
    margins : Margins, optional
        Widths in px; default: 100 px to the right.
    method : Method, Auto or str
        A method with the ability ``start``; default ``"auto"``, which chooses one.
    sources : sequence of pictures, optional
        Exemplars of the new pixels, instead of the picture itself.
    seed : int
        0 to 2**64 - 1, default 0; the same seed gives the same bytes.
    wrap : {"none", "x", "y", "both"}
        Along which axes the result is periodic, default "none".
    blend : Blend, optional
        How pieces are blended; default: that of the method.
    run : Run, optional
        Threads, progress, cancelling.

    Returns
    -------
    Synthesis
        Of the size of the picture and its margins.

    Raises
    ------
    ParameterError
        for arguments out of range, or a method that cannot continue a start map.
    InputError
        if a picture cannot be read, or has no usable pixels.
    MethodError
        if the method cannot serve this exemplar.
    """
    expect(margins, (Margins, NoneType), "margins", "Margins, such as Margins(right=100)")
    first, donors = as_exemplars([picture])[0], donors_of(sources)
    scene = extension(first, margins or Margins(right=MARGIN), donors, chosen(Wrap, "wrap", wrap))
    return filled(scene, method, seed, blend, run)


def heal(
    picture: ExemplarLike,
    hole: ArrayLike,
    method: Method | Auto | str = AUTO_METHOD,
    *,
    sources: Sequence[ExemplarLike] = (),
    grow: int | None = None,
    seed: int = 0,
    wrap: Wrap | str = Wrap.NONE,
    run: Run | None = None,
) -> Synthesis:
    """Image completion (inpainting) by texture synthesis: fill holes; all other pixels stay, byte for byte.

    Parameters
    ----------
    picture : as for :func:`synthesize`
        Pixels in the hole may be NaN.
    hole : bool array, shape (H, W), or a gray or RGB picture of any depth
        True for pixels to replace; any number of holes. In numbers and pictures all that is not black (nor wholly
        transparent) is hole. Nothing is sampled from there.
    method : Method, Auto or str
        A method with the ability ``start``; default ``"auto"``, which chooses one. A method that is chosen or given by
        name always takes the best patch (tolerance 0).
    sources : sequence of pictures, optional
        Exemplars of the new pixels, instead of the picture itself.
    grow : int, optional
        Enlarge the hole by so many px first. Default: as far as a rim of the defect is detected outside of it.
    seed : int
        0 to 2**64 - 1, default 0; the same seed gives the same bytes.
    wrap : {"none", "x", "y", "both"}
        Along which axes the picture is periodic, default "none".
    run : Run, optional
        Threads, progress, cancelling; gets a note if a rim of the defect remains outside of the hole.

    Returns
    -------
    Synthesis
        Of the size of the picture, without feathering.

    Raises
    ------
    InputError
        if the hole is empty, covers the whole picture, or has another size; if nothing usable is left.
    ParameterError
        for arguments out of range, or a method that cannot continue a start map.
    MethodError
        if the method cannot serve this exemplar.
    """
    around = chosen(Wrap, "wrap", wrap)
    first, donors = _pictured(picture, hole, grow, around), donors_of(sources)
    scene = healed_scene(first, hole, donors, around, grow)
    asked = with_zero_tolerance(method, {}) if isinstance(method, str) and method != AUTO_METHOD else named(method)
    return fill_holes(planned_for_holes(scene, asked), seed, run_of(run))


def donors_of(sources: Sequence[ExemplarLike]) -> tuple[Exemplar, ...]:
    """Return the exemplars that new pixels are sampled from; a single one counts as a list of one."""
    alone = isinstance(sources, (str, Path, Exemplar)) or not isinstance(sources, Sequence)
    given: Any = [sources] if alone else sources
    return as_exemplars(list(given)) if len(given) else ()


def planned_for_holes(scene: Scene, method: Method | Auto, edge: int = 0) -> Plan:
    """Return the plan to fill the holes of a scene by exact copies; an automatic patch size is left undecided.

    An automatically chosen method takes the best patch (tolerance 0), unless a tolerance is given. `edge`: px along
    the edge of the holes that are synthesised again pixel by pixel; only checked here.
    """
    whole_within("edge", edge, 0)
    if edge and PIXELWISE not in METHODS:
        raise ParameterError(f"edge={edge} px need the method {PIXELWISE}, which is not there; leave it out.")
    choice = None
    if isinstance(method, Auto):
        choice = method.first_unresolved(scene.exemplars, scene.canvas)
        choice = replace(choice, method=with_zero_tolerance(choice.method.slug, dict(choice.given)))
        method = choice.method
    check_abilities(method, scene.exemplars, scene.canvas)
    check_between(method, Blend(0))
    return Plan(scene, method, Blend(0), choice)


def fill_holes(plan: Plan, seed: int, run: Run, edge: int = 0) -> Synthesis:
    """Fill the holes of a scene with patches, then `edge` px along their edge again, pixel by pixel.

    If no patch size is given and one patch covers the thickest hole, several sizes are tried, and the result with the
    least seam energy is kept. If the patches are smaller than ROOM times the thickest hole, the worst seams between
    them are refined in smaller windows, then by expansion moves.
    """
    scene = plan.scene
    if more := rim_around(scene):
        grow = scene.recipe.get("heal", {}).get("grow", 0) + more
        seen = "pixels at the edge of the hole look like a rim of what was there"
        run.notes.append(f"{seen}; --grow {grow} would cover it.")
    made = least_energy(scene, methods_to_try(scene, plan.method), seed, run)
    side = min(traits(made.method).footprint or (0, 0))
    if 0 < side < ROOM * thickness(scene):
        made = refined(made, run)
    return _pixelwise(scene, made, seed, run, edge) if edge else made


def least_energy(scene: Scene, methods: Sequence[Method], seed: int, run: Run) -> Synthesis:
    """Fill a scene by each of several methods, by exact copies, and return the result with the least seam energy."""
    best: Synthesis | None = None
    least, refused = 0, None
    for attempt in methods:
        try:
            made = filled(scene, attempt, seed, Blend(0), run)
        except IntarsiaError as e:
            if e.exit_code == 130:
                raise
            refused = refused or e
            continue
        cost = energy(scene.exemplars, made.map) if methods[1:] else 0  # not needed for a single one
        if best is None or cost < least:
            best, least = made, cost
    if best is None:
        assert refused is not None
        raise refused
    return best


def healed_scene(
    picture: Exemplar, hole: ArrayLike, donors: Exemplars, wrap: Wrap, grow: int | None
) -> Scene:
    """Return the scene to heal a picture; `grow` None: enlarge the hole by the detected rim of the defect."""
    scene = scene_to_heal(picture, hole, donors, wrap, 0 if grow is None else grow)
    more = grow is None and rim_around(scene)
    return scene_to_heal(picture, hole, donors, wrap, more) if more else scene


def rim_around(scene: Scene) -> int:
    """Return by how many px the hole must grow to cover a rim of the defect; 0 if none is detected."""
    holes, feats = holes_of(scene), features(scene.exemplars)
    asked = "rim", np.packbits(holes).tobytes()  # key of the cached result, which is needed again when they are filled
    return feats.memo(asked, lambda: defect_rim(feats.pictures[0], holes, scene.exemplars[0].usable))


def with_zero_tolerance(slug: str, values: Record) -> Method:
    """Return a method for holes: with tolerance 0, if it has one and no other is given."""
    return make(slug, ({"tolerance": 0.0} if "tolerance" in parameters_of(slug) else {}) | values)


def methods_to_try(scene: Scene, method: Method) -> list[Method]:
    """Return the methods to try on the holes of a scene: as given, or with several patch sizes if it is automatic."""
    given = values_of(method)
    if given.get("patch", 0) is not AUTO:
        return [method]
    largest = patch_for(scene)
    sizes = SIZES if largest >= ROOM * thickness(scene) else SIZES[:1]
    sides = sorted({max(LEAST_PATCH, round(largest * s)) for s in sizes if largest >= LEAST_PATCH} or {largest})
    return [make(method.slug, given | {"patch": side}) for side in reversed(sides)]


def patch_for(scene: Scene) -> int:
    """Return the largest side of patches for the holes, px: ROOM times the thickness of the thickest hole.

    So a patch holds the hole and its surroundings. It is at most the automatic patch size of the texture and the
    shorter side of the canvas, and small enough that the exemplars hold enough places for it.
    """
    thick = thickness(scene)
    side = max(min(max(ROOM * thick, thick + 16), element_patch(scene.exemplars)), LEAST_PATCH)
    return patch_with_supply(scene.exemplars, min(side, *scene.canvas.shape), LEAST_PATCH)


def thickness(scene: Scene) -> int:
    """Return the largest thickness of the holes of a scene, px (Chebyshev distance)."""
    return 2 * int(ndimage.distance_transform_cdt(np.pad(holes_of(scene), 1), metric="chessboard").max()) - 1


def holes_of(scene: Scene) -> Mask:
    """Return the holes of the start map of a scene."""
    assert scene.canvas.start is not None
    return scene.canvas.start.holes


def _pictured(picture: ExemplarLike, hole: ArrayLike, grow: int | None, wrap: Wrap) -> Exemplar:
    """Return the exemplar of a picture to heal; pixels in the hole may be NaN."""

    def unused(*_: Any) -> Mask:
        return dilated_hole(hole, grow or 0, wrap)

    if isinstance(picture, str | Path):
        from ..files import read_set

        return read_set({"albedo": picture}, unused=unused)
    try:
        return as_exemplars([picture])[0]
    except NotFiniteError:
        return Exemplar.of(picture, usable=~unused(), name="exemplar 1")


def _pixelwise(scene: Scene, made: Synthesis, seed: int, run: Run | None, edge: int) -> Synthesis:
    """Fill a band of `edge` px along the edge of the holes again, pixel by pixel."""
    holes = holes_of(scene)
    inner = ndimage.distance_transform_cdt(np.pad(holes, 1, mode="edge"), metric="chessboard")[1:-1, 1:-1]
    again = replace(scene.canvas, start=with_hole(made.map, holes & (inner <= edge)), rim=0)
    whole = filled(replace(scene, canvas=again), PIXELWISE, seed, Blend(0), run)
    return replace(made, map=whole.map, recipe=made.recipe | {"edge": edge})
