"""What is done before a job comes: exemplars are looked at, and kept, so that growing begins at once."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studio.served import QUICK, pixels, png

from intarsia.cli import Report
from intarsia.cli.exemplars import ExemplarCache, Inputs, set_cache
from intarsia.request import Request
from intarsia.studio.jobs import PREPARED, TRIAL, Jobs
from intarsia.studio.processes import FailedError
from intarsia.studio.store import Events, Store


class Worker:
    """A process that does nothing, but remembers what it was asked; a trial takes until it is cancelled."""

    def __init__(self) -> None:
        self.asked, self.pid, self.stopped = list[tuple[str, Any]](), 1, asyncio.Event()
        self.cold = self.ended = False

    async def ask(self, do: str, heard: Any = None, **given: Any) -> Any:
        """Remember it."""
        if do == "command" and TRIAL[1] in given["words"]:
            self.asked.append(("prepare", given["words"]))
            if "slow.png" in given["words"][1]:
                await self.stopped.wait()
            return {}, b""
        self.asked.append((do, given.get("words")))
        if do == "warm" and self.cold:
            heard({"warm": [1, 3]}, b"")
            await self.stopped.wait()
            raise FailedError("cancelled", 130)
        if do == "command":
            await asyncio.sleep(0.02)
            raise FailedError("nothing is done here.", 1)
        return {}, b""

    def cancel(self) -> None:
        """End the trial."""
        self.stopped.set()

    async def end(self) -> None:
        """Whoever does not listen is ended."""
        self.ended = True
        self.stopped.set()


@pytest.fixture(autouse=True)
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Prepare at once: no page comes here."""
    monkeypatch.setattr("intarsia.studio.jobs.CALM", 0.0)


async def settled(ready: Any) -> None:
    for _ in range(400):
        if ready():
            return
        await asyncio.sleep(0.005)
    raise AssertionError("it does not come")


def test_what_is_opened_is_tried_once_and_a_job_goes_first(tmp_path: Path) -> None:
    async def work() -> None:
        store, worker = Store(tmp_path), Worker()
        large = PREPARED // 100 + 1
        for number, (name, height) in enumerate((("fine", 10), ("large", large), ("slow", 10))):
            row = {"id": f"{number:016}", "name": name, "width": 100, "height": height, "files": [f"{name}.png"]}
            store.put("exemplars", row)
        jobs = queue(store, worker)
        trials = lambda: [words[1].rpartition("/")[2] for do, words in worker.asked if do == "prepare"]  # noqa: E731
        await settled(lambda: ("warm", None) in worker.asked)
        for name in ("0" * 16, "0" * 15 + "1", "f" * 16):
            jobs.prepare(name)
            await asyncio.sleep(0.05)
        await settled(lambda: trials() == ["fine.png"])
        jobs.prepare("0" * 16)  # once is enough
        await asyncio.sleep(0.05)
        jobs.prepare("0" * 15 + "2")
        await settled(lambda: trials() == ["fine.png", "slow.png"])
        job = jobs.add({"verb": "grow", "exemplars": ["0" * 16], "options": dict(QUICK)})
        await settled(lambda: jobs.now(jobs.store.row("jobs", job["id"]))["state"] == "failed")
        assert worker.stopped.is_set()
        assert not list((tmp_path / "exemplars").glob(".under-way-*"))
        await jobs.end()
        store.close()

    asyncio.run(work())


class Drawer:
    """Drafts that are drawn when they are let; it notes of which jobs."""

    def __init__(self) -> None:
        self.asked, self.let, self.process = list[Any](), asyncio.Event(), Worker()
        self.let.set()

    async def begin(self) -> None:
        """It is ready at once."""

    async def get(self, job: Any) -> bytes:
        """Draw it, however long that takes."""
        self.asked.append(job["options"])
        await self.let.wait()
        return b"a draft"


