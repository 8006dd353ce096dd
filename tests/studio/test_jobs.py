"""Jobs: states, what is told meanwhile, cancel, restart; whatever is killed, nothing finished is lost."""

from __future__ import annotations

import json
import os
import signal
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from studio.served import QUICK, Served, children, lives, opened, pixels, png, studio

from intarsia.studio.store import Store

LONG = {"method": "image-quilting", "patch": "4", "size": "1600x1600"}
"""Options of a job that takes minutes."""


def running(served: Served, job: Any) -> None:
    """Wait until a job has begun to grow; kernels may have to be compiled first."""
    until = time.monotonic() + 240
    while served.get(f"/api/jobs/{job['id']}")["fraction"] <= 0 and time.monotonic() < until:
        time.sleep(0.02)
    assert served.get(f"/api/jobs/{job['id']}")["state"] == "running"


def working(served: Served) -> list[int]:
    """The processes that run a job."""
    places = {p: Path(f"/proc/{p}/cwd").resolve() for p in served.processes()}
    return [p for p, place in places.items() if place.parent.name == "results" and place.name.startswith(".under-way")]


def ended_processes(pids: list[int]) -> bool:
    until = time.monotonic() + 10
    while any(map(lives, pids)) and time.monotonic() < until:
        time.sleep(0.05)
    return not any(map(lives, pids))


class TestStates:
    def test_what_is_told_of_a_job_from_first_to_last(self, served: Served, small: str) -> None:
        heard = list[tuple[str, Any]]()
        options = QUICK | {"size": "300x260", "seed": 3}

        def listen() -> None:
            for kind, said in served.events():
                heard.append((kind, said))
                if kind == "job" and said["options"] == options and said["state"] == "done":
                    return

        ear = threading.Thread(target=listen)
        ear.start()
        time.sleep(0.3)
        job = served.job("grow", [small], **options)
        ear.join(60)
        mine = [said for kind, said in heard if kind == "job" and said["id"] == job["id"]]
        assert heard[0][0] == "warm"
        assert [m["state"] for m in mine if m["state"] != "running"] == ["queued", "done"]
        fractions = [m["fraction"] for m in mine]
        assert fractions == sorted(fractions)
        assert len(set(fractions)) > 3
        assert {"grow", "render"} <= {m["stage"] for m in mine}
        seen = [said for kind, said in heard if kind == "preview" and said["id"] == job["id"]]
        assert [p["number"] for p in seen] == list(range(1, len(seen) + 1))
        assert seen
        row = served.get(f"/api/jobs/{job['id']}")
        assert row["created"] <= row["began"] <= row["ended"]
        assert served.get(f"/api/results/{row['result']}")["size"] == [300, 260]

    def test_a_preview_shows_what_has_grown(self, served: Served, small: str) -> None:
        job = served.job("grow", [small], **LONG)
        until = time.monotonic() + 60
        while (answer := served.client.get(f"/api/jobs/{job['id']}/preview.png")).status_code == 204:
            assert time.monotonic() < until
            time.sleep(0.02)
        drawn = opened(answer.content)
        assert drawn.shape == (400, 400, 4)  # reduced to a quarter
        colours = {tuple(c) for c in pixels().reshape(-1, 3).tolist()}
        grown = drawn[drawn[..., 3] > 0]
        assert len(grown)
        assert {tuple(c) for c in grown[:, :3].tolist()} <= colours
        served.post(f"/api/jobs/{job['id']}/cancel")
        assert served.ended(job)["state"] == "cancelled"
        assert served.client.get(f"/api/jobs/{job['id']}/preview.png").status_code == 204
        assert served.client.get(f"/api/jobs/{'0' * 16}/preview.png").status_code == 404

    def test_a_job_that_fails_says_why_in_one_line_and_the_next_one_works(self, served: Served, small: str) -> None:
        failed = served.ended(served.job("grow", [small], method="image-quilting", patch="300", size="320x320"))
        assert failed["state"] == "failed"
        assert failed["result"] is None
        assert "\n" not in failed["error"]
        assert str(served.folder) not in failed["error"]
        assert "../" not in failed["error"]
        assert served.done("grow", [small], **QUICK)["files"]

    def test_a_score_comes_after_the_result(self, served: Served) -> None:
        exemplar = served.exemplar(bark=png(pixels(64, 64)))["id"]
        job = served.ended(served.job("grow", [exemplar], **QUICK | {"size": "96x96"}))
        until = time.monotonic() + 60
        while (now := served.get(f"/api/jobs/{job['id']}"))["score"] is None and time.monotonic() < until:
            time.sleep(0.05)
        score = served.get(f"/api/results/{job['result']}")["score"]
        assert 0 <= now["score"] <= 100
        assert score["total"] == now["score"]
        assert {"joins", "copies"} & set(score["parts"])


