"""The job queue: states, progress, cancelling and restart of jobs.

Two processes run jobs, at most one of which is long, so that a short job waits for none; slow methods have their own.
"""

from __future__ import annotations

import asyncio
import os
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
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

SHORT, MOST = {"render": 1 << 24, "heal": 1 << 21, "extend": 1 << 20, "tile": 1 << 20}, 1 << 19
"""Up to so many px, of the picture that is made, a job of a verb is short: it takes a few seconds. MOST: of others."""

LONG = (*SLOW, "wei-levoy", "ashikhmin", "segment-based")
"""Methods whose jobs are never short."""

TRIAL = ("--size=512", "--output=out.png", "--json")  # options of growing an exemplar before a job comes
CANCELLED = 130  # exit code
LOOKING = "look"  # stage of a job that takes over an analysis
PATIENCE = 3.0  # s after which a worker that does not stop is killed


@dataclass(eq=False)
class Lane:
    """A process that runs one job after another, and what it is at."""

    process: Process
    wake: asyncio.Event = field(default_factory=asyncio.Event)
    job: Row | None = None
    preparing: str | None = None
    warming: bool = False
    hurry: bool = False  # a job came meanwhile
    warmed: int | None = 0  # pid of the process that has all kernels
    known: deque[str] = field(default_factory=lambda: deque(maxlen=4))  # exemplars analysed, as many as it keeps

    @property
    def warm(self) -> bool:
        """Whether its process has all kernels."""
        return self.process.pid == self.warmed

    @property
    def idle(self) -> bool:
        """Whether it does nothing."""
        return not (self.job or self.preparing or self.warming)


