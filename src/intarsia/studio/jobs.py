"""The job queue: states, progress, cancelling and restart of jobs; slow methods run in a process of their own."""

from __future__ import annotations

import asyncio
import os
import time
from collections import deque
from contextlib import suppress
from pathlib import Path
from typing import Any

from starlette.exceptions import HTTPException

from ..foundation import IntarsiaError, ParameterError
from .processes import FailedError, Process
from .requests import LIMITS, Words, result_of, words_of
from .store import OPEN, Events, Row, Store, digest

PREPARED = 1 << 20  # px: larger exemplars are not analysed beforehand
SLOW = ("efros-leung",)
"""Methods that take minutes where others take seconds: their jobs start when no other waits, and delay none."""

TRIAL = ("--size=512", "--output=out.png", "--json")  # options of growing an exemplar before a job comes
CANCELLED = 130  # exit code
LOOKING = "the exemplar is looked at"
PATIENCE = 3.0  # s after which a worker that does not stop is killed


class Jobs:
    """All jobs, and the worker processes that run them."""

    def __init__(self, store: Store, events: Events, worker: Process, slow: Process, beside: Process) -> None:
        self.store, self.events, self.worker, self.slow, self.beside = store, events, worker, slow, beside
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
        self._wake, self._wake_slow = asyncio.Event(), asyncio.Event()
        self._tasks = list[asyncio.Task[Any]]()
        self._to_score: asyncio.Queue[str] = asyncio.Queue()

    # for the routes

    def begin(self) -> None:
        """Start the tasks that run and score jobs."""
        self._tasks = [asyncio.create_task(each) for each in (self._work(), self._work_slowly(), self._score())]

    async def end(self) -> None:
        """Stop at once; running jobs become interrupted at the next start."""
        for task in self._tasks:
            task.cancel()
        for task in self._tasks:
            with suppress(asyncio.CancelledError):
                await task
        for process in (self.worker, self.slow, self.beside):
            await process.end()

    def add(self, given: Row) -> Row:
        """Check a job and queue it; ParameterError if it is malformed, status 429 if the queue is full."""
        verb, exemplars, options = given.get("verb"), given.get("exemplars", []), given.get("options", {})
        whole = isinstance(exemplars, list) and isinstance(options, dict)
        if set(given) - {"verb", "exemplars", "options"} or not whole:
            raise ParameterError("a job has a verb, exemplars (a list of ids) and options (an object), no more.")
        if sum(job["state"] == "queued" for job in self.store.all("jobs")) >= LIMITS["queue"]:
            raise HTTPException(429, f"{LIMITS['queue']} jobs wait already; wait for some, or cancel them.")
        asked = {"verb": verb, "exemplars": exemplars, "options": options}
        words_of(asked, self.store)
        names = [row["name"] for e in exemplars if (row := self.store.get("exemplars", e)) is not None]
        empty = dict.fromkeys(("error", "began", "ended", "result", "score"))
        slow = _is_slow(asked)
        job = {
            "id": os.urandom(8).hex(), **asked, **empty, "state": "queued", "fraction": 0.0, "created": time.time(),
            "label": " ".join([str(verb), *names]), "stage": LOOKING if self._preparing and not slow else None,
        }  # fmt: skip
        if not slow:
            self._go_first(job)
        return self._tell(job)

    def prepare(self, name: str) -> None:
        """Have the worker analyse an exemplar as soon as it is idle."""
        row = self.store.get("exemplars", name)
        if row is not None and row["width"] * row["height"] <= PREPARED and name not in self._prepared:
            self._to_prepare = name
            self._wake.set()

    def now(self, row: Row) -> Row:
        """Return a row; of a running job with its progress."""
        return row | self._live.get(row["id"], {})

    @property
    def busy(self) -> bool:
        """Whether the worker runs a job or precompiles; slow methods in their own process do not count."""
        return self._hurry or self.worker in self._running.values() or self.warmth["done"] < self.warmth["total"]

    def cancel(self, job: Row) -> Row:
        """Cancel a job that is queued or running; status 409 for others."""
        name = job["id"]
        if job["state"] == "queued":
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
        self.events.tell("job", job)
        self._wake.set()
        self._wake_slow.set()
        return job

    def _go_first(self, job: Row) -> None:
        """Cancel preparatory work; if it does not stop in time, kill the worker, unless it prepares for this job."""
        self._hurry = True
        if self._preparing or self._warming:
            self.worker.cancel()
        if self._preparing and not (job["verb"] == "grow" and self._preparing in job["exemplars"]):
            asyncio.get_running_loop().call_later(PATIENCE, self._end_preparing, self._preparing)

    def _end_preparing(self, name: str) -> None:
        if self._preparing == name:
            self._tasks.append(asyncio.create_task(self.worker.end()))

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

    async def _work(self) -> None:
        while True:
            self._wake.clear()
            self._hurry = False
            waiting = self._waiting(slow=False)
            if waiting:
                await self._carry_out(waiting[0], self.worker)
            elif self.worker.pid != self._warmed:
                await self.warm()
            elif self._to_prepare is not None:
                await self._prepare(self._to_prepare)
            else:
                await self._wake.wait()

    async def _prepare(self, name: str) -> None:
        self._to_prepare, self._preparing = None, name
        try:
            with self.store.under_way("exemplars") as folder, suppress(IntarsiaError):  # its job will report why
                words = ["grow", *Words(self.store).exemplar(name), *TRIAL]
                await self.worker.ask("command", words=words, folder=str(folder))
                self._prepared.append(name)
        finally:
            self._preparing = None

    async def _carry_out(self, job: Row, process: Process) -> None:
        """Run a job and write how it ended."""
        name = job["id"]
        self._running[name], self._live[name] = process, {}
        job = job | {"state": "running", "began": time.time(), "fraction": 0.0, "stage": None}
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

    def _hearing(self, job: Row) -> Any:
        """Return a function that handles what the worker reports of a job."""
        name = job["id"]

        def heard(said: Row, data: bytes) -> None:
            if said.get("preview"):
                number = self.previews.get(name, (0, b""))[0] + 1
                self.previews[name] = (number, data)
                self.events.tell("preview", {"id": name, "number": number})
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
