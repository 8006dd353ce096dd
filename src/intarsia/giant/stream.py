"""Streaming a texture into a store by threads, processes or a dask cluster; valid cells of a resumed store are kept.

Results are written in order and have the same bytes with every executor. The task, with the analysed exemplar, is sent
once to every worker; then only boxes are sent, and encoded cells come back, so that one process writes all files, and
workers need no common disk. At most AHEAD cells per worker are in progress, so memory is bounded.
"""

from __future__ import annotations

import errno
import multiprocessing
import operator
import os
import signal
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from itertools import islice
from multiprocessing.reduction import ForkingPickler
from typing import Any

import numpy as np

from ..disk import peak_memory
from ..foundation import InputError, ParameterError, ResourceError, called, said
from ..foundation.arrays import Array, Pair
from ..foundation.geometry import Box
from ..foundation.params import functions_of
from ..foundation.run import Run
from ..methods import Method, traits
from .exports import BufferedStore, TiffStore, TileStore
from .picture import Cell, EndlessPlane, Packer, Results, Store, checked, extra, sides_of
from .zarrays import ZarrStore

Task = Callable[[Cell], list[bytes]]
Submit = Callable[[Cell], Any]
"""Submits a cell; returns a future of its pieces."""

ExecutorLike = Any
"""None, the name or address of an executor, or a dask client, whose type may not be installed."""

CLIENT = ("scatter", "submit", "nthreads")  # methods by which a dask client is recognised
AHEAD = 2  # cells in progress for each worker
DEATHS = 3  # workers that die in succession, without a result between them, until the work fails
PATIENCE = 120  # s to wait for the first worker of a cluster, and for the one that replaces a dead one


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


def by_processes(workers: int, task: Task, cells: Iterable[Cell]) -> Results:
    """Render cells by processes of this machine; one that dies is replaced, and its cells are rendered again."""

    @contextmanager
    def begun() -> Iterator[Submit]:
        pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _hold, (task,))
        try:
            yield partial(pool.submit, _held)  # type: ignore[call-arg]
        finally:
            pool.shutdown(cancel_futures=True)

    return _drawn_again(
        cells, workers, begun, BrokenProcessPool,
        f"{DEATHS} worker processes died one after another; use fewer (--threads), or guard the script with "
        "if __name__ == '__main__'.",
    )  # fmt: skip


def by_cluster(client: Any, task: Task, cells: Iterable[Cell]) -> Results:
    """Render cells by the workers of a dask cluster; cells lost with a worker are rendered again."""

    @contextmanager
    def begun() -> Iterator[Submit]:
        try:
            sent = client.scatter(task, broadcast=True, hash=False, timeout=PATIENCE)
        except TimeoutError:
            raise ResourceError(
                f"no worker of the cluster answered for {PATIENCE} s; look at their logs, or start some."
            ) from None
        yield partial(client.submit, operator.call, sent, pure=False, retries=DEATHS)

    distributed = extra("distributed")
    lost = distributed.comm.CommClosedError  # a worker died while the task was sent to it
    died = (distributed.KilledWorker, distributed.client.FutureCancelledError, lost)
    # dask hands cells to other workers itself, until none holds the task
    why = "the workers of the cluster died again and again ({}); look at their logs."
    return _drawn_again(cells, max(sum(client.nthreads().values()), 1), begun, died, why)


def _drawn_again(
    cells: Iterable[Cell], workers: int, begun: Callable[[], AbstractContextManager[Submit]], died: Any, why: str
) -> Results:
    """Render cells by workers; when one dies, restart with the cells that were submitted and not returned."""
    todo, deaths, rest = deque[Cell](), 0, iter(cells)
    todo.extend(islice(rest, 1))
    while todo:
        try:
            with begun() as submit:
                for cell, pieces in _windowed(_again(todo, rest), AHEAD * workers, submit):
                    todo.popleft()
                    deaths = 0
                    yield cell, pieces
        except died as e:
            deaths += 1
            if deaths == DEATHS:
                raise ResourceError(why.format(type(e).__name__)) from None