class Jobs:
    """All jobs, and the worker processes that run them."""

    def __init__(
        self, store: Store, events: Events, workers: Sequence[Process], slow: Process, beside: Process, drafts: Drafts
    ) -> None:
        self.store, self.events, self.slow, self.beside, self.drafts = store, events, slow, beside, drafts
        self.lanes = [Lane(process) for process in workers]
        self.previews: dict[str, tuple[int, bytes]] = {}
        self.warmth: Row = {"done": 0, "total": 1}
        self._running: dict[str, Process] = {}
        self._live: dict[str, Row] = {}  # progress of running jobs, which is not stored
        self._cancelled: set[str] = set()
        self._to_prepare: str | None = None
        self._wake_slow = asyncio.Event()
        self._to_draft: asyncio.LifoQueue[Row] = asyncio.LifoQueue()
        self._tasks = list[asyncio.Task[Any]]()
        self._to_score: asyncio.Queue[str] = asyncio.Queue()

    # for the routes

    def begin(self) -> None:
        """Start the tasks that run, draft and score jobs."""
        works = [*map(self._work, self.lanes), self._work_slowly(), self._draft(), self._score()]
        self._tasks = [asyncio.create_task(each) for each in works]

    async def end(self) -> None:
        """Stop at once; running jobs become interrupted at the next start."""
        for task in self._tasks:
            task.cancel()
        for task in self._tasks:
            with suppress(asyncio.CancelledError):
                await task
        for process in (*(lane.process for lane in self.lanes), self.slow, self.beside, self.drafts.process):
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
        if self._looking(job):
            self._live[job["id"]] = {"began": job["created"], "stage": LOOKING}
        if not _is_slow(asked):
            self._go_first()
        self._to_draft.put_nowait(job)
        return self._tell(job)

    def prepare(self, name: str) -> None:
        """Have an exemplar analysed as soon as no job runs, and read for drafts."""
        row = self.store.get("exemplars", name)
        if row is None or any(name in lane.known for lane in self.lanes):
            return
        self._to_draft.put_nowait({"id": None, "verb": "grow", "exemplars": [name], "options": {}})
        if row["width"] * row["height"] <= PREPARED:
            self._to_prepare = name
            self._wake()

    def now(self, row: Row) -> Row:
        """Return a row; of a running job with its progress."""
        return row | self._live.get(row["id"], {})

    @property
    def busy(self) -> bool:
        """Whether a job runs or comes, or kernels are compiled; slow methods in their own process do not count."""
        return self.warmth["done"] < self.warmth["total"] or any(lane.hurry or lane.job for lane in self.lanes)

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
        job = self.now(job)
        self.events.tell("job", job)
        self._wake()
        return job

    def _wake(self) -> None:
        for event in (self._wake_slow, *(lane.wake for lane in self.lanes)):
            event.set()

    def _go_first(self) -> None:
        """Cancel preparatory work, which leaves what it has found out."""
        for lane in self.lanes:
            lane.hurry = True
            if lane.preparing or (lane.warming and lane is self.lanes[0]):
                lane.process.cancel()

    def _looking(self, job: Row) -> list[Lane]:
        """Return the process that analyses the exemplar of a job just now, if the job needs that."""
        name = _analysed(job)
        return [lane for lane in self.lanes if name is not None and lane.preparing == name]

    def _end_worker(self, name: str) -> None:
        if name in self._running and name in self._cancelled:
            self._tasks.append(asyncio.create_task(self._running[name].end()))

    async def warm(self, lane: Lane) -> None:
        """Have a process load or compile kernels; the first one tells of it, and stops when a job comes."""
        first = lane is self.lanes[0]

        def heard(said: Row, data: bytes) -> None:
            if "warm" in said and first:
                self.warmth = dict(zip(("done", "total"), said["warm"], strict=True))
                self.events.tell("warm", self.warmth)
                if lane.hurry:  # it came before the process was there
                    lane.process.cancel()

        lane.warming = True
        try:
            await lane.process.ask("warm", heard)
        except FailedError as e:
            if e.exit_code == CANCELLED:
                return
        finally:
            lane.warming = False
        lane.warmed = lane.process.pid
        lane.known.clear()
        if first:
            self.warmth = {"done": self.warmth["total"], "total": self.warmth["total"]}
            self.events.tell("warm", self.warmth)
            self._tasks.append(asyncio.create_task(self.drafts.begin()))
            self._wake()  # the others can load what was compiled

    def _waiting(self, slow: bool) -> list[Row]:
        return [job for job in self.store.all("jobs") if job["state"] == "queued" and _is_slow(job) == slow]

    async def _work_slowly(self) -> None:
        """Run the jobs of slow methods while no other job waits."""
        while True:
            self._wake_slow.clear()
            waiting = self._waiting(slow=True)
            if waiting and not self._running and not self._waiting(slow=False):
                await self._carry_out(waiting[0], self.slow)
                await self.slow.end()
            else:
                await self._wake_slow.wait()

    async def _work(self, lane: Lane) -> None:
        while True:
            lane.wake.clear()
            lane.hurry = False
            job = self._next(lane)
            if job is not None:
                lane.job = job
                await self._carry_out(job, lane.process)
                lane.job = None
                lane.known += [name for name in (_analysed(job),) if name is not None and name not in lane.known]
            elif not lane.warm and (lane is self.lanes[0] or self.lanes[0].warm):
                await self.warm(lane)
            elif self._to_prepare is not None and not any(each.job for each in self.lanes):
                await self._prepare(lane, self._to_prepare)
            else:
                await lane.wake.wait()

    def _next(self, lane: Lane) -> Row | None:
        """Return the job that a process is to run now: one that no other suits better, and no second long one."""
        free = [each for each in self.lanes if each.idle and (each.warm or each is self.lanes[0])]
        long = any(each.job is not None and not self._is_short(each.job) for each in self.lanes)
        for job in self._waiting(slow=False):
            best = self._looking(job) or sorted(free, key=lambda each: _analysed(job) not in each.known)
            if best[:1] == [lane] and (not long or self._is_short(job)):
                return job
        return None

    def _is_short(self, job: Row) -> bool:
        """Whether a job takes a few seconds, as far as its verb, method and size tell."""
        try:
            size = words_of(job, self.store).request.size
        except IntarsiaError:  # it ends at once
            return True
        exemplar = self.store.get("exemplars", job["exemplars"][0]) if job["exemplars"] else None
        if size is None and exemplar is not None:
            twice = 1 if job["verb"] in SHORT else 2
            size = twice * exemplar["width"], twice * exemplar["height"]
        area = 0 if size is None else size[0] * size[1]
        return area <= SHORT.get(job["verb"], MOST) and job["options"].get("method") not in LONG

    async def _draft(self) -> None:
        """Draft the jobs that wait, or have just begun, the latest first; a draft comes before real previews or never.

        One without an id has its exemplar read, and no picture is shown.
        """
        while True:
            job = await self._to_draft.get()
            name = job["id"]

            async def late(name: str | None = name) -> bool:
                row = None if name is None else self.store.get("jobs", name)
                return name is not None and (row is None or row["state"] not in OPEN or name in self.previews)

            with suppress(IntarsiaError):  # the job will report why
                data = await self.drafts.get(job, late)
                if data and name is not None and not await late():
                    self._preview(name, data)

    async def _prepare(self, lane: Lane, name: str) -> None:
        self._to_prepare, lane.preparing = None, name
        try:
            with self.store.under_way("exemplars") as folder, suppress(IntarsiaError):  # its job will report why
                words = ["grow", *Words(self.store).exemplar(name), *TRIAL]
                await lane.process.ask("command", words=words, folder=str(folder))
        finally:
            lane.preparing = None
        lane.known.append(name)

    async def _carry_out(self, job: Row, process: Process) -> None:
        """Run a job and write how it ended."""
        name = job["id"]
        self._running[name], began = process, self._live.get(name, {}).get("began", time.time())
        self._live[name] = {}
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
        self._tell(job | self._live.pop(name) | failed | {"ended": time.time()})
        if failed.get("result") and failed.get("score") is None:
            self._to_score.put_nowait(name)

    def _preview(self, name: str, data: bytes) -> None:
        number = self.previews.get(name, (0, b""))[0] + 1
        self.previews[name] = (number, data)
        self.events.tell("preview", {"id": name, "number": number})

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
                self.events.tell("job", job | self._live[name])

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


def _analysed(job: Row) -> str | None:
    """Return the exemplar that a job needs to have analysed."""
    if job["verb"] != "grow" or job["options"].get("method", AUTO_METHOD) != AUTO_METHOD:
        return None
    return str(job["exemplars"][0])
