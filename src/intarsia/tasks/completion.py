"""Extension and hole filling (inpainting) of pictures: a start map with holes, filled by any method that supports one.

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

LEAST_PATCH = 12
ROOM = 2  # times the thickness of a hole: least side of a patch that covers it with its surroundings
SIZES = (1.0, 0.75, 0.5, 0.375)  # patch sizes tried on a hole that one covers, relative to the automatic one
PIXELWISE = "efros-leung"


@dataclass(frozen=True)
class Margins:
    """Widths of the margins by which a picture is extended, px."""

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


def with_hole(smap: SourceMap, hole: ArrayLike) -> SourceMap:
    """Return a map with holes where `hole` (H, W) is True."""
    holes = marks(hole, "the hole's mask")
    if holes.shape != smap.shape:
        raise InputError(
            f"the hole's mask is {holes.shape[-1]}x{holes.shape[0]} px, the map {smap.width}x{smap.height}; "
            "make them equal."
        )
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
    """Extend a picture beyond its borders.

    Parameters
    ----------
    picture : as for :func:`synthesize`
        It is unchanged except within the method's overlap of its border.
    margins : Margins, optional
        Widths in px; 100 px to the right if left out.
    sources : pictures, optional
        Exemplars of the new pixels, instead of the picture itself.

    Raises
    ------
    ParameterError, InputError, MethodError
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
    """Fill holes of a picture; all other pixels stay, byte for byte.

    Parameters
    ----------
    picture : as for :func:`synthesize`
    hole : bool array, shape (H, W), or a gray or RGB picture of any depth
        True for pixels to replace; any number of holes. In numbers and pictures all that is not black (nor wholly
        transparent) is hole. Nothing is sampled from there.
    sources : pictures, optional
        Exemplars of the new pixels, instead of the picture itself.
    grow : int, optional
        Enlarge the hole by so many px first. Default: as far as a rim of the defect is detected outside of it.

    Raises
    ------
    InputError
        if the hole is empty, covers the whole picture, or has another size.
    ParameterError, MethodError
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

    An automatically chosen method always takes the best patch (tolerance 0), unless given otherwise. `edge` px are
    filled pixel by pixel.
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

    If one patch covers a hole and no size is given, several sizes are tried, and the result with the least seam energy
    is kept. If several patches are needed, the worst seams between them are refined in smaller windows, with expansion
    moves of the pieces.
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
    """Return the scene to heal a picture; `grow` None: enlarge the hole by the rim of the defect detected around it."""
    scene = scene_to_heal(picture, hole, donors, wrap, 0 if grow is None else grow)
    more = grow is None and rim_around(scene)
    return scene_to_heal(picture, hole, donors, wrap, more) if more else scene


def rim_around(scene: Scene) -> int:
    """Return by how many px the hole must grow to cover a rim of the defect; 0 if none is detected."""
    holes, feats = holes_of(scene), features(scene.exemplars)
    asked = "rim", np.packbits(holes).tobytes()  # asked again when they are filled
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
    """Return the largest patch for the holes: twice as large as the thickest, so that it holds its surroundings.

    At most the automatic patch size of the texture, and such that there are enough places for it in the exemplars.
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