class TestCancel:
    def test_one_that_runs_and_one_that_waits(self, served: Served, small: str) -> None:
        first, second = (served.job("grow", [small], **LONG, seed=n) for n in (1, 2))
        assert served.post(f"/api/jobs/{second['id']}/cancel")["state"] == "cancelled"
        running(served, first)
        assert served.post(f"/api/jobs/{first['id']}/name", {"name": "named meanwhile"})["fraction"] > 0
        began = time.monotonic()
        served.post(f"/api/jobs/{first['id']}/cancel")
        ended = served.ended(first)
        assert ended["state"] == "cancelled"
        assert ended["error"] is None
        assert ended["name"] == "named meanwhile"
        assert time.monotonic() - began < 3
        served.post(f"/api/jobs/{first['id']}/cancel", status=409)
        assert not list((served.folder / "results").glob(".under-way-*"))

    def test_a_worker_that_does_not_listen_is_ended(self, served: Served, small: str) -> None:
        job = served.job("grow", [small], **LONG)
        running(served, job)
        (worker,) = working(served)
        os.kill(worker, signal.SIGSTOP)
        served.post(f"/api/jobs/{job['id']}/cancel")
        assert served.ended(job, within=10)["state"] == "cancelled"
        assert ended_processes([worker])
        assert served.done("grow", [small], **QUICK)["files"]

    def test_a_worker_that_is_killed_fails_its_job_alone(self, served: Served, small: str) -> None:
        job = served.job("grow", [small], **LONG)
        running(served, job)
        (worker,) = working(served)
        os.kill(worker, signal.SIGKILL)
        failed = served.ended(job)
        assert failed["state"] == "failed"
        assert "memory" in failed["error"]
        assert served.done("grow", [small], **QUICK)["files"]


class TestHistory:
    def test_again_gives_the_same_and_what_is_deleted_is_there_no_more(self, served: Served) -> None:
        exemplar = served.exemplar(twice=png(pixels(seed=9)))["id"]
        job = served.ended(served.job("grow", [exemplar], **QUICK))
        more = served.ended(served.post(f"/api/jobs/{job['id']}/again"))
        assert more["id"] != job["id"]
        assert more["result"] == job["result"]
        for kind, name in (("jobs", job["id"]), ("jobs", more["id"]), ("exemplars", exemplar)):
            assert served.client.delete(f"/api/{kind}/{name}").status_code == 204
            assert served.client.get(f"/api/{kind}/{name}").status_code == 404

    def test_all_is_there_after_a_restart_and_what_ran_is_interrupted(self, tmp_path: Path) -> None:
        folder = tmp_path / "wälle"
        first = Served(folder)
        exemplar = first.exemplar(one=png(pixels()))["id"]
        job = first.ended(first.job("grow", [exemplar], **QUICK))
        files = first.files(first.get(f"/api/results/{job['result']}"))
        cut = first.job("grow", [exemplar], **LONG)
        waits = first.job("grow", [exemplar], method="wei-levoy", size="24x20")  # counts as long: it waits
        running(first, cut)
        pids = first.processes()
        first.kill()
        assert ended_processes(pids)
        with studio(folder) as second:
            assert second.get(f"/api/jobs/{job['id']}")["state"] == "done"
            assert second.files(second.get(f"/api/results/{job['result']}")) == files
            assert second.get(f"/api/jobs/{cut['id']}")["state"] == "interrupted"
            assert second.ended(waits)["state"] == "done"
            assert [e["id"] for e in second.get("/api/exemplars")] == [exemplar]
            more = second.post(f"/api/jobs/{cut['id']}/again")
            assert (more["state"], more["options"]) == ("queued", cut["options"])
            running(second, more)
            assert not list((folder / "results").glob(".under-way-*/map.npz"))

    def test_one_studio_for_one_folder(self, served: Served) -> None:
        with pytest.raises(AssertionError, match="another studio works"):
            Served(served.folder)


