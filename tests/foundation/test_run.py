"""A run: threads, progress, cancelling; nothing of it ever changes a pixel."""

from __future__ import annotations

import threading
import time

import pytest

import intarsia as ia
from intarsia.foundation.run import cores
from intarsia.testing import texture


def test_there_are_1_to_1024_threads_by_default_one_for_each_core_allowed() -> None:
    for threads in (0, -1, 1025):
        with pytest.raises(ia.ParameterError, match=f"threads={threads}"):
            ia.Run(threads=threads)
    assert ia.Run().workers == cores() >= 1
    assert ia.Run(threads=3).workers == 3


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_every_item_is_worked_on_once(threads: int) -> None:
    done: list[int] = []
    with ia.Run(threads).pool() as each:
        each(done.append, range(50))
        each(done.append, iter(range(50, 60)))
        each(done.append, [])
    assert sorted(done) == list(range(60))


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_an_error_in_a_worker_is_raised_where_the_work_was_asked_for(threads: int) -> None:
    """What is not begun by then is left."""
    begun: list[int] = []

    def fail(k: int) -> None:
        begun.append(k)
        if k >= 3:
            raise KeyError(k)

    with pytest.raises(KeyError, match="3"), ia.Run(threads).pool() as each:
        each(fail, range(99))
    assert len(begun) < 99


def test_of_several_errors_the_first_in_order_is_raised() -> None:
    barrier = threading.Barrier(2, timeout=20)

    def fail(k: int) -> None:
        barrier.wait()
        raise KeyError(k)

    with pytest.raises(KeyError, match="0"), ia.Run(2).pool() as each:
        each(fail, range(2))


def test_several_threads_really_work_at_the_same_time() -> None:
    barrier = threading.Barrier(3, timeout=20)
    with ia.Run(3).pool() as each:
        each(lambda _: barrier.wait(), range(3))


def test_a_crew_stays_for_all_pools() -> None:
    """The same threads serve one pool after another, and are gone at the end."""
    run, seen = ia.Run(2), set[int]()
    barrier = threading.Barrier(2, timeout=20)
    with run.crew() as crew:
        assert crew == run
        for _ in range(3):
            with crew.pool() as each:
                each(lambda _: seen.add(threading.get_ident()) or barrier.wait(), range(2))
        assert len(seen) == 2
        assert seen <= {t.ident for t in threading.enumerate()}
    assert seen & {t.ident for t in threading.enumerate()} == {threading.get_ident()}  # who asks works, too
    with ia.Run(1).crew() as crew, crew.pool() as each:
        assert set(each(lambda _: threading.get_ident(), range(3))) == {threading.get_ident()}


def test_a_pool_within_a_pool_waits_for_no_thread_that_is_not_free() -> None:
    with ia.Run(2).crew() as crew, crew.pool() as each:
        assert each(lambda k: each(lambda j: 10 * k + j, range(3)), range(4)) == [
            [10 * k + j for j in range(3)] for k in range(4)
        ]


def test_steps_are_told_before_cancelling_is_looked_at() -> None:
    event, told = threading.Event(), []
    run = ia.Run(step=lambda done, total, draft: told.append((done, total, draft)), cancel=event)
    run.tick(1, 4)
    event.set()
    with pytest.raises(ia.CancelledError, match="cancelled"):
        run.tick(2, 4, None)
    assert told == [(1, 4, None), (2, 4, None)]
    ia.Run().tick(0, 0)


def test_an_exception_in_the_step_ends_the_work() -> None:
    """What a callback raises comes out as it is, and the exemplar can be used again."""

    def step(done: int, total: int, draft: object) -> None:
        raise ZeroDivisionError

    e = ia.Exemplar.of(texture(30, 30, 3))
    method = ia.ImageQuilting(patch=12, overlap=4)
    with pytest.raises(ZeroDivisionError):
        ia.synthesize(e, 40, method, run=ia.Run(2, step))
    fresh = ia.synthesize(ia.Exemplar.of(texture(30, 30, 3)), 40, method)
    assert ia.synthesize(e, 40, method).map.digest == fresh.map.digest


def test_cancelling_from_another_thread_stops_soon() -> None:
    """Within a step; for a canvas of this size far below a second."""
    event = threading.Event()
    started = threading.Event()
    run = ia.Run(1, lambda done, total, draft: started.set() if done == 2 else None, event)
    stopped: list[float] = []

    def stop() -> None:
        started.wait(30)
        event.set()
        stopped.append(time.monotonic())

    thread = threading.Thread(target=stop)
    thread.start()
    with pytest.raises(ia.CancelledError):
        ia.synthesize(texture(64, 64, 3), 2000, ia.ImageQuilting(patch=16, overlap=5), run=run)
    ended = time.monotonic()
    thread.join()
    assert ended - stopped[0] < 2


def test_calls_from_many_threads_at_once_agree() -> None:
    """One exemplar, used by four threads at a time, nested pools and all."""
    e = ia.Exemplar.of(texture(36, 36, 3))
    method = ia.ImageQuilting(patch=12, overlap=4)
    want = [ia.synthesize(ia.Exemplar.of(texture(36, 36, 3)), 60, method, seed=k).map.digest for k in range(4)]
    got: dict[int, str] = {}

    def work(k: int) -> None:
        got[k] = ia.synthesize(e, 60, method, seed=k, run=ia.Run(2)).map.digest

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert [got[k] for k in range(4)] == want


def test_a_draft_is_the_map_so_far() -> None:
    """Progress shows a map that only fills up."""
    holes: list[int] = []

    def step(done: int, total: int, draft: object) -> None:
        assert draft is not None
        holes.append(int(draft().holes.sum()))

    ia.synthesize(texture(30, 30, 3), 40, ia.ImageQuilting(patch=12, overlap=4), run=ia.Run(2, step))
    assert holes[0] == 1600
    assert holes[-1] == 0
    assert holes == sorted(holes, reverse=True)
