"""Texture advection: move a texture along a flow frame by frame, and correct the pixels that the flow tore apart.

    water = ia.synthesize("sample:pebbles", 256, ia.ParallelControllable(), wrap="both")
    for frame in range(1, 50):
        water = ia.advect(water, lambda y, x: (0 * y, 2 + np.sin(y / 40)), frame=frame)

Lefebvre and Hoppe, "Appearance-space texture synthesis", SIGGRAPH 2006 (texture advection). Coordinates move by whole
pixels, so that every pixel of every frame is one of the exemplar. Departure: only torn pixels and a few px around them
are corrected, so rigidly moving parts never change, and nothing flickers where nothing moves.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import replace
from numbers import Integral
from types import NoneType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..corrections import advected, coordinate_pyramid, stack
from ..foundation import InputError, IntarsiaError, ParameterError, called, expect, said, whole_within
from ..foundation.arrays import Floats, Int64
from ..foundation.field import function_name
from ..foundation.run import Run, run_of
from ..methods import check_start, recipe_settings
from ..methods.parallel_controllable import ParallelControllable
from ..model.canvas import Canvas
from ..synthesis import Synthesis

FARTHEST = 1 << 24  # px: largest displacement from the first frame; a limit of arithmetic
MOST_FRAMES = 1 << 40  # largest number of a frame; a limit of arithmetic
STEPS = (1, 2, 4, 8, 16)  # px: allowed spacings of the coarsest level of corrections

Flow = ArrayLike | Callable[[Floats, Floats], Any]


def advect(
    made: Synthesis,
    flow: Flow,
    *,
    frame: int | None = None,
    coarsest: int = 8,
    method: ParallelControllable | None = None,
    run: Run | None = None,
) -> Synthesis:
    """Texture advection: move a texture along a flow by one frame, and correct it where the flow tore it apart.

    Parameters
    ----------
    made : Synthesis
        Of any method, from one exemplar, without holes and without mirrored or rotated pieces; best of
        `ParallelControllable`.
    flow : array (H, W, 2), or a function of (y, x)
        Displacement in px (dy, dx), backward: pixel p shows what was at p - flow(p). A function gets arrays of rows and
        columns (H, W), and returns such an array or a pair (dy, dx) of arrays (H, W).
    frame : int, optional
        The number of the frame that is returned, from 1, for a steady flow in px per frame, where `made` is frame - 1:
        move by round(frame * flow) - round((frame - 1) * flow), so that rounding does not accumulate. Default: move
        by round(flow).
    coarsest : {1, 2, 4, 8, 16}
        Spacing, in px, of the coarsest level on which torn places are corrected; default 8. Large values keep elements
        intact through many frames, small ones change less from frame to frame; 1 if each frame is made from the first
        one.
    method : ParallelControllable, optional
        Settings of the corrections; default: the method of `made` if it is one, else ``ParallelControllable()``.
    run : Run, optional
        Threads, which never change a pixel, and cancelling.

    Returns
    -------
    Synthesis
        With the new map of the same size. Its recipe holds only a hash of the displacements, so it cannot be replayed.

    Raises
    ------
    ParameterError
        for a flow of another size, that holds no finite numbers, or that leads farther than 2**24 px; for a map with
        holes, mirrored or rotated pieces, or of several exemplars.
    InputError
        if `made` is no Synthesis, its map points outside the exemplar, or the function raises an error.
    """
    expect(made, Synthesis, "what is to flow", "what synthesize or advect returned", InputError)
    expect(method, (ParallelControllable, NoneType), "method", "a ParallelControllable")
    _check(made, coarsest)
    check_start(made.map, made.exemplars)
    run, smap, exemplar = run_of(run), made.map, made.exemplars[0]
    steps = displacements(flow, *smap.shape, frame)
    own = made.method if isinstance(made.method, ParallelControllable) else ParallelControllable()
    canvas = Canvas(*smap.shape, smap.wrap)
    mender = (method or own).resolved((exemplar,), canvas)
    stacked = stack.exemplar_stack(exemplar, stack.ComparisonSettings.of(mender))
    before = made.recipe.get("advected", {"frames": 0, "sha256": ""})
    lot = made.recipe.get("seed", 0), before["frames"]
    flowing = advected.AdvectedCorrections(
        stacked, coordinate_pyramid.CorrectionParameters.of(mender), smap.wrap.closed
    )
    yx = flowing.mended(*flowing.moved(smap.yx, steps, lot), coarsest.bit_length() - 1, run)
    settings = sorted(recipe_settings(mender, made.exemplars, canvas).items())
    moves = f"{before['sha256']}|{coarsest}|{settings}|".encode() + steps.astype("<i8").tobytes()
    flowed = {"frames": before["frames"] + 1, "sha256": hashlib.sha256(moves).hexdigest()}
    moved = replace(smap, yx=yx, which=None, pose=None)
    return replace(made, map=moved, recipe=made.recipe | {"advected": flowed})


def displacements(flow: Flow, height: int, width: int, frame: int | None = None) -> Int64:
    """Return the displacement (dy, dx) of each pixel, (H, W, 2) in whole px, from the previous frame to this one."""
    given: Any = flow
    if callable(flow):
        y, x = np.indices((height, width), np.float64)
        try:
            given = flow(y, x)
        except IntarsiaError:
            raise
        except Exception as e:  # errors of the user's function are reported as such
            raise InputError(f"the function {function_name(flow)} gives no flow: {said(e)}") from e
    if isinstance(given, tuple) and len(given) == 2:
        given = _stacked(given, height, width)
    try:
        px = np.asarray(given, np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError("the flow holds no numbers; give an array (height, width, 2) of px, (dy, dx).") from None
    if px.shape != (height, width, 2):
        raise ParameterError(
            f"the flow has the shape {px.shape}, the texture {width}x{height} px; give ({height}, {width}, 2): dy, dx."
        )
    if frame is not None:
        frame = whole_within("frame", frame, 1, MOST_FRAMES, "(the first frame that moved is 1)")
    if not np.isfinite(px).all() or (abs(px) * (frame or 1)).max(initial=0) > FARTHEST:
        raise ParameterError(f"the flow is not finite, or leads farther than {FARTHEST} px; give less.")
    last = 0 if frame is None else _rounded(px * (frame - 1))
    return np.asarray(_rounded(px * (frame or 1)) - last)


def _stacked(given: tuple[Any, Any], height: int, width: int) -> Floats | None:
    """Return a pair (dy, dx) as one array (H, W, 2); None if it holds no numbers."""
    try:
        return np.stack([np.broadcast_to(np.asarray(part, np.float64), (height, width)) for part in given], axis=2)
    except (TypeError, ValueError, OverflowError):
        return None


def _rounded(px: Floats) -> Int64:
    return np.asarray(np.floor(px + 0.5), np.int64)


def _check(made: Synthesis, coarsest: int) -> None:
    if isinstance(coarsest, bool) or not isinstance(coarsest, Integral) or coarsest not in STEPS:
        raise ParameterError(f"coarsest={called(coarsest)} is not allowed; choose 1, 2, 4, 8 or 16 px.")
    smap = made.map
    if len(made.exemplars) != 1 or smap.holes.any() or not smap.exact or smap.poses not in ((), (0,)):
        raise ParameterError(
            "only a full map of one exemplar whose pieces are all upright can flow; grow it from one, with "
            "isometries=none, best by parallel-controllable."
        )