def test_kills_lose_no_finished_result(tmp_path: Path, thorough: bool) -> None:
    """Whenever the server is killed: what was told to be done is there afterwards, whole, and nothing half is."""
    folder, done = tmp_path / "folder", dict[str, dict[str, bytes]]()
    moments = range(50) if thorough else range(3)
    for moment in moments:
        served = Served(folder)
        for result, files in done.items():
            assert served.files(served.get(f"/api/results/{result}")) == files
        states = {job["state"] for job in served.get("/api/jobs")}
        assert states <= {"done", "interrupted", "queued", "running"}
        exemplar = served.exemplar(one=png(pixels()))["id"]
        jobs = [served.job("grow", [exemplar], **QUICK, seed=1000 * moment + n) for n in range(8)]
        until = None
        while until is None or time.monotonic() < until:  # a while after the first is done
            for job in jobs:
                now = served.get(f"/api/jobs/{job['id']}")
                assert now["state"] in ("queued", "running", "done"), now
                if now["state"] == "done" and now["result"] not in done:
                    done[now["result"]] = served.files(served.get(f"/api/results/{now['result']}"))
                    until = until or time.monotonic() + 0.01 * moment
        served.kill()
    assert done
    store = Store(folder)
    known = {row["id"] for row in store.all("results")}
    assert known == {path.name for path in (folder / "results").iterdir()}
    assert set(done) <= known
    store.close()
    print(f"{len(moments)} kills, {len(done)} results that were told of, none lost")


def test_many_jobs_leave_no_process_no_file_and_no_memory(tmp_path: Path, thorough: bool) -> None:
    count = 200 if thorough else 16
    with studio(tmp_path / "folder") as served:
        exemplar = served.exemplar(one=png(pixels()))["id"]
        sizes, counts = [], []
        for number in range(count):
            job = served.ended(served.job("grow", [exemplar], **QUICK, seed=number))
            assert job["state"] == "done", job
            if number in (count // 2, count - 1):
                pids = [served.process.pid, *served.processes()]
                sizes.append(sum(_resident(pid) for pid in pids))
                counts.append((len(pids), sum(len(os.listdir(f"/proc/{pid}/fd")) for pid in pids[:1])))
        assert len(served.get("/api/jobs")) == count
        assert len(list((served.folder / "results").iterdir())) == count
        pids = [served.process.pid, *served.processes()]
        assert sizes[1] < sizes[0] * 1.25 + (60 << 20)  # what scores need is loaded meanwhile
        assert counts[1][0] <= counts[0][0] + 1
        assert counts[1][1] <= counts[0][1] + 6
        print(f"{count} jobs; after half of them and at the end: {sizes} bytes, {counts} processes and open files")
        said = served.close()
    assert ended_processes(pids)
    assert "Traceback" not in said
    assert children(served.process.pid) == []


def _resident(pid: int) -> int:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class TestStore:
    def test_rows_and_files_are_brought_together(self, tmp_path: Path) -> None:
        made, gone = "aa" * 8, "bb" * 8
        store = Store(tmp_path)
        kept = store.begun("results")
        (kept / "a.png").write_bytes(b"a")
        store.put("jobs", {"id": "j", "state": "running", "result": None, "ended": None})
        store.keep("results", kept, {"id": made, "job": "j", "made": 1.0})
        store.put("results", {"id": gone, "job": "k", "made": 1.0})
        store.put("jobs", {"id": "k", "state": "done", "result": gone, "ended": 2.0})
        store.drop_row("results", made)  # as if it was killed before the row was written
        store.begun("results")
        store.begun("exemplars")
        store.put("images", {"id": "ff" * 8})
        store.close()
        store = Store(tmp_path)
        assert [row["id"] for row in store.all("results")] == [made]
        assert {path.name for path in (tmp_path / "results").iterdir()} == {made}
        assert not list((tmp_path / "exemplars").iterdir())
        assert not list((tmp_path / "images").iterdir())
        assert store.all("images") == []
        states = {job["id"]: (job["state"], job["result"]) for job in store.all("jobs")}
        assert states == {"j": ("done", made), "k": ("interrupted", None)}
        told = json.loads((tmp_path / "results" / made / ".told.json").read_text())
        assert told == store.get("results", made)
        store.close()
