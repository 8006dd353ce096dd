"""Endless textures: random access to any window, and streaming of pictures larger than memory to disk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

from ..choosing.auto import Auto
from ..disk import check_fits, peak_memory
from ..disk.atomic import PathLike
from ..foundation import AUTO_METHOD, ParameterError
from ..foundation.arrays import Array, Pair
from ..foundation.blend import Blend
from ..foundation.run import Run, check_seed, run_of
from ..methods import METHODS, Ability, Method, WindowMethod, method_class
from ..model import Exemplar
from ..model.canvas import Canvas
from ..rendering.render import check_alike
from ..synthesis import ExemplarLike, Plan, Scene, as_exemplars, named, planned
from .exports import TiffStore
from .picture import SIDE, EndlessPlane, box_of
from .stream import DaskLike, array_of, stream
from .zarrays import ZarrStore

__all__ = ["Weave", "weave"]


Sides = int | Pair


class Weave(EndlessPlane):
    """An endless texture with random access: ``w[y0:y1, x0:x1]`` renders any window as an array (h, w) or (h, w, C).

    The pixels of a window do not depend on windows rendered before.

    Attributes
    ----------
    exemplars : tuple of Exemplar
        What it is synthesised from.
    method : WindowMethod
        With every parameter decided.
    seed : int
        0 to 2**64 - 1.
    blend : Blend
        How pieces are blended.
    name : str
        The plane that is rendered; :meth:`plane` gives the others.
    """

    def __repr__(self) -> str:
        words = f"{self.method.slug}, seed {self.seed}, {self.name}: {self.dtype} x {self.channels}"
        return f"<endless texture by {words}; slice it, or stream it>"

    def __getitem__(self, key: Any) -> Array:
        """Render a window, of the dtype of the plane; rows and columns are px of the plane and may be negative.

        They may be as far from the origin as 2**40 px of the map.

        Raises ParameterError for anything but two slices of whole numbers that are not empty, ResourceError if the
        window does not fit into memory.
        """
        box = box_of(key)
        check_fits(
            peak_memory() + box.height * box.width * self.channels * self.dtype.itemsize,
            f"a window of {box.width}x{box.height} px",
            "stream it with texture.to_zarr(path, shape, origin=...), to_tiff or to_dask, or slice less",
        )
        self.map_box(box)
        if box.height * box.width <= 2 * SIDE * SIDE:
            return self.draw(box)
        with Run().pool() as each:
            return self._filled(box, SIDE, self.draw, each)

    def to_dask(self, shape: Sides, chunks: Any = SIDE, origin: Pair = (0, 0)) -> Any:
        """Return a dask array whose blocks are windows, rendered when it is computed.

        Parameters
        ----------
        shape : int or (height, width)
            Size in px of the plane.
        chunks : int, (rows, columns), or any other form that dask takes
            Sizes of the blocks in px; default 1024.
        origin : (y, x)
            The pixel of the endless plane that comes first, default (0, 0).

        Returns
        -------
        dask.array.Array
            (height, width) or (height, width, C).

        Raises
        ------
        ParameterError
            for a shape, chunks or an origin that are not possible.
        MissingExtraError
            without dask: ``pip install 'intarsia[giant]'``.
        """
        return array_of(self, shape, chunks, origin)

    def to_zarr(
        self, path: PathLike, shape: Sides, *, origin: Pair = (0, 0), chunk: int = 512, dask: DaskLike = None,
        run: Run | None = None,
    ) -> None:  # fmt: skip
        """Stream a window of any size into a zarr array (version 3); an interrupted call is resumed.

        Parameters
        ----------
        path : path
            The folder of the array.
        shape : int or (height, width)
            Size in px of the plane.
        origin : (y, x)
            The pixel of the endless plane that comes first, default (0, 0).
        chunk : int
            Side of the chunks, 16 to 8192 px, default 512; small ones share a file (shard) of up to 1024 px a side.
        dask : "local", "tcp://...", or a dask client, optional
            The workers that render the chunks; never changes a pixel. Default: threads of this process. ``local``
            starts a cluster of processes on this machine.
        run : Run, optional
            Threads, progress, cancelling.

        Raises
        ------
        ParameterError
            if something else is at this path, or an array of another recipe; for arguments out of range.
        MissingExtraError
            without zarr: ``pip install 'intarsia[giant]'``.
        ResourceError
            if the disk is full or cannot be written; the same call resumes later.
        """
        stream(ZarrStore.of(self, path, shape, origin, chunk), dask, run_of(run))

    def to_tiff(
        self, path: PathLike, shape: Sides, *, origin: Pair = (0, 0), tile: int = 512,
        dask: DaskLike = None, force: bool = False, run: Run | None = None,
    ) -> None:  # fmt: skip
        """Stream a window of any size into one tiled BigTIFF (zlib), which appears when it is complete.

        An interrupted call starts over. Arguments and errors are those of :meth:`to_zarr`, but for:

        Parameters
        ----------
        path : path
            The file.
        tile : int
            Side of its tiles, 16 to 4096 px, a multiple of 16; default 512.
        force : bool
            Replace an existing file, default False.
        """
        stream(TiffStore.of(self, path, shape, origin, tile, force), dask, run_of(run))


def weave(
    exemplar: ExemplarLike | Sequence[ExemplarLike],
    method: Method | Auto | str = AUTO_METHOD,
    seed: int = 0,
    *,
    blend: Blend | None = None,
) -> Weave:
    """Return an endless texture from an example, with random access: ``w[y0:y1, x0:x1]`` renders a window.

    Parameters
    ----------
    exemplar : as for :func:`synthesize`
        A path, array, dict of arrays, Plane or Exemplar.
    method : Method, Auto or str
        A method with the ability ``window``; ``"auto"``, the default, chooses among them.
    seed : int
        0 to 2**64 - 1, default 0; the same seed gives the same texture, on any machine.
    blend : Blend, optional
        How pieces are blended; default: that of the method.

    Returns
    -------
    Weave
        Nothing is rendered yet, except what the choice of method and parameters needs.

    Raises
    ------
    ParameterError
        if the method cannot compute single windows.
    InputError
        if an exemplar cannot be read, or has no usable pixels.
    MethodError
        if the method cannot serve this exemplar.
    """
    exemplars, seed = as_exemplars(exemplar), check_seed(seed)
    return woven(planned_windows(exemplars, method, blend), seed)


def planned_windows(exemplars: tuple[Exemplar, ...], method: Method | Auto | str, blend: Blend | None = None) -> Plan:
    """Return the plan (method with parameters, blend) for windows of an endless plane.

    Raises ParameterError for a method without the ability `window`, and what `planned` raises.
    """
    check_alike(exemplars)
    method = named(method)
    if isinstance(method, Auto):
        method = replace(method, needs=method.needs | {Ability.WINDOW})
    elif Ability.WINDOW not in method.supports:
        able = ", ".join(s for s in METHODS if Ability.WINDOW in method_class(s).supports)
        raise ParameterError(f"{method.slug} cannot make windows of an endless plane; choose one of {able}.")
    canvas = Canvas(2 * exemplars[0].height, 2 * exemplars[0].width, endless=True)  # a typical size, to choose by
    return planned(Scene(exemplars, canvas), method, blend)


def woven(plan: Plan, seed: int) -> Weave:
    """Return the endless texture of a plan."""
    exemplars = plan.scene.exemplars
    return Weave(exemplars, cast(WindowMethod, plan.method), seed, plan.joined, exemplars[0].pictures[0])
