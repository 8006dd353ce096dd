"""Extending and healing pictures: start maps, filled by any method that can continue one.

    wide = ia.extend("wall.png", right=200, top=50)
    whole = ia.heal("wall.png", mask)                      # mask: True where the picture is to be replaced
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .analysis import Features, default_patch, features, rim_of, seam_total
from .auto import AUTO_METHOD, Auto
from .errors import IntarsiaError, ParameterError
from .exemplar import Exemplar
from .geometry import Wrap
from .lazy import lazy
from .methods.base import METHODS, Method, make, method_class
from .params import AUTO, parameters
from .run import Run
from .sourcemap import Blend
from .starts import USUAL, Margins, Scene, extension, mending, with_hole
from .synthesis import ExemplarLike, Synthesis, as_exemplars, carry_out, named

if TYPE_CHECKING:
    from scipy import ndimage
else:  # only holes need it
    ndimage = lazy("scipy.ndimage")

LEAST_PATCH = 12
SUPPLY = 8  # at least 1/SUPPLY of the windows of the exemplar must be free of marked pixels
SIZES = (1.0, 0.75, 0.5, 0.375)  # patch sizes tried on a hole, relative to the automatic one
PIXELWISE = "efros-leung"


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
    """Continue a picture beyond its borders.

    Parameters
    ----------
    picture : as for :func:`synthesize`
        What is continued; deeper than the method's overlap it stays as it is.
    margins : Margins, optional
        How far, on each side, px; 100 px to the right if left out.
    sources : pictures, optional
        Where new pixels are taken from, in place of the picture itself.

    Raises
    ------
    ParameterError, InputError, MethodError
    """
    first, donors = as_exemplars([picture])[0], tuple(as_exemplars(list(sources))) if sources else ()
    scene = extension(first, margins or Margins(right=USUAL), donors, Wrap(wrap))
    made = carry_out(scene.exemplars, scene.canvas, named(method), seed, blend, run)
    return replace(made, recipe=made.recipe | scene.recipe)


def heal(
    picture: ExemplarLike,
    hole: ArrayLike,
    method: Method | Auto | str = AUTO_METHOD,
    *,
    sources: Sequence[ExemplarLike] = (),
    grow: int | None = 0,
    seed: int = 0,
    wrap: Wrap | str = Wrap.NONE,
    run: Run | None = None,
) -> Synthesis:
    """Replace parts of a picture by what suits there; all else stays, byte for byte.

    Parameters
    ----------
    picture : as for :func:`synthesize`
        What is healed.
    hole : bool array, shape (H, W)
        True where it is to be replaced; any number of holes. Nothing is sampled from there.
    sources : pictures, optional
        Where new pixels are taken from, in place of the picture itself.
    grow : int, optional
        Enlarge the hole by so many px first; None: as far as a rim of the defect is seen outside of it.

    Raises
    ------
    InputError
        where the hole is nowhere, everywhere, or of another size than the picture.
    ParameterError, MethodError
    """
    first, donors = as_exemplars([picture])[0], tuple(as_exemplars(list(sources))) if sources else ()
    scene = repaired(first, hole, donors, Wrap(wrap), grow)
    chosen = exacting(method, {}) if isinstance(method, str) and method != AUTO_METHOD else named(method)
    return fill_holes(scene, for_holes(scene, chosen), seed, run)


def fill_holes(scene: Scene, method: Method, seed: int, run: Run | None = None, edge: int = 0) -> Synthesis:
    """Fill the holes of a scene with patches, then `edge` px along their edge again, pixel by pixel (S0-89).

    Without a patch size several are tried; the result with the least visible seams is taken.
    """
    check_edge(edge)
    best: Synthesis | None = None
    least, refused = 0, None
    feats = features(scene.exemplars)
    if run is not None:
        run.notes.extend(rim_left(scene, feats))
    for attempt in attempts(scene, method):
        try:
            made = carry_out(scene.exemplars, scene.canvas, attempt, seed, Blend(0), run)
        except IntarsiaError as e:
            if e.exit_code == 130:
                raise
            refused = refused or e
            continue
        cost = seam_total(feats, scene.exemplars, made.map)
        if best is None or cost < least:
            best, least = made, cost
    if best is None:
        assert refused is not None
        raise refused
    best = replace(best, recipe=best.recipe | scene.recipe)
    return _pixelwise(scene, best, seed, run, edge) if edge else best


def repaired(
    picture: Exemplar, hole: ArrayLike, donors: Sequence[Exemplar], wrap: Wrap, grow: int | None = 0
) -> Scene:
    """Prepare to heal; without a number the hole is enlarged as far as a rim of the defect is seen outside of it."""
    scene = mending(picture, hole, donors, wrap, grow or 0)
    more = rim_around(scene, features(scene.exemplars)) if grow is None else 0
    return mending(picture, hole, donors, wrap, more) if more else scene


def rim_around(scene: Scene, feats: Features) -> int:
    """By how many px the hole of a scene must grow to cover a rim of the defect; 0 where none is seen."""
    assert scene.canvas.start is not None
    return rim_of(feats.pictures[0], scene.canvas.start.holes, scene.exemplars[0].usable)


def rim_left(scene: Scene, feats: Features) -> tuple[str, ...]:
    """Say so where a rim of the defect seems to be left outside of the hole, and how far it must grow."""
    more = rim_around(scene, feats)
    if not more:
        return ()
    grow = scene.recipe.get("heal", {}).get("grow", 0) + more
    return (f"pixels at the edge of the hole look like a rim of what was there; --grow {grow} would cover it.",)


def for_holes(scene: Scene, method: Method | Auto) -> Method:
    """Return the method for the holes of a scene; a chosen one takes of all patches the best, unless told otherwise."""
    if not isinstance(method, Auto):
        return method
    slug, told = method.first(scene.exemplars, scene.canvas)
    return exacting(slug, told)


def check_edge(edge: int) -> None:
    """Refuse an edge to be filled pixel by pixel where no method can."""
    if edge < 0:
        raise ParameterError(f"edge={edge} is not allowed; give at least 0 px.")
    if edge and PIXELWISE not in METHODS:
        raise ParameterError(f"edge={edge} px need the method {PIXELWISE}, which is not there; leave it out.")


def exacting(slug: str, values: dict[str, Any]) -> Method:
    """Make a method for holes: of all patches the best, if nothing else is asked for."""
    names = {p.name for p in parameters(method_class(slug))}
    return make(slug, ({"tolerance": 0.0} if "tolerance" in names else {}) | values)


def attempts(scene: Scene, method: Method) -> list[Method]:
    """The methods to try on the holes of a scene: as given, or in several patch sizes if none is given."""
    names = {p.name for p in parameters(method)}
    if "patch" not in names or getattr(method, "patch", None) is not AUTO:
        return [method]
    largest = patch_for(scene)
    sides = sorted({max(LEAST_PATCH, round(largest * s)) for s in SIZES if largest >= LEAST_PATCH} or {largest})
    given = {p: getattr(method, p) for p in names}
    return [make(method.slug, given | {"patch": side}) for side in reversed(sides)]


def patch_for(scene: Scene) -> int:
    """The largest patch that suits the holes: twice as large as the thickest, so that its surroundings are seen.

    At most what the texture's elements need, and there must be enough places in the exemplars to take it from.
    """
    start = scene.canvas.start
    assert start is not None
    holes = np.pad(start.holes, 1)
    thick = 2 * int(ndimage.distance_transform_cdt(holes, metric="chessboard").max()) - 1
    side = max(min(max(2 * thick, thick + 16), default_patch(scene.exemplars)), LEAST_PATCH)
    side = min(side, scene.canvas.height, scene.canvas.width)
    while side > LEAST_PATCH and not any(SUPPLY * free >= all_ for free, all_ in _supply(scene, side)):
        side = max(side - max(side // 8, 1), LEAST_PATCH)
    while side > 1 and not any(free for free, _ in _supply(scene, side)):
        side -= 1
    return side


def _supply(scene: Scene, side: int) -> list[tuple[int, int]]:
    """Of every exemplar, how many places there are for patches of this size: free of marked pixels, and in all."""
    counts = []
    for e in scene.exemplars:
        rows, columns = e.height - side + 1, e.width - side + 1
        if min(rows, columns) < 1:
            counts.append((0, 1))
        elif e.usable is None:
            counts.append((rows * columns, rows * columns))
        else:
            bad = np.pad(np.cumsum(np.cumsum(~e.usable, axis=0, dtype=np.int64), axis=1), ((1, 0), (1, 0)))
            marked = bad[side:, side:] - bad[:-side, side:] - bad[side:, :-side] + bad[:-side, :-side]
            counts.append((int(np.count_nonzero(marked == 0)), rows * columns))
    return counts


def _pixelwise(scene: Scene, made: Synthesis, seed: int, run: Run | None, edge: int) -> Synthesis:
    """Fill a band along the edge of the holes again, pixel by pixel."""
    canvas = scene.canvas
    assert canvas.start is not None
    inner = ndimage.distance_transform_cdt(np.pad(canvas.start.holes, 1, mode="edge"), metric="chessboard")[1:-1, 1:-1]
    band = canvas.start.holes & (inner <= edge)
    again = replace(canvas, start=with_hole(made.map, band), rim=0)
    filled = carry_out(scene.exemplars, again, make(PIXELWISE, {}), seed, Blend(0), run)
    return replace(made, map=filled.map, recipe=made.recipe | {"edge": edge})