def check_executor(given: ExecutorLike) -> None:
    """Raise, before any work, for an unknown executor, or one whose packages are missing."""
    known = given is None or (isinstance(given, str) and given in ("threads", "processes"))
    if known or all(hasattr(given, name) for name in CLIENT):
        return
    if not isinstance(given, str) or (given != "local" and "://" not in given):
        raise ParameterError(
            f"executor={called(given)} is unknown; give threads, processes, local, the tcp:// address of a dask "
            "scheduler, or a dask client."
        )
    extra("distributed")


def check_sendable(method: Method, given: ExecutorLike) -> None:
    """Raise, before any work, for functions among the parameters that cannot be pickled for other processes."""
    sent = functions_of(method) if isinstance(given, str) and given == "processes" else {}
    for name, function in sent.items():
        try:
            ForkingPickler.dumps(function.value)
        except Exception as e:  # whatever the function holds may fail in its own way
            raise ParameterError(
                f"the function {name} cannot be sent to other processes ({said(e)}); define it at the top of a module, "
                "or draw with threads."
            ) from e


@contextmanager
def executor_of(given: ExecutorLike, run: Run) -> Iterator[Callable[[Task, Iterable[Cell]], Results]]:
    """Yield the function that renders cells in order for an executor; a cluster started here is closed afterwards."""
    check_executor(given)
    if given is None or given == "threads":
        yield partial(by_threads, run.workers)
    elif given == "processes":
        yield partial(by_processes, run.workers)
    elif isinstance(given, str):
        with ExitStack() as stack:
            where = given
            if given == "local":
                kind = extra("distributed").LocalCluster
                options = {"threads_per_worker": 1, "processes": True, "dashboard_address": None}
                where = stack.enter_context(kind(n_workers=run.workers, **options))
            yield partial(by_cluster, stack.enter_context(_client_at(where)))
    else:
        yield partial(by_cluster, given)


def _client_at(where: Any) -> Any:
    """Return a client of a dask cluster, or of the one at an address."""
    try:
        return extra("distributed").Client(where, timeout=5)
    except (OSError, ValueError) as e:
        raise InputError(
            f"no dask scheduler answers at {where} ({type(e).__name__}); start one with: dask scheduler"
        ) from None


def _windowed(cells: Iterator[Cell], most: int, submit: Submit) -> Results:
    """Yield results in order, with at most `most` cells in progress."""
    under_way: deque[tuple[Cell, Any]] = deque()
    for cell in cells:
        under_way.append((cell, submit(cell)))
        if len(under_way) >= most:
            first, future = under_way.popleft()
            yield first, future.result()
    for first, future in under_way:
        yield first, future.result()


def _again(todo: deque[Cell], rest: Iterator[Cell]) -> Iterator[Cell]:
    """Yield the cells in `todo`, then those of `rest`, each of which is appended to `todo` first."""
    yield from tuple(todo)
    for cell in rest:
        todo.append(cell)
        yield cell


_task: list[Task] = []


def _hold(task: Task) -> None:
    """Store the task in a worker process, which exits when its parent does."""
    _task[:] = [task]
    with suppress(ValueError):
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides when to stop
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_die_with, args=(parent,), daemon=True).start()


def _die_with(parent: Any) -> None:
    parent.join()
    os._exit(1)


def _held(cell: Cell) -> list[bytes]:
    return _task[0](cell)


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
    name = f"weave-{texture.digest[:32]}"
    if functions_of(texture.method):  # a recipe without a box does not tell them apart: no block is another's
        name += f"-{uuid.uuid4().hex}"
    return arrays.map_blocks(
        block, dask.delayed(texture, name=name, traverse=False), y, x,
        name=f"{name}-{y}-{x}-{dask.base.tokenize(cut)[:16]}", chunks=cut, dtype=texture.dtype,
        meta=np.empty((0,) * len(shape), texture.dtype),
    )  # fmt: skip


def block(texture: EndlessPlane, y: int, x: int, block_info: Any = None) -> Array:
    """Render a block of a dask array whose first pixel is (y, x) of the endless plane."""
    rows, columns = block_info[None]["array-location"][:2]
    return texture.draw(Box(rows[0], columns[0], rows[1], columns[1]).moved(y, x))


