"""The job queue: states, progress, cancelling and restart of jobs.

A second process runs what the first one would not run at once, but no second long job; slow methods have their own.
"""

from __future__ import annotations

import asyncio
import os
import re
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from starlette.exceptions import HTTPException

from ..foundation import AUTO_METHOD, IntarsiaError
from .pictures import Drafts
from .processes import FailedError, Process
from .requests import LIMITS, Words, asked_of, result_of, words_of
from .store import OPEN, Events, Row, Store, digest

PREPARED = 1 << 20  # px: larger exemplars are not analysed beforehand
SLOW = ("efros-leung",)
"""Methods that take minutes where others take seconds: their jobs start when no other waits, and delay none."""

LONG = (*SLOW, "wei-levoy", "ashikhmin", "segment-based")
SMALL = 1 << 19  # px: larger pictures, and those of these methods, take more than a few seconds

TRIAL = ("--size=512", "--output=out.png", "--json")  # options of growing an exemplar before a job comes
CANCELLED = 130  # exit code
LOOKING = "look"  # stage of a job that takes over an analysis
CALM = 1.5  # s after the start in which nothing is prepared: a page that comes has the machine for itself
PATIENCE = 3.0  # s after which a worker that does not stop is killed


class Jobs:
    """All jobs, and the worker processes that run them."""

    def __init__(self, store: Store, events: Events, beside: Process, drafts: Drafts) -> None:
        self.store, self.events, self.beside, self.drafts = store, events, beside, drafts
        self.worker, self.second, self.slow = Process(nice=5), Process(nice=5), Process(nice=10)  # drafts come first
        self.previews: dict[str, tuple[int, bytes]] = {}
        self.warmth: Row = {"done": 0, "total": 1}
        self._running: dict[str, Process] = {}
        self._live: dict[str, Row] = {}  # progress of running jobs, which is not stored
        self._cancelled: set[str] = set()
        self._to_prepare: str | None = None
        self._preparing: str | None = None
        self._warming = self._hurry = False  # hurry: a job came meanwhile
        self._warmed: int | None = 0  # pid of the process that has all kernels
        self._prepared: deque[str] = deque(maxlen=4)  # exemplars that the worker has analysed, as many as it keeps
        self._wakes = [asyncio.Event() for _ in range(3)]
        self._to_draft: asyncio.LifoQueue[Row] = asyncio.LifoQueue()
        self._tasks = list[asyncio.Task[Any]]()
        self._to_score: asyncio.Queue[str] = asyncio.Queue()

    # for the routes

    def begin(self) -> None:
        """Start the tasks that run, draft and score jobs."""
        works = self._work(), self._work_beside(), self._work_slowly(), self._draft(), self._score()
        self._tasks = [asyncio.create_task(each) for each in works]

    async def end(self) -> None:
        """Stop at once; running jobs become interrupted at the next start."""
        for task in self._tasks:
            task.cancel()
        for task in self._tasks:
            with suppress(asyncio.CancelledError, IntarsiaError):
                await task
        for process in (self.worker, self.second, self.slow, self.beside, self.drafts.process):
            await process.end()

    def add(self, given: Row) -> Row:
        """Check a job and queue it; ParameterError if it is malformed, status 429 if the queue is full."""
        asked = asked_of(given)
        if sum(job["state"] == "queued" for job in self.store.all("jobs")) >= LIMITS["queue"]:
            raise HTTPException(429, f"{LIMITS['queue']} jobs wait already; wait for some, or cancel them.")
        words_of(asked, self.store)
        names = [row["name"] for e in asked["exemplars"] if (row := self.store.get("exemplars", e)) is not None]
        empty = dict.fromkeys(("error", "began", "ended", "result", "score"))
        job = {
            "id": os.urandom(8).hex(), **asked, **empty, "state": "queued", "fraction": 0.0, "created": time.time(),
            "label": " ".join([asked["verb"], *names]), "stage": None,
        }  # fmt: skip
        if self._preparing is not None and self._preparing == _analysed(job):
            self._live[job["id"]] = {"began": job["created"], "stage": LOOKING}
        if not _is_slow(asked):
            self._hurry = True
            if self._preparing or self._warming:
                self.worker.cancel()  # what is found out stays
        self._to_draft.put_nowait(job)
        return self._tell(job)

    def prepare(self, name: str) -> None:
        """Have the worker analyse an exemplar as soon as it is idle, and drafts know it."""
        row = self.store.get("exemplars", name)
        if row is not None:
            drafted = self.drafts.get({"verb": "grow", "exemplars": [name], "options": {}})
            self._tasks.append(asyncio.create_task(drafted))
        if row is not None and row["width"] * row["height"] <= PREPARED and name not in self._prepared:
            self._to_prepare = name
            self._wake()

    def now(self, row: Row) -> Row:
        """Return a row; of a running job with its progress."""
        return row | self._live.get(row["id"], {})

    @property
    def busy(self) -> bool:
        """Whether a job runs, or kernels are compiled; slow methods in their own process do not count."""
        quick = {self.worker, self.second} & {*self._running.values()}
        return self._hurry or bool(quick) or self.warmth["done"] < self.warmth["total"]

    def cancel(self, job: Row) -> Row:
        """Cancel a job that is queued or running; status 409 for others."""
        name = job["id"]
        if job["state"] == "queued":
            self.previews.pop(name, None)
            self._live.pop(name, None)
            return self._tell(job | {"state": "cancelled", "ended": time.time()})
        if job["state"] != "running":
            raise HTTPException(409, f"this job is {job['state']}.")
        if name not in self._cancelled:
            self._cancelled.add(name)
            self._running[name].cancel()
            asyncio.get_running_loop().call_later(PATIENCE, self._end_worker, name)
        return self.now(job)

    def again(self, job: Row) -> Row:
        """Queue the same job once more."""
        return self.add({key: job[key] for key in ("verb", "exemplars", "options")})

    def open(self) -> list[tuple[str, Any]]:
        """Return the events that tell a new listener the current state."""
        jobs = [("job", self.now(job)) for job in self.store.all("jobs") if job["state"] in OPEN]
        return [("warm", self.warmth), *jobs]

    # the work

    def _tell(self, job: Row) -> Row:
        self.store.put("jobs", job)
        self.events.tell("job", told := self.now(job))
        self._wake()
        return told

    def _wake(self) -> None:
        for event in self._wakes:
            event.set()

    def _end_worker(self, name: str) -> None:
        if name in self._running and name in self._cancelled:
            self._tasks.append(asyncio.create_task(self._running[name].end()))

    async def warm(self) -> None:
        """Have the worker load or compile kernels, until a job comes."""

        def heard(said: Row, data: bytes) -> None:
            if "warm" in said:
                self.warmth = dict(zip(("done", "total"), said["warm"], strict=True))
                self.events.tell("warm", self.warmth)
                if self._hurry:  # it came before the process was there
                    self.worker.cancel()

        self._warming = True
        try:
            await self.worker.ask("warm", heard)
        except FailedError as e:
            if e.exit_code == CANCELLED:
                return
        finally:
            self._warming = False
        self._warmed = self.worker.pid
        self._prepared.clear()
        self.warmth = {"done": self.warmth["total"], "total": self.warmth["total"]}
        self.events.tell("warm", self.warmth)
        self._wake()  # the second can load what was compiled

    def _waiting(self, slow: bool) -> list[Row]:
        return [job for job in self.store.all("jobs") if job["state"] == "queued" and _is_slow(job) == slow]

    def _next(self, busy: Callable[[Row], bool] = lambda _: True) -> Row | None:
        """Return the first job that may run now, of those for which the other process is `busy`."""
        run = [self.store.row("jobs", name) for name, process in self._running.items() if process is not self.slow]
        alone = all(map(_is_short, run))
        return next((job for job in self._waiting(slow=False) if busy(job) and (alone or _is_short(job))), None)

    async def _work_slowly(self) -> None:
        """Run the jobs of slow methods while no other job waits."""
        while True:
            self._wakes[2].clear()
            waiting = self._waiting(slow=True)
            if waiting and not self._running and not self._waiting(slow=False):
                await self._carry_out(waiting[0], self.slow)
                await self.slow.end()
            else:
                await self._wakes[2].wait()

    async def _work_beside(self) -> None:
        """Run the jobs for which the first process has no time."""

        def busy(job: Row) -> bool:
            return self.worker in self._running.values() or self._preparing not in (None, _analysed(job))

        ready: int | None = 0
        while True:
            self._wakes[1].clear()
            job = self._next(busy)
            if job is not None:
                await self._carry_out(job, self.second)
            elif self.second.pid != ready and self.worker.pid == self._warmed:
                with suppress(FailedError):
                    await self._try(self.second, "sample:stones")
                ready = self.second.pid
            else:
                await self._wakes[1].wait()

    async def _work(self) -> None:
        if self._next() is None:
            with suppress(TimeoutError):
                await asyncio.wait_for(self._wakes[0].wait(), CALM)
        while True:
            self._wakes[0].clear()
            self._hurry = False
            job = self._next()
            if job is not None:
                await self._carry_out(job, self.worker)
            elif self.worker.pid != self._warmed:
                await self.warm()
            elif self._to_prepare is not None and not self._running:
                self._preparing, self._to_prepare = self._to_prepare, None
                with suppress(IntarsiaError):  # its job will report why
                    await self._try(self.worker, *Words(self.store).exemplar(self._preparing))
                    self._prepared.append(self._preparing)
                self._preparing = None
            else:
                await self._wakes[0].wait()

    async def _try(self, process: Process, *exemplar: str) -> None:
        """Grow an exemplar in vain, so that a process knows it, and how to grow."""
        with self.store.under_way("exemplars") as folder:
            await process.ask("command", words=["grow", *exemplar, *TRIAL], folder=str(folder))

    async def _draft(self) -> None:
        """Draft jobs, the latest first; a draft comes before previews of the work itself, or not at all."""
        await asyncio.sleep(CALM)
        await self.drafts.begin()
        while True:
            name = (job := await self._to_draft.get())["id"]
            with suppress(IntarsiaError):  # its job will report why
                data = await self.drafts.get(job) if self._undrawn(name) else b""
                if data and self._undrawn(name):
                    self._preview(name, data)

    def _undrawn(self, name: str) -> bool:
        job = self.store.get("jobs", name)
        return job is not None and job["state"] in OPEN and name not in self.previews

    def _preview(self, name: str, data: bytes) -> None:
        number = self.previews.get(name, (0, b""))[0] + 1
        self.previews[name] = (number, data)
        self.events.tell("preview", {"id": name, "number": number})

    async def _carry_out(self, job: Row, process: Process) -> None:
        """Run a job and write how it ended."""
        name = job["id"]
        began = self._live.get(name, {}).get("began", time.time())
        self._running[name], self._live[name] = process, {}
        job = job | {"state": "running", "began": began, "fraction": 0.0, "stage": None}
        self._tell(job)
        failed: Row
        words = Words(self.store)
        try:
            words = words_of(job, self.store)
            with self.store.under_way("results") as folder:
                answer, _ = await process.ask("command", self._hearing(job), words=words.said, folder=str(folder))
                row = await asyncio.to_thread(self._keep, job, words, answer, folder)
            score = (row["score"] or {}).get("total")
            failed = {"state": "done", "result": row["id"], "fraction": 1.0, "stage": "done", "score": score}
        except Exception as e:
            line = str(e) or type(e).__name__
            code = e.exit_code if isinstance(e, FailedError) else 1
            stopped = name in self._cancelled or code == CANCELLED
            line = words.cleaned(line.replace(f"{self.store.folder}{os.sep}", ""))
            failed = {"state": "cancelled" if stopped else "failed", "error": None if stopped else line}
        finally:
            del self._running[name]
            self._cancelled.discard(name)
            self.previews.pop(name, None)
        job = self.store.get("jobs", name) or job  # it may have been given a name meanwhile
        self._tell(job | self._live.pop(name) | failed | {"ended": time.time()})
        if failed.get("result") and failed.get("score") is None:
            self._to_score.put_nowait(name)

    def _hearing(self, job: Row) -> Any:
        """Return a function that handles what the worker reports of a job."""
        name = job["id"]

        def heard(said: Row, data: bytes) -> None:
            if said.get("preview"):
                self._preview(name, data)
            else:
                if "ready" in said:
                    said = {"ready": time.time() + said["ready"]}
                self._live[name] |= {key: said[key] for key in ("fraction", "stage", "ready") if key in said}
                self.events.tell("job", self.now(self.store.get("jobs", name) or job))

        return heard

    def _keep(self, job: Row, words: Words, answer: Row, folder: Path) -> Row:
        """Store what a job made, under the digest of its files."""
        files = [p for p in folder.iterdir() if p.is_file()]
        name = digest(files)
        return self.store.keep("results", folder, result_of(name, job, words, answer, files))

    async def _score(self) -> None:
        """Score one result after another in the background."""
        while True:
            name = await self._to_score.get()
            job = self.store.get("jobs", name)
            row = None if job is None else self.store.get("results", job["result"])
            if job is None or row is None or row["score_words"] is None:
                continue
            place = str(self.store.place("results", row["id"]))
            with suppress(FailedError):
                answer, _ = await self.beside.ask("command", within=120, words=row["score_words"], folder=place)
                row = self.store.get("results", row["id"])
                job = self.store.get("jobs", name)
                if row is not None and job is not None:
                    found = {key: answer[key] for key in ("total", "verdict", "parts", "version") if key in answer}
                    self.store.put("results", row | {"score": found})
                    self._tell(job | {"score": found.get("total")})


def _is_slow(job: Row) -> bool:
    return job["options"].get("method") in SLOW


def _is_short(job: Row) -> bool:
    """Whether a job takes a few seconds: a small picture, or a change of one."""
    sides = [int(side) for side in re.findall("[0-9]+", str(job["options"].get("size") or SMALL))]
    small = job["verb"] not in ("grow", "weave") or sides[0] * sides[-1] <= SMALL
    return small and job["options"].get("method") not in LONG


def _analysed(job: Row) -> str | None:
    """Return the exemplar that a job needs to have analysed."""
    chosen = job["verb"] == "grow" and job["options"].get("method") in (None, AUTO_METHOD)
    return job["exemplars"][0] if chosen else None