def queue(
    store: Store, worker: Worker, second: Worker | None = None, slow: Worker | None = None, drafts: Drawer | None = None
) -> Jobs:
    """A queue with these processes, at work."""
    jobs = Jobs(store, Events(), Worker(), drafts or Drawer())  # type: ignore[arg-type]
    jobs.worker, jobs.second, jobs.slow = worker, second or Worker(), slow or Worker()  # type: ignore[assignment]
    jobs.begin()
    return jobs


def opened(
    folder: Path, worker: Worker, second: Worker | None = None, slow: Worker | None = None, drafts: Drawer | None = None
) -> Jobs:
    """The queue of a folder with two exemplars: one is looked at in no time, the other never to the end."""
    store = Store(folder)
    for number, name in enumerate(("fine", "slow")):
        row = {"id": f"{number:016}", "name": name, "width": 100, "height": 10, "files": [f"{name}.png"]}
        store.put("exemplars", row)
    return queue(store, worker, second, slow, drafts)


def test_a_job_goes_before_warming_which_goes_on_afterwards(tmp_path: Path) -> None:
    async def work() -> None:
        worker = Worker()
        worker.cold = True
        jobs = opened(tmp_path, worker)
        await settled(lambda: jobs.warmth == {"done": 1, "total": 3})
        worker.cold = False
        job = jobs.add({"verb": "grow", "exemplars": ["0" * 16], "options": dict(QUICK)})
        await settled(lambda: jobs.now(jobs.store.row("jobs", job["id"]))["state"] == "failed")
        await settled(lambda: not jobs.busy)
        assert [do for do, _ in worker.asked] == ["warm", "command", "warm"]
        await jobs.end()
        jobs.store.close()

    asyncio.run(work())


class Endless(Worker):
    """A process whose work takes until it is cancelled."""

    async def ask(self, do: str, heard: Any = None, **given: Any) -> Any:
        """Work on and on."""
        self.asked.append((do, given["words"]))
        await self.stopped.wait()
        raise FailedError("cancelled", 130)


def test_a_method_that_takes_minutes_comes_after_all_that_waits_and_holds_up_nothing(tmp_path: Path) -> None:
    async def work() -> None:
        worker, slow = Worker(), Endless()
        slow.asked = worker.asked
        jobs = opened(tmp_path, worker, slow=slow)
        await settled(lambda: not jobs.busy)

        def add(method: str) -> str:
            job = jobs.add({"verb": "grow", "exemplars": ["0" * 16], "options": {"method": method}})
            return str(job["id"])

        def asked() -> list[str]:
            given = [words for do, words in worker.asked if do == "command"]
            return [word.removeprefix("--method=") for words in given for word in words if "method" in word]

        first, second = add("efros-leung"), add("efros-leung")
        add("image-quilting")
        add("graphcut")
        await settled(lambda: jobs.now(jobs.store.row("jobs", first))["state"] == "running")
        assert asked() == ["image-quilting", "graphcut", "efros-leung"]
        third = add("patch-sampling")
        await settled(lambda: jobs.now(jobs.store.row("jobs", third))["state"] == "failed")
        assert [jobs.store.row("jobs", name)["state"] for name in (first, second)] == ["running", "queued"]
        await settled(lambda: not jobs.busy)
        jobs.cancel(jobs.store.row("jobs", first))
        await settled(lambda: jobs.now(jobs.store.row("jobs", second))["state"] != "queued")
        assert jobs.now(jobs.store.row("jobs", first))["state"] == "cancelled"
        assert slow.ended  # it keeps no memory when it has nothing to do
        assert not worker.stopped.is_set()
        await jobs.end()
        jobs.store.close()

    asyncio.run(work())


class Late(Worker):
    """A process that takes a while to start, and hears nothing until it is there."""

    async def ask(self, do: str, heard: Any = None, **given: Any) -> Any:
        """Forget whatever came before it was there."""
        if do == "warm":
            await asyncio.sleep(0.2)
            self.stopped.clear()
        return await super().ask(do, heard, **given)


