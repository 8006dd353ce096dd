"""Streaming a texture into a store by threads or a dask cluster; valid cells of a resumed store are kept.

Results are written in order and have the same bytes whoever renders. The task, with the analysed exemplar, is sent once
to every worker; then only boxes are sent, and encoded cells come back, so that one process writes all files, and
workers need no common disk. At most AHEAD cells per worker are in progress, so memory is bounded.
"""

from __future__ import annotations

import operator
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from functools import partial
from itertools import islice
from typing import Any

import numpy as np

from ..disk import peak_memory
from ..disk.atomic import failed
from ..foundation import InputError, ParameterError, ResourceError, called
from ..foundation.arrays import Array, Pair
from ..foundation.geometry import Box
from ..foundation.run import Run
from ..methods import traits
from .picture import Cell, EndlessPlane, Packer, Results, Store, checked, extra, sides_of

Task = Callable[[Cell], list[bytes]]

DaskLike = Any
"""None, "local", the address of a dask scheduler, or a dask client, whose type may not be installed."""

AHEAD = 2  # cells in progress for each worker
PATIENCE = 120  # s to wait for the first worker of a cluster


def by_threads(workers: int, task: Task, cells: Iterable[Cell]) -> Results:
    """Render cells by threads of this process."""
    todo = iter(cells)
    for cell in todo if workers == 1 else islice(todo, 1):  # the first fills the caches that the others share
        yield cell, task(cell)
    if workers > 1:
        pool = ThreadPoolExecutor(workers)
        try:
            yield from _windowed(todo, AHEAD * workers, lambda cell: pool.submit(task, cell))
        finally:
            pool.shutdown(cancel_futures=True)


def by_cluster(client: Any, task: Task, cells: Iterable[Cell]) -> Results:
    """Render cells by the workers of a dask cluster, which renders again what is lost with one of them."""
    distributed = extra("distributed")
    lost = (TimeoutError, distributed.KilledWorker, distributed.client.FutureCancelledError)
    try:
        sent = client.scatter(task, broadcast=True, hash=False, timeout=PATIENCE)
        submit = partial(client.submit, operator.call, sent, pure=False)
        yield from _windowed(iter(cells), AHEAD * max(sum(client.nthreads().values()), 1), submit)
    except (*lost, distributed.comm.CommClosedError) as e:
        raise ResourceError(
            f"the workers of the cluster died, or none answered for {PATIENCE} s ({type(e).__name__}); look at their "
            "logs."
        ) from None


def check_dask(given: DaskLike) -> None:
    """Raise, before any work, for what is no dask cluster, or if its packages are missing."""
    if given is None or hasattr(given, "scatter"):
        return
    if not isinstance(given, str) or (given != "local" and "://" not in given):
        raise ParameterError(
            f"dask={called(given)} is unknown; give local, the tcp:// address of a dask scheduler, or a dask client."
        )
    extra("distributed")


@contextmanager
def drawing(dask: DaskLike, run: Run) -> Iterator[Callable[[Task, Iterable[Cell]], Results]]:
    """Yield the function that renders cells in order; a client or cluster started here is closed afterwards."""
    check_dask(dask)
    if dask is None:
        yield partial(by_threads, run.workers)
    elif not isinstance(dask, str):
        yield partial(by_cluster, dask)
    else:
        distributed = extra("distributed")
        own = {"n_workers": run.workers, "threads_per_worker": 1, "dashboard_address": None}
        try:
            client = distributed.Client(**own) if dask == "local" else distributed.Client(dask, timeout=5)
        except (OSError, ValueError) as e:
            raise InputError(
                f"no dask scheduler answers at {dask} ({type(e).__name__}); start one with: dask scheduler"
            ) from None
        with client:
            yield partial(by_cluster, client)


def _windowed(cells: Iterator[Cell], most: int, submit: Callable[[Cell], Any]) -> Results:
    """Yield results in order, with at most `most` cells in progress."""
    under_way: deque[tuple[Cell, Any]] = deque()
    for cell in cells:
        under_way.append((cell, submit(cell)))
        if len(under_way) >= most:
            first, future = under_way.popleft()
            yield first, future.result()
    for first, future in under_way:
        yield first, future.result()


