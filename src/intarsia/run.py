"""How a synthesis runs: threads, progress, cancelling. Nothing here ever changes a pixel."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from threading import Event
from typing import Any, TypeVar

from .arguments import called, whole
from .errors import CancelledError, ParameterError

T = TypeVar("T")
Step = Callable[[int, int, Callable[[], Any] | None], object]
PART = 1000  # steps of a part of the work: however many its own are, those of the whole go on evenly


def cores() -> int:
    """Count the cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass
class Probe:
    """A question to a run: how well did every patch of the exemplar fit when output pixel (y, x) was filled?

    ``maps``: the answer, one float32 array for every exemplar, over the first pixels of patches, each in the pose that
    fits best; root mean squares on the 0..1 scale, -1 where no patch may begin. None until then.
    """

    y: int
    x: int
    maps: list[Any] | None = None


@dataclass(frozen=True)
class Run:
    """Threads, progress and cancelling of one piece of work.

    Parameters
    ----------
    threads : int, optional
        Worker threads, at least 1; by default one for each core allowed. Never changes a byte of the result.
    step : callable, optional
        Called as ``step(done, total, draft)`` between units of work, from the calling thread; ``draft()`` makes
        the map as far as it has grown (``None`` where a stage has no map).
    cancel : threading.Event, optional
        Once set, the work ends with :class:`~intarsia.errors.CancelledError` at the next unit.
    notes : list of str
        Methods add here, in one line each, what the user should know of this run.
    probe : Probe, optional
        A question that methods answer which lay patches by search.
    """

    threads: int | None = None
    step: Step | None = None
    cancel: Event | None = None
    notes: list[str] = field(default_factory=list, compare=False)
    probe: Probe | None = None

    def __post_init__(self) -> None:
        try:
            threads = None if self.threads is None else whole(self.threads)
        except ValueError:
            threads = 0
        if threads is not None and not 1 <= threads <= 1024:
            raise ParameterError(f"threads={called(self.threads)}: give 1 to 1024, or leave it out for one a core.")
        object.__setattr__(self, "threads", threads)
        if self.step is not None and not callable(self.step):
            raise ParameterError(f"step is {called(self.step)}; give a function of (done, total, draft).")
        if self.cancel is not None and not hasattr(self.cancel, "is_set"):
            raise ParameterError(f"cancel is {called(self.cancel)}; give a threading.Event.")

    @property
    def workers(self) -> int:
        """The number of threads to use."""
        return self.threads or cores()

    def tick(self, done: int, total: int, draft: Callable[[], Any] | None = None) -> None:
        """Report progress, and stop here if the caller asked for it."""
        if self.step is not None:
            self.step(done, total, draft)
        self.check()

    def part(self, number: int, parts: int) -> Run:
        """Return the run of a part of the work, of so many that take as long: it counts to PART, in the whole."""
        step = self.step
        if step is None:
            return self

        def counted(done: int, total: int, draft: Callable[[], Any] | None) -> None:
            step(number * PART + PART * done // max(total, 1), parts * PART, draft)

        return replace(self, step=counted)

    def drafting(self, make: Callable[[Any], Any]) -> Run:
        """Return the run of a part of the work that drafts something else, of which `make` makes a map."""
        step = self.step
        if step is None:
            return self

        def made(done: int, total: int, draft: Callable[[], Any] | None) -> None:
            step(done, total, None if draft is None else lambda: make(draft()))

        return replace(self, step=made)

    def check(self) -> None:
        """Stop here if the caller asked for it: between parts of a unit, which are no progress to speak of."""
        if self.cancel is not None and self.cancel.is_set():
            raise CancelledError("cancelled; nothing was written.")

    @contextmanager
    def pool(self) -> Iterator[Callable[[Callable[[T], Any], Iterable[T]], list[Any]]]:
        """Yield ``each(function, items)``: what the function makes of every item, in order, in parallel if allowed."""
        if self.workers == 1:
            yield _in_turn
            return
        with ThreadPoolExecutor(self.workers) as executor:

            def each(function: Callable[[T], Any], items: Iterable[T]) -> list[Any]:
                items = list(items)
                return _in_turn(function, items) if len(items) < 2 else list(executor.map(function, items))

            yield each


def run_of(run: Run | None) -> Run:
    """Return the run that was given, or the usual one; ParameterError for anything else."""
    if run is not None and not isinstance(run, Run):
        raise ParameterError(f"run is {called(run)}; give a Run, such as Run(threads=2).")
    return run or Run()


def _in_turn(function: Callable[[T], Any], items: Iterable[T]) -> list[Any]:
    return [function(item) for item in items]