def test_a_job_that_came_before_the_process_was_there_goes_first(tmp_path: Path) -> None:
    async def work() -> None:
        worker = Late()
        worker.cold = True
        jobs = opened(tmp_path, worker)
        await asyncio.sleep(0.05)
        jobs.add({"verb": "grow", "exemplars": ["0" * 16], "options": dict(QUICK)})
        await settled(lambda: [do for do, _ in worker.asked][:2] == ["warm", "command"])
        await jobs.end()
        jobs.store.close()

    asyncio.run(work())


class Deaf(Worker):
    """A process that does not listen."""

    def cancel(self) -> None:
        """Go on."""


def test_an_analysis_is_taken_over_by_the_job_that_needs_it_and_holds_up_no_other(tmp_path: Path) -> None:
    async def work() -> None:
        worker, second = Deaf(), Worker()
        jobs = opened(tmp_path, worker, second)
        state = lambda job: jobs.now(jobs.store.row("jobs", job["id"]))["state"]  # noqa: E731
        await settled(lambda: not jobs.busy)
        slow = "0" * 15 + "1"
        jobs.prepare(slow)
        await settled(lambda: jobs._preparing == slow)
        first = jobs.add({"verb": "grow", "exemplars": [slow], "options": {"size": "48x40"}})
        assert (first["state"], first["stage"], first["began"]) == ("queued", "look", first["created"])
        assert jobs.busy  # no sketch is drawn before it
        other = "grow", "0" * 16, {"size": "2048"}
        for verb, exemplar, options in (("tile", slow, {}), ("grow", slow, dict(QUICK)), other):
            job = jobs.add({"verb": verb, "exemplars": [exemplar], "options": options})
            await settled(lambda job=job: state(job) == "failed")
        assert (state(first), jobs._preparing, worker.ended) == ("queued", slow, False)
        assert [do for do, _ in second.asked] == ["prepare", *["command"] * 3]
        worker.stopped.set()
        await settled(lambda: state(first) == "failed")
        ended = jobs.now(jobs.store.row("jobs", first["id"]))
        assert (worker.asked[-1][0], ended["stage"], ended["began"]) == ("command", None, first["created"])
        await jobs.end()
        jobs.store.close()

    asyncio.run(work())


class Large(Worker):
    """A process that grows what is large until it is cancelled."""

    async def ask(self, do: str, heard: Any = None, **given: Any) -> Any:
        """Work on and on."""
        if not {"--size=2048x2048", "--size=600x600"} & {*(given.get("words") or ())}:
            return await super().ask(do, heard, **given)
        self.asked.append((do, given["words"]))
        self.stopped.clear()
        await self.stopped.wait()
        raise FailedError("cancelled", 130)


def test_a_short_job_waits_for_no_long_one_and_a_second_long_one_waits(tmp_path: Path) -> None:
    async def work() -> None:
        worker, second = Large(), Large()
        jobs = opened(tmp_path, worker, second)
        state = lambda job: jobs.now(jobs.store.row("jobs", job["id"]))["state"]  # noqa: E731

        def add(verb: str = "grow", **options: Any) -> Any:
            return jobs.add({"verb": verb, "exemplars": ["0" * 16], "options": options})

        await settled(lambda: not jobs.busy)
        long = [add(size="2048x2048", seed=n) for n in range(3)]
        short = add(**QUICK), add("tile"), add(size=512)
        await settled(lambda: {state(job) for job in short} == {"failed"})
        pixelwise, unknown = add(method="wei-levoy", size="96x96"), add(size=None)
        assert [state(job) for job in long] == ["running", "queued", "queued"]
        assert jobs.busy
        assert jobs.cancel(jobs.store.row("jobs", long[1]["id"]))["state"] == "cancelled"
        jobs.cancel(jobs.store.row("jobs", long[0]["id"]))
        await settled(lambda: state(long[2]) == "running")
        assert [state(pixelwise), state(unknown)] == ["queued", "queued"]
        short = add(size="600x600"), add(**QUICK)
        await settled(lambda: state(short[0]) == "running")
        assert state(short[1]) == "queued"
        jobs.cancel(jobs.store.row("jobs", short[0]["id"]))
        await settled(lambda: [state(job) for job in short] == ["cancelled", "failed"])
        assert state(long[2]) == "running"
        jobs.cancel(jobs.store.row("jobs", long[2]["id"]))
        await settled(lambda: state(pixelwise) == "failed")
        assert [state(job) for job in long] == ["cancelled"] * 3
        await settled(lambda: state(unknown) == "failed")
        await jobs.end()
        jobs.store.close()

    asyncio.run(work())


