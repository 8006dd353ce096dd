"""Making a picture tileable: a band along its borders is synthesised again, so that it is periodic; the rest is kept.

    made = ia.tile("stones.png")
    ia.write("stones_tiled.png", made.render())

The picture is the start map. The middle of the band, along the line where opposite borders meet, is a hole; the rest
of the band is the rim, which the cheapest cut may replace. It is filled by a method for periodic canvases.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..analysis import block_sums, scaled_variances
from ..analysis.features import features
from ..analysis.structure import border_steps
from ..choosing.auto import Auto
from ..choosing.facts import Facts
from ..foundation import AUTO_METHOD, InputError, ParameterError, called, chosen, size_of, whole_within
from ..foundation.arrays import Int16, Mask, Pair
from ..foundation.blend import Blend, Levelling
from ..foundation.geometry import UNIT, Wrap
from ..foundation.params import AUTO, extent, values_of
from ..foundation.run import Run, run_of
from ..lattice import allowed_misfit, closing_length
from ..methods import Method, make, traits
from ..model import Exemplar, Exemplars
from ..model.canvas import Canvas
from ..model.image import Plane
from ..model.sourcemap import identity
from ..search import element_patch, patch_with_supply
from ..synthesis import ExemplarLike, Plan, Scene, Synthesis, as_exemplars, named
from .completion import donors_of, exemplars_of, holes_of, least_energy, planned_for_holes, with_hole

SEAMLESS = 1.3  # largest mean difference across a border, relative to that of neighbours inside, that counts as none
LEAST_SIDE = 16  # px: least side of a picture along a periodic axis
LEAST_BAND = 4  # px: least width of the band: a hole of two, and a rim of one on either side
ELEMENTS = 1.5  # width of an automatic band, in elements (texels)
WIDEST = 0.4  # width of an automatic band at most, relative to the shorter side
STAYS = 3  # at least 1/STAYS of either side is outside of the band
# Width of the hole: 1/SLIT of the band, or 1/GAP for textures of single elements; the rest of the band is the rim.
# With 1/8 tiles, courses, ripples and clouds keep their lines; with 1/3 they get rows of half tiles. Stones and leaves
# need 1/3, as cuts along a narrow hole run straight through them.
SLIT, GAP = 8, 3
# Share of the rim on either side of the hole, at most MOST_LEVELLED px: its outer part, which is not cut but kept for
# gradient-domain tone correction within the band. Without it, and still with a quarter, clouds and planks show an
# edge. Textures of
# single elements get none, as elements would glow at cuts, unless their grain is fine: without correction patches are
# seen in jeans and leather. A lattice that is continuous across the borders needs no correction.
LEVELLED, MOST_LEVELLED = 0.5, 64
# A grain is fine if means of squares of SQUARE px keep at most GRAIN of the standard deviation of pixels: grass keeps
# 0.7, stones and leaves 0.8.
SQUARE, GRAIN = 4, 0.75
NARROW, WIDE = (1.0, 0.75, 0.5), (1.25, 1.0, 0.75)  # sides of windows tried, relative to the band: 1/SLIT and 1/GAP
ENDS = 10  # in at least so many of 12 directions an element size is found if a texture consists of single elements
DIRECTED = 0.3  # coherence of edges above which a texture is directional; ripples and walls have more, stones less
LEAST_WINDOW = 12  # px: least side of the windows that are tried


def tile(
    image: ExemplarLike,
    method: Method | Auto | str = AUTO_METHOD,
    *,
    axes: Wrap | str = Wrap.BOTH,
    band: int | None = None,
    size: int | Pair | None = None,
    sources: Sequence[ExemplarLike] = (),
    seed: int = 0,
    run: Run | None = None,
) -> Synthesis:
    """Make a picture tileable: it becomes periodic, and only a band along its borders changes.

    Parameters
    ----------
    image : as for :func:`synthesize`
        A picture, or planes of one surface, which all follow one map. At least 16 px along each axis that becomes
        periodic.
    method : Method, Auto or str
        A method with the abilities ``start`` and ``wrap``; default ``"auto"``, which chooses one.
    axes : {"x", "y", "both"}
        Along which axes it becomes periodic, default "both".
    band : int, optional
        Width of the band that is synthesised, px: half of it at each of two borders that meet. Default: one and a half
        elements of the texture, at most 0.4 of the shorter side.
    size : int or (height, width), optional
        Crop the picture to this size first, from its middle; pixels outside are still sources. Default: the largest
        size of whole periods, if the picture has a sure lattice or courses; else its own size.
    sources : sequence of pictures, optional
        Exemplars of the new pixels, instead of the picture itself.
    seed : int
        0 to 2**64 - 1, default 0; the same seed gives the same bytes.
    run : Run, optional
        Threads, progress, cancelling; gets a note if the picture is cropped by default, or looks periodic already.

    Returns
    -------
    Synthesis
        Of the size of the picture or of the crop. Beyond the band its pixels are those of the picture, bit for bit.

    Raises
    ------
    InputError
        if the picture is too small, or is marked as periodic already (toroidal).
    ParameterError
        for arguments out of range, or a method that cannot continue a start map on a periodic canvas.
    MethodError
        if the method cannot serve this exemplar.
    """
    (first,) = as_exemplars([image])[:1]
    run = run_of(run)
    cut = None if size is None else size_of(size)
    scene = scene_to_tile(first, donors_of(sources), chosen(Wrap, "axes", axes), band, cut)
    plan = planned_to_tile(scene, named(method))
    run.notes.extend([] if cut else remarks(scene))
    return tiled(plan, seed, run)


def scene_to_tile(
    picture: Exemplar, donors: Exemplars, axes: Wrap, band: int | None, size: Pair | None
) -> Scene:
    """Return the scene to make a picture tileable, cropped to `size` (height, width); None: to whole periods."""
    if axes is Wrap.NONE:
        raise ParameterError("axes=none is not allowed; choose one of x, y, both.")
    if picture.toroidal:
        raise InputError(f"{picture.name} continues in itself already (toroidal); nothing of it is to be tiled.")
    exemplars = exemplars_of(picture, donors)
    top, left, height, width = _cut(picture, periodic_size(picture, axes) if size is None else size)
    sides = [n for n, closed in zip((height, width), axes.closed, strict=True) if closed]
    if min(sides) < LEAST_SIDE:
        raise InputError(f"{picture.name} is too small to be tiled ({width}x{height} px); give {LEAST_SIDE} px a side.")
    unit = unit_of(picture)
    most = min(sides) * (STAYS - 1) // STAYS
    if band is None:
        wanted = min(ELEMENTS * element_patch([_seen(picture)]), WIDEST * min(sides))
        band = min(max(round(wanted / (2 * unit)) * 2 * unit, LEAST_BAND), most)
    band = whole_within("band", band, LEAST_BAND)
    if band > most:
        raise ParameterError(f"band={band} is not allowed; give {LEAST_BAND} to {most} px, so that 1/{STAYS} stays.")
    facts = Facts([_seen(picture)], Canvas(height, width, axes))
    single = _of_single_elements(facts)
    rim = (band - max(band // (GAP if single else SLIT), 2)) // 2
    glows = single and not _fine_grained(facts.picture)
    level = 0 if glows or _closes(facts) else min(round(rim * LEVELLED), MOST_LEVELLED) // unit * unit
    hole = _along_borders((height, width), axes, band - 2 * rim)
    whole = identity([e.source for e in exemplars], 0)
    part = slice(top, top + height), slice(left, left + width)
    which = None if whole.which is None else whole.which[part]
    start = replace(with_hole(replace(whole, yx=whole.yx[part], which=which), hole), wrap=axes)
    said = {"axes": axes.value, "band": band}
    return Scene(exemplars, Canvas(height, width, axes, start, rim=rim - level), {"tile": said})


def periodic_size(picture: Exemplar, axes: Wrap) -> Pair:
    """Return the default (height, width), px: the largest of whole periods of a sure lattice, or of whole courses.

    That of the picture if it has neither a lattice nor courses, or looks periodic already.
    """
    seen = _seen(picture)
    whole = height, width = picture.shape
    if _continues(seen, axes):
        return whole
    facts = Facts([seen], Canvas(height, width, axes))
    found = facts.lattice
    if found is None or found.verdict != "sure":
        return _whole_courses(facts, whole, axes, unit_of(picture))
    down, across = (
        closed and closing_length(found.vectors, side, axis, unit_of(picture))
        for axis, (side, closed) in enumerate(zip(whole, axes.closed, strict=True))
    )
    return down or height, across or width


def _whole_courses(facts: Facts, whole: Pair, axes: Wrap, unit: int) -> Pair:
    """Return the size (height, width) with the distance from the first bed joint to the last across the courses.

    That of the whole picture if what lies beyond both joints is together as high as one of the courses, as then it is
    periodic, too; or if it has no courses along a periodic axis, or they cover less than half of it.
    """
    lines = facts.courses
    if lines is None or not axes.closed[lines.axis]:
        return whole
    heights, length = lines.heights, sum(lines.heights)
    near = allowed_misfit([(min(heights) * UNIT, 0)])
    if length < whole[lines.axis] / 2 or any(abs(whole[lines.axis] - length - high) <= near for high in heights):
        return whole
    cut = length // unit * unit
    return (cut, whole[1]) if lines.axis == 0 else (whole[0], cut)


def _continues(picture: Exemplar, axes: Wrap) -> bool:
    """Whether a picture looks periodic along these axes."""
    steps = border_steps(features([picture]).pictures[0], picture.usable)
    return max(step for step, closed in zip(steps, axes.closed, strict=True) if closed) <= SEAMLESS


def _cut(picture: Exemplar, size: Pair) -> tuple[int, int, int, int]:
    """Return top, left, height and width of the middle crop, aligned to the pixels of the smallest plane."""
    height, width = size
    unit, described = unit_of(picture), f"{picture.name} ({picture.width}x{picture.height} px)"
    if not (0 < height <= picture.height and 0 < width <= picture.width):
        asked = f"size={called(width)}x{called(height)}"
        raise ParameterError(f"{asked} cannot be cut out of {described}; give at most that.")
    if height % unit or width % unit:
        raise ParameterError(f"size={width}x{height} cuts pixels of a smaller plane; give multiples of {unit}.")
    top, left = (picture.height - height) // (2 * unit) * unit, (picture.width - width) // (2 * unit) * unit
    return top, left, height, width


def unit_of(picture: Exemplar) -> int:
    """Return how many px of the base one px of the smallest plane covers along an axis."""
    return max(1, *(picture.width // max(p.width, 1) for p in picture.planes.values()))


def _of_single_elements(facts: Facts) -> bool:
    """Whether a texture consists of single elements: bounded in all directions, no lattice, rows or direction."""
    alone = facts.lattice is None and facts.element.found >= ENDS and not facts.ordered
    return alone and facts.coherence <= DIRECTED


def _fine_grained(picture: Int16) -> bool:
    """Whether means of SQUARE px squares keep at most GRAIN of the standard deviation of features (H, W, C)."""
    squares = block_sums(picture, SQUARE)
    kept, all_of_it = (
        sum(scaled_variances(p.reshape(-1, p.shape[2]))) / p[..., 0].size ** 2 for p in (squares, picture)
    )
    return kept <= (GRAIN * SQUARE**2) ** 2 * all_of_it


def _closes(facts: Facts) -> bool:
    """Whether a picture has a 2-D lattice that is continuous across the borders that meet."""
    found, canvas = facts.lattice, facts.canvas
    sides = zip(canvas.shape, canvas.wrap.closed, strict=True)
    return found is not None and len(found.vectors) == 2 and all(
        closing_length(found.vectors, side, axis) == side for axis, (side, closed) in enumerate(sides) if closed
    )


def _along_borders(size: Pair, axes: Wrap, wide: int) -> Mask:
    """Return a mask (H, W), True within a hole of `wide` px along each line where opposite borders meet."""
    near = [np.zeros(n, bool) for n in size]
    for line, closed in zip(near, axes.closed, strict=True):
        if closed:
            line[: wide // 2] = line[len(line) - (wide - wide // 2) :] = True
    return near[0][:, None] | near[1][None, :]


def planned_to_tile(scene: Scene, method: Method | Auto) -> Plan:
    """Return the plan to fill the band of a scene by exact copies; an automatic side of windows is left undecided."""
    plan = planned_for_holes(scene, method)
    windows_to_try(plan)[0].resolved(scene.exemplars, scene.canvas)  # raises if it cannot work
    radius = (scene.recipe["tile"]["band"] - _empty(scene)) // 2 - (scene.canvas.rim or 0)
    if not (radius and traits(plan.method).exact):
        return plan
    return replace(plan, blend=Blend(0, finish=(Levelling(radius),)))


def _empty(scene: Scene) -> int:
    """Return the width of the hole across a line where borders meet, px."""
    holes = holes_of(scene)
    return int((holes[len(holes) // 2] if scene.canvas.wrap.x else holes[:, holes.shape[1] // 2]).sum())


def tiled(plan: Plan, seed: int, run: Run) -> Synthesis:
    """Fill the band; if no patch size is given, several are tried, and the result of least seam energy is kept."""
    made = least_energy(plan.scene, windows_to_try(plan), seed, run)
    return replace(made, blend=plan.joined, recipe=made.recipe | {"blend": plan.joined.as_recipe})


def windows_to_try(plan: Plan) -> list[Method]:
    """Return the methods to try on the band of a scene: as given, or with windows of several sizes."""
    scene, method, given = plan.scene, plan.method, values_of(plan.method)
    if given.get("patch", 0) is not AUTO:
        return [method]
    band = scene.recipe["tile"]["band"]
    parts = WIDE if _empty(scene) * (SLIT + GAP) > 2 * band else NARROW
    sides = {patch_with_supply(scene.exemplars, max(round(band * part), LEAST_WINDOW), LEAST_WINDOW) for part in parts}
    least = max(extent(given.get("overlap") or 0))
    fitting = [side for side in sorted(sides, reverse=True) if side > least] or [max(sides)]
    return [make(method.slug, given | {"patch": side}) for side in fitting]


def remarks(scene: Scene) -> list[str]:
    """Return notes on the default size: the picture was cropped, or is periodic already."""
    picture, canvas = scene.exemplars[0], scene.canvas
    if _continues(_seen(picture), canvas.wrap):
        return [f"{picture.name} looks as if it continued in itself already; then it can stay as it is."]
    if canvas.shape == picture.shape:
        return []
    whole, part = f"{picture.width}x{picture.height}", f"{canvas.width}x{canvas.height}"
    said = f"{picture.name} ({whole} px) was cut to {part} px, where its periods or courses close"
    return [f"{said}; --size {whole} keeps all."]


def _seen(picture: Exemplar) -> Exemplar:
    """Return the picture for measurements: without its mask if that leaves no usable pixel, as with other sources."""
    nothing = picture.usable is not None and not picture.usable.any()
    return replace(picture, usable=None) if nothing else picture


def repeated(plane: Plane, axes: Wrap, times: int) -> Plane:
    """Return a picture repeated `times` along each periodic axis."""
    return plane.like(np.tile(plane.samples, (*(times if closed else 1 for closed in axes.closed), 1)))
