"""Who draws the cells: threads, processes of this machine, or the workers of a dask cluster; results come in order.

A task is sent once to every worker, with the analysed exemplar in it; then only boxes go out, and packed pieces come
back, so that files are written by one process, and workers need no common disk. Few cells are under way at a time:
memory is bounded.
"""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import threading
import uuid
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from itertools import islice
from multiprocessing.reduction import ForkingPickler
from typing import Any, Protocol

import numpy as np

from ..arguments import called
from ..errors import InputError, MissingExtraError, ParameterError, ResourceError, said
from ..geometry import Box
from ..image import Array
from ..methods.base import Method
from ..params import functions_of
from ..run import Run
from .cells import Cell
from .picture import Picture, Results, checked

Task = Callable[[Cell], list[bytes]]
ExecutorLike = Any
"""None, the word or address of an executor, or a dask client: a type that is not installed cannot be named."""

CLIENT = ("scatter", "submit", "nthreads")  # what a dask client can do
AHEAD = 2  # cells under way for each worker
DEATHS = 3  # of workers one after another, without a result between them
PATIENCE = 120  # s, for the first worker of a cluster, and for the one that replaces a dead one


def extra(module: str) -> Any:
    """Import a module of the extra; MissingExtraError names what installs it."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as e:
        name = (e.name or module).partition(".")[0]
        raise MissingExtraError(f"{name} is not installed; run: pip install 'intarsia[giant]'") from None


class Executor(Protocol):
    """Somebody who carries a task out for many cells."""

    @property
    def workers(self) -> int:
        """How many cells are drawn at the same time."""

    def in_order(self, task: Task, cells: Iterable[Cell]) -> Results:
        """Yield every cell with its pieces, in the order given."""


@dataclass(frozen=True)
class Threads:
    """Threads of this process."""

    workers: int

    def in_order(self, task: Task, cells: Iterable[Cell]) -> Results:
        todo = iter(cells)
        for cell in islice(todo, 1):  # the first prepares what the others share
            yield cell, task(cell)
        if self.workers == 1:
            for cell in todo:
                yield cell, task(cell)
            return
        pool = ThreadPoolExecutor(self.workers)
        try:
            yield from _windowed(todo, AHEAD * self.workers, lambda cell: pool.submit(task, cell), Future.result)
        finally:
            pool.shutdown(cancel_futures=True)


@dataclass(frozen=True)
class Processes:
    """Processes of this machine; one that dies is replaced, and its cells are drawn again."""

    workers: int

    def in_order(self, task: Task, cells: Iterable[Cell]) -> Results:
        todo, deaths, rest = deque[Cell](), 0, iter(cells)  # todo: handed out, and not back yet
        todo.extend(islice(rest, 1))
        while todo:
            pool = ProcessPoolExecutor(self.workers, multiprocessing.get_context("spawn"), _hold, (task,))
            submit = partial(pool.submit, _held)  # type: ignore[call-arg]
            try:
                for cell, pieces in _windowed(_again(todo, rest), AHEAD * self.workers, submit, Future.result):
                    todo.popleft()
                    deaths = 0
                    yield cell, pieces
            except BrokenProcessPool:
                deaths += 1
                if deaths == DEATHS:
                    raise ResourceError(
                        f"{DEATHS} worker processes died one after another; use fewer (--threads), or guard the script "
                        "with if __name__ == '__main__'."
                    ) from None
            finally:
                pool.shutdown(cancel_futures=True)


@dataclass(frozen=True)
class Cluster:
    """The workers of a dask cluster, by a client of it; what dies with a worker is sent and drawn again."""

    client: Any

    @property
    def workers(self) -> int:
        return max(sum(int(n) for n in self.client.nthreads().values()), 1)

    def in_order(self, task: Task, cells: Iterable[Cell]) -> Results:
        distributed, deaths, rest = extra("distributed"), 0, iter(cells)
        lost = distributed.comm.CommClosedError  # a worker died while the task was sent to it
        died = (distributed.KilledWorker, distributed.client.FutureCancelledError, lost)
        todo = deque(islice(rest, 1))  # handed out, and not back yet
        while todo:
            try:
                sent = self.client.scatter(task, broadcast=True, hash=False, timeout=PATIENCE)
                submit = partial(self.client.submit, _carry_out, sent, pure=False, retries=DEATHS)
                for cell, pieces in _windowed(_again(todo, rest), AHEAD * self.workers, submit, _result):
                    todo.popleft()
                    deaths = 0
                    yield cell, pieces
            except TimeoutError:
                raise ResourceError(
                    f"no worker of the cluster answered for {PATIENCE} s; look at their logs, or start some."
                ) from None
            except died as e:  # dask hands cells to other workers itself, until none holds the task
                deaths += 1
                if deaths == DEATHS:
                    raise ResourceError(
                        f"the workers of the cluster died again and again ({type(e).__name__}); look at their logs."
                    ) from None


def check_executor(given: ExecutorLike) -> None:
    """Refuse, before any work, an executor that is unknown, or whose packages are missing."""
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
    """Refuse, before any work, functions that other processes of this machine could not find."""
    for name, field in functions_of(method).items() if isinstance(given, str) and given == "processes" else ():
        try:
            ForkingPickler.dumps(field.value)
        except Exception as e:  # whatever the function holds may fail in its own way
            raise ParameterError(
                f"the function {name} cannot be sent to other processes ({said(e)}); define it at the top of a module, "
                "or draw with threads."
            ) from e


@contextmanager
def executor_of(given: ExecutorLike, run: Run) -> Iterator[Executor]:
    """Understand who is to draw; what is started here is ended here."""
    check_executor(given)
    if given is None or given == "threads":
        yield Threads(run.workers)
    elif given == "processes":
        yield Processes(run.workers)
    elif isinstance(given, str):
        with _started(extra("distributed"), given, run) as client:
            yield Cluster(client)
    else:
        yield Cluster(given)


@contextmanager
def _started(distributed: Any, where: str, run: Run) -> Iterator[Any]:
    """A client of a cluster on this machine, or of one at an address."""
    if where == "local":
        with (
            distributed.LocalCluster(
                n_workers=run.workers, threads_per_worker=1, processes=True, dashboard_address=None
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield client
        return
    try:
        client = distributed.Client(where, timeout=5)
    except (OSError, ValueError) as e:
        raise InputError(
            f"no dask scheduler answers at {where} ({type(e).__name__}); start one with: dask scheduler"
        ) from None
    with client:
        yield client


def _windowed(
    cells: Iterator[Cell], most: int, submit: Callable[[Cell], Any], result: Callable[[Any], list[bytes]]
) -> Results:
    """Keep at most so many cells under way, and yield them in order."""
    under_way: deque[tuple[Cell, Any]] = deque()
    for cell in cells:
        under_way.append((cell, submit(cell)))
        if len(under_way) >= most:
            first, future = under_way.popleft()
            yield first, result(future)
    while under_way:
        first, future = under_way.popleft()
        yield first, result(future)


def _again(todo: deque[Cell], rest: Iterator[Cell]) -> Iterator[Cell]:
    """Hand out what was handed out before, then further cells, noting them."""
    yield from tuple(todo)
    for cell in rest:
        todo.append(cell)
        yield cell


_task: list[Task] = []


def _hold(task: Task) -> None:
    """Keep the task in a worker process, which ends when the process that started it does."""
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


def _result(future: Any) -> list[bytes]:
    pieces: list[bytes] = future.result()
    return pieces


def _carry_out(task: Task, cell: Cell) -> list[bytes]:
    return task(cell)


def array_of(texture: Picture, sides: tuple[int, int], chunks: Any, origin: Any) -> Any:
    """Return a window of a texture as a dask array; the texture is one entry of its graph, sent once to a worker."""
    dask, arrays = extra("dask"), extra("dask.array")
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


def block(texture: Picture, y: int, x: int, block_info: Any = None) -> Array:
    """Draw the block of a dask array that begins at (y, x) of the endless plane."""
    rows, columns = block_info[None]["array-location"][:2]
    return texture.draw(Box(rows[0], columns[0], rows[1], columns[1]).moved(y, x))