STORES: dict[str, tuple[type[Store], int]] = {
    "zarr": (ZarrStore, 512),
    "tiff": (TiffStore, 512),
    "tiles": (TileStore, 256),
    "picture": (BufferedStore, 0),
}
"""Name -> the class of the store, and the default side of its chunks or tiles; 0: it has none."""


PER_PX, BETWEEN = 16, 140
"""Bytes of memory per px that is rendered: for map and weights, and the addition if pixels are interpolated."""

DRAWN = 1 << 22
"""Most px of the map that a worker holds at a time: 2048 x 2048."""


@dataclass(frozen=True)
class DrawnAndPacked:
    """The task of a worker: render a cell and encode it."""

    texture: EndlessPlane
    origin: Pair
    packer: Packer

    def __call__(self, cell: Cell) -> list[bytes]:
        pixels = self.texture.draw(cell.box.moved(*self.origin))
        return self.packer(pixels.reshape(*pixels.shape[:2], -1), cell)


def memory_of(store: Store, workers: int) -> int:
    """Return an estimate, in bytes, of the peak memory of this process while `workers` threads fill a store."""
    return peak_memory() + store.held + min(workers, len(store.grid)) * _drawn(store)


def estimated(store: Store, workers: int) -> tuple[float, int]:
    """Return estimates of the seconds and the peak memory, in bytes, that `workers` need to fill a store.

    One cell is rendered to measure them; nothing is written.
    """
    task, cell = DrawnAndPacked(store.texture, store.origin, store.packer), store.grid.cell(0)
    task(cell)
    began = time.perf_counter()
    pieces = task(cell)
    spent, packed = time.perf_counter() - began, sum(map(len, pieces))
    share = cell.box.height * cell.box.width / (store.grid.height * store.grid.width)
    others = min(workers, len(store.grid)) - 1  # the first was measured just now
    memory = peak_memory() + store.held + others * _drawn(store) + AHEAD * (others + 1) * packed
    return (spent / workers + store.packing(cell, pieces)) / share, memory


def _drawn(store: Store) -> int:
    """Return the memory of a worker while it renders a cell, in bytes."""
    box, texture = store.grid.cell(0).box, store.texture
    px, each = box.height * box.width, PER_PX + (0 if traits(texture.method).exact else BETWEEN)
    return int(min(px * texture.scale[1] ** 2, DRAWN) * each + px * 2 * texture.channels * texture.dtype.itemsize)


def stream(store: Store, executor: ExecutorLike, run: Run) -> None:
    """Fill and finish a store; the bytes are the same with every executor, and however often it was interrupted."""
    try:
        fill(store, executor, run)
        finish(store)
    finally:
        store.close()


def fill(store: Store, executor: ExecutorLike, run: Run) -> None:
    """Render and write the missing cells of a store, which stays open."""
    total = len(store.grid)
    with as_resource_error(store):
        store.look()
        check_sendable(store.texture.method, executor)
        with executor_of(executor, run) as drawn:
            missing = list(store.open())
            run.tick(total - len(missing), total)
            task = DrawnAndPacked(store.texture, store.origin, store.packer)

            def counted(results: Results) -> Results:
                for done, result in enumerate(results, total - len(missing) + 1):
                    yield result
                    run.tick(done, total)

            with closing(drawn(task, map(store.grid.cell, missing))) as results:
                store.fill(counted(results), run)


def finish(store: Store) -> None:
    """Move a complete store to its path."""
    with as_resource_error(store):
        store.finish()


@contextmanager
def as_resource_error(store: Store) -> Iterator[None]:
    """Turn an OSError into a ResourceError of one line that says why a store could not be written."""
    try:
        yield
    except OSError as e:
        if e.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            after = "goes on" if store.resumes else "begins anew"
            raise ResourceError(
                f"there is no room for {store.path}; free some space, then the same command {after}."
            ) from None
        reason = (e.strerror or str(e)).lower()
        raise ResourceError(f"{store.path} cannot be written ({reason}); name another place.") from None
