"""A texture without end: lazy, sliced like an array, streamed into files of any size.

Every window is made alone: the map of the window with the margin that feather and finish reach, then its rendering. So
it never depends on what was drawn before, on the size of the pieces, or on who draws them.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ..canvas import Canvas
from ..choosing.auto import AUTO_METHOD, Auto
from ..draws import check_seed
from ..errors import ParameterError, said
from ..exemplar import Exemplar
from ..geometry import Box
from ..image import Array, Plane
from ..methods.base import METHODS, Ability, Method, WindowMethod, method_class, recipe_settings
from ..rendering.render import check_alike, render
from ..run import Run, run_of
from ..sourcemap import Blend, SourceMap
from ..synthesis import ExemplarLike, Plan, Scene, as_exemplars, named, planned, recipe_exemplars
from ..version import VERSION
from .cells import SIDE, Grid, box_of, check_memory, check_near, sides_of

if TYPE_CHECKING:
    import os

    from .executors import ExecutorLike

Sides = int | tuple[int, int]


@dataclass(frozen=True, eq=False, repr=False)
class Weave:
    """An endless texture; ``texture[y0:y1, x0:x1]`` is an array, wherever it lies.

    Attributes
    ----------
    exemplars : tuple of Exemplar
        What it is made of.
    method : WindowMethod
        With every parameter decided.
    seed : int
        What the draws follow from.
    blend : Blend
        How pieces are joined.
    name : str
        The plane that is drawn; :meth:`plane` gives the others.
    """

    exemplars: tuple[Exemplar, ...]
    method: WindowMethod
    seed: int
    blend: Blend
    name: str

    def __repr__(self) -> str:
        words = f"{self.method.slug}, seed {self.seed}, {self.name}: {self.dtype} x {self.channels}"
        return f"<endless texture by {words}; slice it, or stream it>"

    @property
    def planes(self) -> tuple[str, ...]:
        """The names of all planes."""
        return self.exemplars[0].drawn

    def plane(self, name: str) -> Weave:
        """Return the same texture showing another plane, as ``texture.plane("normal")``."""
        if not isinstance(name, str) or name not in self.planes:
            raise ParameterError(f"plane={said(name)} is unknown; choose one of {', '.join(self.planes)}.")
        return replace(self, name=name)

    @property
    def like(self) -> Plane:
        """The plane of the exemplar that is shown: its type, kind, transfer and meta are those of every window."""
        return self.exemplars[0].planes[self.name]

    @property
    def dtype(self) -> np.dtype[Any]:
        """The type of the pixels, that of the exemplar."""
        return self.like.pixels.dtype

    @property
    def channels(self) -> int:
        """Channels of a pixel, opacity included."""
        return self.like.channels

    @property
    def scale(self) -> tuple[int, int]:
        """How many times larger, and how many times smaller, the plane is than the map."""
        own, base = self.like.height, self.exemplars[0].height
        return max(own // base, 1), max(base // own, 1)

    def shape_of(self, height: int, width: int) -> tuple[int, ...]:
        """The shape of the array of a window."""
        return (height, width) if self.like.pixels.ndim == 2 else (height, width, self.channels)

    def __getitem__(self, key: Any) -> Array:
        """Draw a window; rows and columns are px of the plane that is shown, negative and huge ones too."""
        box = box_of(key)
        check_memory(box, self.channels * self.dtype.itemsize)
        self.map_box(box)
        if box.height * box.width <= 2 * SIDE * SIDE:
            return self.draw(box)
        out = np.empty(self.shape_of(box.height, box.width), self.dtype)
        cells = list(Grid(box.height, box.width, SIDE, SIDE))

        def fill(n: int) -> None:
            at = cells[n].box
            out[at.y0 : at.y1, at.x0 : at.x1] = self.draw(at.moved(box.y0, box.x0))

        fill(0)  # prepares what the others share
        with Run().pool() as each:
            each(fill, range(1, len(cells)))
        return out

    def draw(self, box: Box, run: Run | None = None) -> Array:
        """Return the pixels (h, w[, C]) of a box; at most 2048 x 2048 px of the map are held at a time."""
        step = max(2 * SIDE // self.scale[1], 1)
        if max(box.height, box.width) <= step:
            return self._drawn(box, run or Run(1))
        out = np.empty(self.shape_of(box.height, box.width), self.dtype)
        for cell in Grid(box.height, box.width, step, step):
            at = cell.box
            out[at.y0 : at.y1, at.x0 : at.x1] = self._drawn(at.moved(box.y0, box.x0), run or Run(1))
        return out

    def _drawn(self, box: Box, run: Run) -> Array:
        """Draw a box in one piece: its map with the margin that feather and finish reach, then the rendering."""
        inner, (grow, shrink) = self.map_box(box), self.scale
        outer = self._around(inner)
        reach = inner.y0 - outer.y0
        part = Box(reach, reach, reach + inner.height, reach + inner.width)
        pixels = render(self.exemplars, self.map(outer, run), self.name, self.blend, part, run).pixels
        dy, dx = box.y0 - inner.y0 * grow // shrink, box.x0 - inner.x0 * grow // shrink
        return pixels[dy : dy + box.height, dx : dx + box.width]

    def _around(self, inner: Box) -> Box:
        """A box of the map with what feather and finish reach around it."""
        reach = (self.blend.feather + 1) // 2 + sum(f.radius for f in self.blend.finish)
        reach = -(-reach // self.scale[1]) * self.scale[1]
        return Box(inner.y0 - reach, inner.x0 - reach, inner.y1 + reach, inner.x1 + reach)

    def map(self, box: Box, run: Run | None = None) -> SourceMap:
        """Return which exemplar pixel every pixel of a box is; px of the map, which larger planes show larger."""
        return self.method.window(self.exemplars, box, self.seed, run or Run(1))

    def map_box(self, box: Box) -> Box:
        """The box of the map that a box of the plane shows; ParameterError where it lies too far away."""
        grow, shrink = self.scale
        found = Box(
            box.y0 // grow * shrink, box.x0 // grow * shrink, -(-box.y1 // grow) * shrink, -(-box.x1 // grow) * shrink
        )
        check_near(found)
        return found

    @property
    def recipe(self) -> dict[str, Any]:
        """All that a pixel depends on, beside its place; but of functions among the parameters only the names."""
        return {
            "intarsia": VERSION,
            "method": self.method.slug,
            "parameters": recipe_settings(self.method),
            "seed": self.seed,
            "blend": self.blend.as_recipe,
            "exemplars": recipe_exemplars(self.exemplars),
            "plane": self.name,
        }

    def recipe_over(self, box: Box) -> dict[str, Any]:
        """All that the pixels of a box depend on: functions with a hash of all that they say for it.

        They are asked for the whole box, in pieces; that is quick beside drawing it.
        """
        around = self._around(self.map_box(box))
        return self.recipe | {"parameters": recipe_settings(self.method, self.exemplars, around)}

    @property
    def digest(self) -> str:
        """SHA-256 of the recipe, as 64 hexadecimal digits."""
        return hashlib.sha256(json.dumps(self.recipe, sort_keys=True).encode()).hexdigest()

    def to_dask(self, shape: Sides, chunks: Any = SIDE, origin: tuple[int, int] = (0, 0)) -> Any:
        """Return a dask array whose blocks are windows; nothing is drawn before it is computed.

        Parameters
        ----------
        shape : int or (height, width)
            Size in px of the plane that is shown.
        chunks : as of dask
            A number of px, or (rows, columns), or all of them.
        origin : (y, x)
            The pixel of the endless plane that comes first.
        """
        from .dasks import array_of

        return array_of(self, sides_of(shape), chunks, origin)

    def to_zarr(
        self, path: str | os.PathLike[str], shape: Sides, *, origin: tuple[int, int] = (0, 0), chunk: int = 512,
        executor: ExecutorLike = None, force: bool = False, run: Run | None = None,
    ) -> None:  # fmt: skip
        """Stream a window of any size into a zarr array (version 3); what a killed run began is gone on with.

        Parameters
        ----------
        path : path
            The folder of the array.
        shape : int or (height, width)
            Size in px of the plane that is shown.
        origin : (y, x)
            The pixel of the endless plane that comes first.
        chunk : int
            Side of the chunks in px; small ones share a file of 1024 px.
        executor : None, "threads", "processes", "local", "tcp://...", or a dask client
            Who draws; never changes a pixel. ``local`` starts a dask cluster on this machine.
        force : bool
            Begin anew where another recipe was woven; refused where the folder holds anything else.
        run : Run, optional
            Threads or processes, progress, cancelling.

        Raises
        ------
        ParameterError
            where something else is at this path, or another recipe.
        MissingExtraError
            without zarr: ``pip install 'intarsia[giant]'``.
        ResourceError
            where the disk is full; the same call later goes on.
        """
        from .stream import stream
        from .zarrays import ZarrStore

        stream(ZarrStore.of(self, path, sides_of(shape), origin, chunk, force), executor, run_of(run))

    def to_tiff(
        self, path: str | os.PathLike[str], shape: Sides, *, origin: tuple[int, int] = (0, 0), tile: int = 512,
        executor: ExecutorLike = None, force: bool = False, run: Run | None = None,
    ) -> None:  # fmt: skip
        """Stream a window of any size into one tiled BigTIFF (zlib); otherwise as :meth:`to_zarr`.

        `tile` is the side of its tiles, a multiple of 16 px. Until it is whole it is called ``PATH.part``, with
        ``PATH.header`` beside it; checksums lie beside it as ``PATH.ledger``.
        """
        from .bigtiff import TiffStore
        from .stream import stream

        stream(TiffStore.of(self, path, sides_of(shape), origin, tile, force), executor, run_of(run))

    def to_tiles(
        self, path: str | os.PathLike[str], shape: Sides, *, origin: tuple[int, int] = (0, 0), tile: int = 256,
        executor: ExecutorLike = None, force: bool = False, run: Run | None = None,
    ) -> None:  # fmt: skip
        """Stream a window of any size into a folder of DeepZoom tiles (PNG); otherwise as :meth:`to_zarr`.

        Viewers open ``PATH/image.dzi``. Each level is the one below it, averaged by what its pixels mean.
        """
        from .deepzoom import TileStore
        from .stream import stream

        stream(TileStore.of(self, path, sides_of(shape), origin, tile, force), executor, run_of(run))


def weave(
    exemplar: ExemplarLike | Sequence[ExemplarLike],
    method: Method | Auto | str = AUTO_METHOD,
    seed: int = 0,
    *,
    blend: Blend | None = None,
) -> Weave:
    """Make an endless texture from an example; nothing is drawn before it is sliced.

    Parameters
    ----------
    exemplar : path, array, dict of arrays, Plane or Exemplar
        As for :func:`synthesize`.
    method : Method, Auto or str
        One that can make windows alone; ``auto`` chooses among them.
    seed : int
        0 to 2**64 - 1; the same seed gives the same texture, on any machine.
    blend : Blend, optional
        How pieces are joined; default: as the method means it.

    Raises
    ------
    ParameterError, InputError, MethodError
        where the method cannot make windows alone, or cannot serve this exemplar.
    """
    exemplars, seed = as_exemplars(exemplar), check_seed(seed)
    return woven(planned_windows(exemplars, method, blend), seed)


def planned_windows(exemplars: tuple[Exemplar, ...], method: Method | Auto | str, blend: Blend | None = None) -> Plan:
    """Decide by which method, with which parameters, windows of an endless plane are made, or refuse what cannot."""
    check_alike(exemplars)
    method = named(method)
    if isinstance(method, Auto):
        method = replace(method, needs=method.needs | {Ability.WINDOW})
    elif Ability.WINDOW not in method.supports:
        able = ", ".join(s for s in METHODS if Ability.WINDOW in method_class(s).supports)
        raise ParameterError(f"{method.slug} cannot make windows of an endless plane; choose one of {able}.")
    canvas = Canvas(2 * exemplars[0].height, 2 * exemplars[0].width, endless=True)  # its size is only one to think of
    return planned(Scene(exemplars, canvas), method, blend)


def woven(plan: Plan, seed: int) -> Weave:
    """Return the endless texture that is planned."""
    exemplars = plan.scene.exemplars
    return Weave(exemplars, cast(WindowMethod, plan.method), seed, plan.joined, exemplars[0].drawn[0])