class Shown(Large):
    """One that shows its work before it goes on."""

    async def ask(self, do: str, heard: Any = None, **given: Any) -> Any:
        """Show it."""
        if "--size=2048x2048" in (given.get("words") or ()):
            heard({"preview": True}, b"the work")
        return await super().ask(do, heard, **given)


def test_a_draft_is_seen_of_a_job_that_waits_and_never_after_its_own_previews(tmp_path: Path) -> None:
    async def work() -> None:
        worker, drafts = Shown(), Drawer()
        jobs = opened(tmp_path, worker, drafts=drafts)
        await settled(lambda: not jobs.busy)
        drafts.let.clear()
        asked = {"verb": "grow", "exemplars": ["0" * 16]}
        first, second, third = (jobs.add({**asked, "options": {"size": "2048", "seed": n}}) for n in range(3))
        await settled(lambda: drafts.asked == [third["options"]])  # the latest first
        await settled(lambda: jobs.previews == {first["id"]: (1, b"the work")})
        jobs.cancel(jobs.store.row("jobs", third["id"]))
        drafts.let.set()
        await settled(lambda: second["id"] in jobs.previews)
        assert jobs.previews == {first["id"]: (1, b"the work"), second["id"]: (1, b"a draft")}
        assert drafts.asked == [third["options"], second["options"]]
        jobs.cancel(jobs.store.row("jobs", first["id"]))
        await settled(lambda: jobs.previews == {second["id"]: (2, b"the work")})
        jobs.cancel(jobs.store.row("jobs", second["id"]))
        await settled(lambda: jobs.previews == {})
        await jobs.end()
        jobs.store.close()

    asyncio.run(work())


def test_exemplars_are_shared_by_commands_until_their_files_change(tmp_path: Path) -> None:
    path, told = tmp_path / "a.png", list[str]()
    path.write_bytes(png(pixels()))
    held, inputs = ExemplarCache(most=2, uses=3), Request("grow", files=(str(path),))
    set_cache(held)
    try:
        def read(inputs: Request = inputs) -> Any:
            report = Report(quiet=True)
            (found,) = Inputs([{"albedo": str(path)}], inputs, report).exemplars
            told.extend(report.warnings)
            return found

        first = read()
        assert read() is first
        assert read(Request("grow", files=(str(path),), crop=(0, 0, 20, 20))) is not first
        assert read() is first
        assert read() is not first  # often enough: what is known of one does not grow for ever
        path.write_bytes(png(pixels(seed=2)))
        assert np.array_equal(read().base.pixels, pixels(seed=2))
        avoiding = Request("grow", files=(str(path),), avoid=(1, 2, 3))
        assert read(avoiding) is read(avoiding)
        assert len(told) == 2  # warned of each time
        assert "no pixel of the colour" in told[1]
        for n in range(3):
            read(Request("grow", files=(str(path),), crop=(0, 0, 20 + n, 20)))
        assert len(held.known) == 2
    finally:
        set_cache(None)
    assert read() is not read()
