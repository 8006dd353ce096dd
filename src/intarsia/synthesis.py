"""Texture synthesis in one call: exemplars, canvas and method become a map, with its rendering and recipe."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .foundation import AUTO_METHOD, InputError, MethodError, ParameterError, chosen, expect, lazy, size_of
from .foundation.arrays import Array, Pair
from .foundation.blend import Blend, Finish
from .foundation.geometry import Box, Wrap, overlap_range
from .foundation.run import Run, check_seed, run_of
from .methods import Method, check_abilities, check_method, check_start, make, recipe_settings, traits
from .model import Exemplar
from .model.canvas import Canvas, Guide
from .model.image import Plane
from .model.sourcemap import HOLE, SourceMap
from .rendering.render import check_blend, render
from .seams import energy
from .version import VERSION

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from .choosing import auto
    from .choosing.auto import Auto, Choice
    from .judging import Score
else:  # where no method is named
    auto = lazy("intarsia.choosing.auto")

ExemplarLike = Exemplar | Plane | ArrayLike | Mapping[str, "ArrayLike | Plane"] | str | Path


@dataclass(frozen=True, eq=False)
class Synthesis:
    """The result of a synthesis: a source map, the exemplars that it points into, and the recipe that repeats it.

    Pictures are rendered from it: ``render()`` for the base plane, ``render("normal")`` for another.

    Attributes
    ----------
    exemplars : tuple of Exemplar
        In the order of their numbers in the map.
    map : SourceMap
        For every output pixel the exemplar pixel that it is copied from.
    blend : Blend
        How pieces are blended by default.
    method : Method
        With every parameter decided.
    recipe : dict
        All that the map depends on, for JSON: no path, date, timing or number of threads.
    choice : Choice or None
        Why the method was chosen, if it was not named.
    trials : tuple of Score
        The score of each variant, if several were tried.
    canvas : Canvas or None
        What was filled.
    """

    exemplars: tuple[Exemplar, ...]
    map: SourceMap
    blend: Blend
    method: Method
    recipe: dict[str, Any] = field(default_factory=dict)
    choice: Choice | None = None
    trials: tuple[Score, ...] = ()
    canvas: Canvas | None = None

    def __repr__(self) -> str:
        words = f"{self.map.width}x{self.map.height} px, {self.method.slug}, seed {self.recipe.get('seed')}"
        return f"<texture: {words}>"

    def render(
        self,
        plane: str | None = None,
        *,
        feather: int | None = None,
        finish: tuple[Finish, ...] | None = None,
        box: Box | None = None,
        run: Run | None = None,
    ) -> Plane:
        """Render a plane of the map, all of it or a window.

        Parameters
        ----------
        plane : str, optional
            Name of a plane or packed map of the exemplar; default: the base.
        feather : int, optional
            Width, in px of the map, over which pieces are blended, 0 to 1024; default: that of ``blend``.
        finish : tuple of Levelling, optional
            Gradient-domain tone correction; default: that of ``blend``, and ``()`` for none.
        box : Box, optional
            The window, in px of the map; default: all.
        run : Run, optional
            Threads, progress, cancelling.

        Returns
        -------
        Plane
            Of the dtype and kind of the exemplar's plane.

        Raises
        ------
        ParameterError
            for an unknown plane, a window outside of the map, or a blend that the map or the plane does not allow.
        """
        expect(box, (Box, NoneType), "box", "a Box")
        return render(self.exemplars, self.map, plane, self.blend.but(feather=feather, finish=finish), box, run_of(run))

    @cached_property
    def energy(self) -> int:
        """Cost of all seams, in thresholds of the truncated quadratic, per million px of the map; less is better."""
        return energy(self.exemplars, self.map)

    @cached_property
    def recipe_text(self) -> str:
        """The recipe with the seam energy of its map, as canonical JSON."""
        return json.dumps(self.recipe | {"energy": self.energy}, sort_keys=True, separators=(",", ":"))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.asarray(self.render().pixels, dtype=dtype)

    def _repr_png_(self) -> bytes:
        return self.render()._repr_png_()


def synthesize(
    exemplar: ExemplarLike | Sequence[ExemplarLike],
    size: int | Pair | None = None,
    method: Method | Auto | str = AUTO_METHOD,
    *,
    seed: int = 0,
    wrap: Wrap | str = Wrap.NONE,
    start: SourceMap | None = None,
    guide: Guide | None = None,
    blend: Blend | None = None,
    run: Run | None = None,
) -> Synthesis:
    """Synthesise a texture from an example (example-based texture synthesis).

    Parameters
    ----------
    exemplar : path, array, dict of arrays, Plane, Exemplar, or a list of them
        Arrays are (H, W) or (H, W, C) of 8-bit, 16-bit or float pixels. ``"sample:NAME"`` is a built-in exemplar.
    size : int or (height, width), optional
        Size of the output in px; a number is a square. Default: that of `start` or of the guide's target, else
        twice the (first) exemplar.
    method : Method, Auto or str
        For example ``ImageQuilting(patch=96)``, or the name of a method. ``"auto"``, the default, chooses by what the
        exemplar is like; ``Auto(trials=4)`` also keeps the best of four.
    seed : int
        0 to 2**64 - 1, default 0; the same seed gives the same bytes, on any machine and any number of threads.
    wrap : {"none", "x", "y", "both"}
        Along which axes the output must be periodic (tileable), default "none".
    start : SourceMap, optional
        A partly filled map to continue, of the size of the output.
    guide : Guide, optional
        Labels or a target picture, for methods with the ability ``guide``.
    blend : Blend, optional
        How pieces are blended; default: that of the method.
    run : Run, optional
        Threads, progress, cancelling.

    Returns
    -------
    Synthesis
        The map, the exemplars and the recipe; ``render()`` gives the picture.

    Raises
    ------
    ParameterError
        for arguments out of range, or an ability that the method does not have.
    InputError
        if an exemplar cannot be read, has no usable pixels, or does not fit the start map or guide.
    MethodError
        if the method cannot serve this exemplar.
    CancelledError
        when the run is cancelled.
    """
    exemplars = as_exemplars(exemplar)
    return filled(Scene(exemplars, canvas_of(exemplars, size, wrap, start, guide)), method, seed, blend, run)


def named(method: Method | Auto | str) -> Method | Auto:
    """Return the method of a name, with its defaults, or the given one; the name "auto" gives Auto()."""
    if isinstance(method, str):
        return auto.Auto() if method == AUTO_METHOD else make(method, {})
    return method if _is_auto(method) else check_method(method)


def _is_auto(method: Method | Auto) -> TypeIs[Auto]:
    """Whether a method is Auto, known by its slug, so that the modules of the automatic choice are not imported."""
    return getattr(method, "slug", "") == AUTO_METHOD


@dataclass(frozen=True, eq=False)
class Scene:
    """Exemplars, the canvas to fill, which may have a start map, and the recipe entries of the task."""

    exemplars: tuple[Exemplar, ...]
    canvas: Canvas
    recipe: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Plan:
    """A synthesis that is checked, but not carried out yet.

    ``method``: its parameters are decided, except a patch size that is left to trials (holes, bands). ``choice``: why
    it was chosen, if it was not named. ``blend``: None for that of the method.
    """

    scene: Scene
    method: Method
    blend: Blend | None = None
    choice: Choice | None = None

    @property
    def joined(self) -> Blend:
        """The blend in force: the given one, else that of the method.

        Of a magnified exemplar the latter has a feather of at least 1 px, as otherwise px of the map show as squares;
        not where pieces are turned or scaled, which have none.
        """
        own = (self.choice or self.method).blend
        least = int(self.scene.exemplars[0].times > 1 and traits(self.method).exact)
        return self.blend or replace(own, feather=max(own.feather, least))

    @property
    def overlaps(self) -> dict[str, list[int]]:
        """Least and most overlap of neighbouring patches in px along rows and columns.

        Empty for methods without patches that overlap, and on a canvas with a start map.
        """
        canvas, its = self.scene.canvas, traits(self.method)
        if its.pitch is None or its.footprint is None or its.pitch == its.footprint or canvas.start is not None:
            return {}
        size, wraps, found = (canvas.height, canvas.width), (canvas.wrap.y, canvas.wrap.x), dict[str, list[int]]()
        for name, side, px, step, closed in zip("yx", size, its.footprint, its.pitch, wraps, strict=True):
            found[name] = [*overlap_range(side, px, px - step, closed, its.hangs)]
        return found


def planned(
    scene: Scene, method: Method | Auto | str, blend: Blend | None = None, run: Run | None = None
) -> Plan:
    """Return the plan of a scene with method and parameters decided.

    Raises ParameterError, InputError or MethodError if exemplars, canvas, method and blend do not fit one another.
    """
    expect(blend, (Blend, NoneType), "blend", "a Blend, such as Blend(8)")
    method = named(method)
    if _is_auto(method):
        choice = method.choose(scene.exemplars, scene.canvas, run)
        return Plan(scene, choice.method, blend, choice)
    check_abilities(method, scene.exemplars, scene.canvas)
    resolved = method.resolved(scene.exemplars, scene.canvas)
    check_between(resolved, blend or resolved.blend)
    return Plan(scene, resolved, blend)


def filled(scene: Scene, method: Method | Auto | str, seed: int, blend: Blend | None, run: Run | None) -> Synthesis:
    """Fill the canvas of a scene with a method: plan it, note warnings of the automatic choice, and carry it out."""
    seed, run = check_seed(seed), run_of(run)
    plan = planned(scene, method, blend, run)
    run.notes.extend(plan.choice.warnings if plan.choice else ())
    return carry_out(plan, seed, run)


def carry_out(plan: Plan, seed: int, run: Run) -> Synthesis:
    """Carry out a plan: compute the map, by trials if the method was chosen, and the recipe."""
    exemplars, canvas, choice, asked = plan.scene.exemplars, plan.scene.canvas, plan.choice, seed
    scores: tuple[Score, ...] = ()
    if choice is None:
        smap = plan.method.synthesize(exemplars, canvas, seed, run)
    else:
        choice, best, scores = auto.carried_out(choice, exemplars, canvas, seed, run)
        plan, smap, seed = replace(plan, method=best.method), best.map, best.seed
    if bool(smap.holes.any()):
        raise MethodError(f"{plan.method.slug} left {int(smap.holes.sum())} px unfilled; please report this.")
    recipe = _recipe(plan.method, exemplars, canvas, seed, plan.joined)
    if choice is not None:
        recipe["auto"] = choice.recipe | ({"trials": len(scores), "seed": asked} if scores else {})
    recipe |= plan.scene.recipe | ({"overlaps": plan.overlaps} if plan.overlaps else {})
    return Synthesis(exemplars, smap, plan.joined, plan.method, recipe, choice, scores, canvas)


def as_exemplars(given: ExemplarLike | Sequence[ExemplarLike]) -> tuple[Exemplar, ...]:
    """Return the exemplars that an argument of the user stands for; a list or tuple gives several.

    Raises InputError if one cannot be read or none has usable pixels, ParameterError for 255 or more.
    """
    items = list(given) if isinstance(given, (list, tuple)) else [given]
    if not items:
        raise InputError("no exemplar is given; give at least one picture.")
    exemplars = tuple(_as_exemplar(item, number) for number, item in enumerate(items))
    if len(exemplars) >= HOLE:
        raise ParameterError(f"{len(exemplars)} exemplars are too many; give at most {HOLE - 1}.")
    if not any(e.usable is None or e.usable.any() for e in exemplars):
        described = " and ".join(f"{e.name} ({e.width}x{e.height} px)" for e in exemplars[:4])
        raise InputError(f"the mask leaves no pixel of {described} to use; mark fewer.")
    return exemplars


def _as_exemplar(item: Any, number: int) -> Exemplar:
    if isinstance(item, (str, Path)):
        from .files import read

        return read(item)
    return item if isinstance(item, Exemplar) else Exemplar.of(item, name=f"exemplar {number + 1}")


def canvas_of(
    exemplars: tuple[Exemplar, ...],
    size: int | Pair | None,
    wrap: Wrap | str,
    start: SourceMap | None,
    guide: Guide | None,
    rim: int | None = None,
) -> Canvas:
    """Return the canvas; default size: that of the start map, else of the guide, else twice the first exemplar."""
    expect(start, (SourceMap, NoneType), "start", "a SourceMap")
    expect(guide, (Guide, NoneType), "guide", "a Guide")
    if size is None:
        like = start if start is not None else None if guide is None else guide.target
        size = (2 * exemplars[0].height, 2 * exemplars[0].width) if like is None else (like.height, like.width)
    height, width = size_of(size)
    if start is not None:
        check_start(start, exemplars)
    return Canvas(height, width, chosen(Wrap, "wrap", wrap), start, guide, rim)


def check_between(method: Method, blend: Blend) -> None:
    """Raise ParameterError if a blend needs exact copies, and the method rotates or scales pieces."""
    if not traits(method).exact:
        check_blend(blend)


def _recipe(method: Method, exemplars: tuple[Exemplar, ...], canvas: Canvas, seed: int, blend: Blend) -> dict[str, Any]:
    """Return all that the map depends on: no path, date, timing or number of threads."""
    recipe: dict[str, Any] = {
        "intarsia": VERSION,
        "method": method.slug,
        "parameters": recipe_settings(method, exemplars, canvas),
        "seed": seed,
        "size": [canvas.width, canvas.height],
        "wrap": canvas.wrap.value,
        "blend": blend.as_recipe,
        "exemplars": recipe_exemplars(exemplars),
    }
    if canvas.start is not None:
        recipe["start"] = canvas.start.digest
    if canvas.guide is not None:
        recipe["guide"] = canvas.guide.as_recipe
    if canvas.rim is not None:
        recipe["rim"] = canvas.rim
    return recipe


def recipe_exemplars(exemplars: tuple[Exemplar, ...]) -> list[dict[str, Any]]:
    """Return the exemplars as recipes hold them: hashes and sizes, no paths."""
    return [
        {"sha256": e.digest, "size": [e.width, e.height]}
        | ({"name": e.name} if e.name.startswith("sample:") else {})
        | ({"weights": dict(e.weights)} if e.weights else {})
        for e in exemplars
    ]