def array_of(texture: EndlessPlane, size: Any, chunks: Any, origin: Any) -> Any:
    """Return a window of a texture as a dask array; the texture is one node of its graph, sent once to a worker."""
    dask, arrays = extra("dask"), extra("dask.array")
    sides = sides_of(size)
    y, x = checked(texture, sides, origin)
    shape = texture.shape_of(*sides)
    wanted = chunks if isinstance(chunks, (tuple, list)) else (chunks, chunks)
    try:
        cut = arrays.core.normalize_chunks((*wanted[:2], *shape[2:]), shape, dtype=texture.dtype)
    except (ValueError, TypeError, NotImplementedError) as e:  # the last: dask's own word for chunks it cannot size
        raise ParameterError(f"chunks={chunks!r} do not suit {shape} ({e}); give a number of px.") from None
    return arrays.map_blocks(
        block, dask.delayed(texture, traverse=False), y, x, chunks=cut, dtype=texture.dtype,
        meta=np.empty((0,) * len(shape), texture.dtype),
    )  # fmt: skip


def block(texture: EndlessPlane, y: int, x: int, block_info: Any = None) -> Array:
    """Render a block of a dask array whose first pixel is (y, x) of the endless plane."""
    rows, columns = block_info[None]["array-location"][:2]
    return texture.draw(Box(rows[0], columns[0], rows[1], columns[1]).moved(y, x))


PER_PX, BETWEEN = 16, 140
"""Bytes of memory per px that is rendered: for map and weights, and the addition if pixels are interpolated."""

DRAWN = 1 << 22
"""Most px of the map that a worker holds at a time: 2048 x 2048."""


def drawn_and_packed(texture: EndlessPlane, origin: Pair, packer: Packer, cell: Cell) -> list[bytes]:
    """Render a cell and encode it; done by the workers."""
    pixels = texture.draw(cell.box.moved(*origin))
    return packer(pixels.reshape(*pixels.shape[:2], -1), cell)


def task_of(store: Store) -> Task:
    """Return the task of a worker."""
    return partial(drawn_and_packed, store.texture, store.origin, store.packer)


def memory_of(store: Store, workers: int) -> int:
    """Return an estimate, in bytes, of the peak memory of this process while `workers` threads fill a store."""
    return peak_memory() + store.held + min(workers, len(store.grid)) * _drawn(store)


def estimated(store: Store, workers: int) -> tuple[float, int]:
    """Return estimates of the seconds and the peak memory, in bytes, that `workers` threads need to fill a store.

    One cell is rendered to measure them; nothing is written.
    """
    task, cell = task_of(store), store.grid.cell(0)
    task(cell)
    began = time.perf_counter()
    task(cell)
    share = cell.box.height * cell.box.width / (store.grid.height * store.grid.width)
    return (time.perf_counter() - began) / workers / share, memory_of(store, workers - 1)  # one was measured


def _drawn(store: Store) -> int:
    """Return the memory of a worker while it renders a cell, in bytes."""
    box, texture = store.grid.cell(0).box, store.texture
    px, each = box.height * box.width, PER_PX + (0 if traits(texture.method).exact else BETWEEN)
    return int(min(px * texture.scale[1] ** 2, DRAWN) * each + px * 2 * texture.channels * texture.dtype.itemsize)


def stream(store: Store, dask: DaskLike, run: Run) -> None:
    """Fill and finish a store; the bytes are the same whoever renders, and however often it was interrupted."""
    try:
        fill(store, dask, run)
        finish(store)
    finally:
        store.close()


def fill(store: Store, dask: DaskLike, run: Run) -> None:
    """Render and write the missing cells of a store, which stays open."""
    total = len(store.grid)
    with _told(store):
        store.look()
        with drawing(dask, run) as drawn:
            missing = list(store.open())
            run.tick(total - len(missing), total)

            def counted(results: Results) -> Results:
                for done, result in enumerate(results, total - len(missing) + 1):
                    yield result
                    run.tick(done, total)

            with closing(drawn(task_of(store), map(store.grid.cell, missing))) as results:
                store.fill(counted(results), run)


def finish(store: Store) -> None:
    """Move a complete store to its path."""
    with _told(store):
        store.finish()


@contextmanager
def _told(store: Store) -> Iterator[None]:
    """Turn an OSError into a ResourceError of one line that says why a store could not be written."""
    try:
        yield
    except OSError as e:
        raise failed(store.path, e) from None
