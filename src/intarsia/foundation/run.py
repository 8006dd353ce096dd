"""Threads, progress and cancelling of a run, none of which changes a pixel; and counter-based random numbers.

A random number is a hash of its counters: the same (seed, stage, level, y, x) gives the same 64 bits on every machine,
in any order, from any thread. Coordinates may be negative and as large as 2**63. The package has no other source of
random numbers.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from threading import Event
from typing import TYPE_CHECKING, Any, TypeVar

from . import CancelledError, Pair, ParameterError, called, whole, whole_within

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


T = TypeVar("T")
Draft = Callable[[], Any] | None
Step = Callable[[int, int, Draft], object]
PART = 1000  # steps reported for each part of the work, however many it has itself, so that parts count equally


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Run:
    """Threads, progress and cancelling of one piece of work.

    Parameters
    ----------
    threads : int, optional
        Worker threads, 1 to 1024; default: one for each core that the process may use. Never changes a byte of the
        result.
    step : callable, optional
        Called as ``step(done, total, draft)`` between units of work, from the calling thread; ``draft()`` returns
        the map as far as it is filled (``None`` if a stage has no map).
    cancel : threading.Event, optional
        Once set, the work ends with :class:`~intarsia.foundation.CancelledError` at the next unit.
    notes : list of str
        Methods append one-line notes for the user.

    Raises
    ------
    ParameterError
        for a value out of range.
    """

    threads: int | None = None
    step: Step | None = None
    cancel: Event | None = None
    notes: list[str] = field(default_factory=list, compare=False)
    _crew: ThreadPoolExecutor | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.threads is not None:
            unit = "threads, or leave it out for one a core"
            object.__setattr__(self, "threads", whole_within("threads", self.threads, 1, 1024, unit))
        if self.step is not None and not callable(self.step):
            raise ParameterError(f"step is {called(self.step)}; give a function of (done, total, draft).")
        if self.cancel is not None and not hasattr(self.cancel, "is_set"):
            raise ParameterError(f"cancel is {called(self.cancel)}; give a threading.Event.")

    @property
    def workers(self) -> int:
        """The number of threads to use."""
        return self.threads or cores()

    def tick(self, done: int, total: int, draft: Draft = None) -> None:
        """Report progress, then raise CancelledError if the caller asked to stop."""
        if self.step is not None:
            self.step(done, total, draft)
        self.check()

    def part(self, number: int, parts: int) -> Run:
        """Return a run for part `number` of `parts` equal ones; its progress is scaled to PART steps."""
        return self._stepping(
            lambda done, total, draft: (number * PART + PART * done // max(total, 1), parts * PART, draft)
        )

    def drafting(self, make: Callable[[Any], Any]) -> Run:
        """Return a run for a part of the work whose drafts are no maps; `make` turns them into maps."""
        return self._stepping(
            lambda done, total, draft: (done, total, None if draft is None else lambda: make(draft()))
        )

    def _stepping(self, change: Callable[[int, int, Draft], tuple[int, int, Draft]]) -> Run:
        """Return a run that passes `change(done, total, draft)` to `step`."""
        step = self.step
        return self if step is None else replace(self, step=lambda *reported: step(*change(*reported)))

    def check(self) -> None:
        """Raise CancelledError if the caller asked to stop; called within a unit of work, reports no progress."""
        if self.cancel is not None and self.cancel.is_set():
            raise CancelledError("cancelled; nothing was written.")

    @contextmanager
    def pool(self) -> Iterator[Callable[[Callable[[T], Any], Iterable[T]], list[Any]]]:
        """Yield ``each(function, items)``, which returns the results in order, computed in parallel if allowed."""
        if self.workers == 1:
            yield lambda function, items: list(map(function, items))
            return
        with nullcontext(self._crew) if self._crew else ThreadPoolExecutor(self.workers - 1) as others:
            yield lambda function, items: _shared(function, list(items), others, self.workers - 1)

    @contextmanager
    def crew(self) -> Iterator[Run]:
        """Yield this run with a persistent thread pool, which all calls of :meth:`pool` use until the block ends."""
        with ThreadPoolExecutor(max(self.workers - 1, 1)) as others:
            yield replace(self, _crew=others)


def run_of(run: Run | None) -> Run:
    """Return the given run, or a default one; ParameterError for anything else."""
    if run is not None and not isinstance(run, Run):
        raise ParameterError(f"run is {called(run)}; give a Run, such as Run(threads=2).")
    return run or Run()


def _shared(function: Callable[[T], Any], items: list[T], others: ThreadPoolExecutor, most: int) -> list[Any]:
    """Return the results for all items, computed by this thread and free ones of the pool; raise the first error."""
    made, errors, rest = [None] * len(items), dict[int, BaseException](), iter(range(len(items)))

    def work() -> None:
        for k in rest:
            try:
                made[k] = function(items[k])
            except BaseException as error:  # is raised below, by the thread that asked
                errors[k] = error
                for _ in rest:
                    pass

    helping = [others.submit(work) for _ in range(min(most, len(items) - 1))]
    work()
    wait([each for each in helping if not each.cancel()])
    if errors:
        raise errors[min(errors)]
    return made


MASK = (1 << 64) - 1  # the low 64 bits
STEP = 0x9E3779B97F4A7C15  # the increment of splitmix64: 2**64 divided by the golden ratio
SEED_LIMIT = 1 << 64  # seeds are below it


def draw(seed: int, stage: int, level: int = 0, y: int = 0, x: int = 0) -> int:
    """Return 64 random bits, a hash of the five numbers (splitmix64 finaliser)."""
    state = seed_state(seed, stage, level)
    for word in (y, x):
        state = _mix(((state ^ (word & MASK)) + STEP) & MASK)
    return state


def draw_many(seed: int, stage: int, level: int, at: Sequence[Pair] | NDArray[np.int64]) -> list[int]:
    """Return ``draw(seed, stage, level, y, x)`` for many places (y, x) at once."""
    import numpy as np

    place = np.array(at, np.int64).reshape(-1, 2).astype(np.uint64)  # two's complement, as in draw
    state = np.full(len(place), seed_state(seed, stage, level), np.uint64)
    for word in place.T:
        state = _mix((state ^ word) + np.uint64(STEP))
    drawn: list[int] = state.tolist()
    return drawn


def seed_state(seed: int, stage: int, level: int) -> int:
    """Return the state of a draw before y and x are mixed in."""
    state: int = _mix((seed ^ 0x6A09E667F3BCC909) & MASK)  # so that seed and stage are not interchangeable
    for word in (stage, level):
        state = _mix(((state ^ (word & MASK)) + STEP) & MASK)
    return state


def below(n: int, bits: int) -> int:
    """Map 64 random bits to a number in 0 .. n-1 (n at most 2**32; the bias is below 2**-32)."""
    return ((bits >> 32) * n) >> 32


def deck(count: int, seed: int, stage: int, level: int, y: int, x: int) -> list[int]:
    """Return the numbers below `count` in random order (Fisher-Yates shuffle), seeded by a place.

    Entry k is swapped with one that is drawn on level ``level + k``.
    """
    order = list(range(count))
    for k in range(count - 1, 0, -1):
        other = below(k + 1, draw(seed, stage, level + k, y, x))
        order[k], order[other] = order[other], order[k]
    return order


def _mix(z: Any) -> Any:
    # The finaliser of splitmix64 (Steele, Lea and Flood 2014).
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
    return z ^ (z >> 31)


def check_seed(seed: int) -> int:
    """Return the seed as an int; ParameterError if it is not from 0 to 2**64 - 1."""
    try:
        number = whole(seed)
    except ValueError:
        number = -1
    if not 0 <= number < SEED_LIMIT:
        raise ParameterError(f"seed={called(seed)} is no whole number from 0 to 2**64 - 1; choose one, such as 7.")
    return number
