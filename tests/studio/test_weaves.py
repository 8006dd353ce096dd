"""Endless canvases over HTTP: tiles against windows of the library."""

from __future__ import annotations

import asyncio
import os
import socket
import time
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studio.served import Served, opened, pixels, png

import intarsia as ia
from intarsia.foundation.field import Field
from intarsia.studio.app import Weaves
from intarsia.studio.pictures import Pictures
from intarsia.studio.processes import FailedError, Process

PARALLEL = "parallel-controllable"

@pytest.fixture(scope="module")
def texture(tmp_path_factory: pytest.TempPathFactory) -> ia.Weave:
    """The small exemplar without end, in the library."""
    path = tmp_path_factory.mktemp("weave") / "small.png"
    path.write_bytes(png(pixels()))
    return ia.weave(str(path), PARALLEL, 5)


def begun(served: Served, exemplar: str, method: str = PARALLEL, **options: Any) -> Any:
    asked = {"exemplar": exemplar, "options": {"method": method, "seed": 5, **options}}
    return served.post("/api/weaves", asked, 201)


def tile(served: Served, weave: Any, y: int, x: int, level: int = 0) -> Any:
    return served.client.get(f"/api/weaves/{weave['id']}/{level}/{y}/{x}.png")


def averaged(picture: np.ndarray, side: int) -> np.ndarray:
    """Squares of so many px as one each."""
    high, wide = (n // side for n in picture.shape[:2])
    mean = picture.astype(float).reshape(high, side, wide, side, -1).mean(axis=(1, 3))
    return np.asarray(mean)


def worked(pid: int) -> float:
    """Seconds of work that a process has done."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


_further = count(1000)


def weaver_of(served: Served, row: Any) -> int:
    """The process that works more while tiles are drawn than afterwards: what prepares the others works in both."""

    def busy(pid: int) -> float:
        begin, since = worked(pid), time.monotonic()
        for _ in range(4):
            assert tile(served, row, 3, next(_further)).status_code == 200
        drawn = worked(pid)
        time.sleep(time.monotonic() - since)
        return 2 * drawn - begin - worked(pid)

    tile(served, row, 3, next(_further))
    return max(served.processes(), key=busy)


class TestTiles:
    def test_tiles_are_windows_of_the_endless_texture(self, served: Served, small: str, tmp_path: Path) -> None:
        row = begun(served, small, "repeat")
        path = tmp_path / "small.png"
        path.write_bytes(png(pixels()))
        texture = ia.weave(str(path), "repeat", 5)
        for y, x in ((0, 0), (-1, 2), (1000, -7)):
            drawn = opened(tile(served, row, y, x).content)
            assert np.array_equal(drawn, texture[256 * y : 256 * y + 256, 256 * x : 256 * x + 256])

    def test_a_picture_of_a_parameter_holds_on_the_canvas(
        self, served: Served, small: str, texture: ia.Weave
    ) -> None:
        numbers = (np.arange(64 * 64) % 256).reshape(64, 64).astype(np.uint8)
        row = begun(served, small, jitter_output=served.image(numbers))
        method: Any = texture.method
        jittered = replace(texture, method=replace(method, jitter_output=Field(numbers)))
        drawn = opened(tile(served, row, 0, 0).content)
        assert np.array_equal(drawn, jittered[0:256, 0:256])
        assert not np.array_equal(drawn, texture[0:256, 0:256])

    def test_another_seed_is_another_texture(self, served: Served, small: str, texture: ia.Weave) -> None:
        five, six = begun(served, small), begun(served, small, seed=6)
        assert np.array_equal(opened(tile(served, five, 1, -1).content), texture[256:512, -256:0])
        assert np.array_equal(opened(tile(served, six, 1, -1).content), replace(texture, seed=6)[256:512, -256:0])

    def test_a_reduced_tile_is_averaged_from_those_below(self, served: Served, small: str, texture: ia.Weave) -> None:
        row = begun(served, small, "repeat")
        for level in (1, 2):
            below = [
                np.concatenate(
                    [opened(tile(served, row, 2 * 3 + dy, -2 + dx, level=level - 1).content) for dx in (0, 1)], axis=1
                )
                for dy in (0, 1)
            ]
            whole = np.concatenate(below).astype(float).reshape(256, 2, 256, 2, 3).mean(axis=(1, 3))
            drawn = opened(tile(served, row, 3, -1, level=level).content)
            assert np.abs(drawn - whole).max() <= 0.5

    def test_a_tile_that_takes_long_is_drawn_in_turns(self, served: Served) -> None:
        exemplar = served.post("/api/exemplars", {"sample": "tiles"})["id"]
        row = begun(served, exemplar, "near-regular")
        drawn = opened(tile(served, row, 5, 5, level=3).content)
        known = ia.weave("sample:tiles", "near-regular", 5)[5 * 2048 : 6 * 2048, 5 * 2048 : 6 * 2048]
        assert np.abs(drawn - averaged(known, 8)).max() < 3

    @pytest.mark.parametrize("level", [1, 2, 3])
    def test_coarse_levels_look_like_what_they_become(self, served: Served, level: int) -> None:
        exemplar = served.post("/api/exemplars", {"sample": "stones"})["id"]
        row, side = begun(served, exemplar), 256 << level
        drawn = opened(tile(served, row, -1, 2, level=level).content).astype(float)[:128, :128]
        texture = ia.weave("sample:stones", PARALLEL, 5)
        known = averaged(texture[-side : side // 2 - side, 2 * side : 2 * side + side // 2], 1 << level)
        apart = np.abs(drawn - known).mean()
        assert apart < 0.35 * np.abs(drawn - np.roll(known, (40, 30), (0, 1))).mean()
        assert np.abs(drawn.mean(axis=(0, 1)) - known.mean(axis=(0, 1))).max() < 3

    @pytest.mark.parametrize(
        "options", [{"method": "graphcut"}, {"method": 3}, {"seed": -1}, {"seed": "x"}, {"nonsense": 1}, {"size": "64"},
                    {"jitter_output": "/etc/passwd", "method": PARALLEL}, {"method": "best-tile"}, {"window": 1}, []]
    )  # fmt: skip
    def test_what_is_no_weave_is_refused(self, served: Served, small: str, options: Any) -> None:
        asked = {"method": "repeat"} | options if isinstance(options, dict) else options
        answer = served.client.post("/api/weaves", json={"exemplar": small, "options": asked})
        assert answer.status_code == 400
        assert "\n" not in answer.json()["error"]

    @pytest.mark.parametrize("change", [{"exemplar": "x"}, {"exemplar": None}, {"words": 1}])
    def test_what_is_no_canvas_is_refused(self, served: Served, small: str, change: Any) -> None:
        assert served.client.post("/api/weaves", json={}).status_code == 400
        asked = {"exemplar": small, "options": {"method": "repeat"}} | change
        assert served.client.post("/api/weaves", json=asked).status_code == 400

    def test_one_that_is_drawn_has_one_seed(self, served: Served, small: str) -> None:
        row = begun(served, small, "repeat", seed="random")
        asked = {"size": "20x20", "origin": "0,0"}
        seeds = [served.post(f"/api/weaves/{row['id']}/window", asked, 200)["job"]["options"]["seed"] for _ in range(2)]
        assert seeds[0] == seeds[1] != 0

    def test_tiles_that_are_none_are_refused(self, served: Served, small: str) -> None:
        assert served.client.get("/api/weaves/0123456789abcdef/0/0/0.png").status_code == 404
        row = begun(served, small, "repeat")
        for path in ("0/x/0.png", "0/0/1e3.png", "0/99999999999999999999/0.png", "x/0/0.png", "0/0.png"):
            assert served.client.get(f"/api/weaves/{row['id']}/{path}").status_code == 404
        for path in (f"0/{1 << 33}/0.png", "4/0/0.png", "-1/0/0.png"):
            assert served.client.get(f"/api/weaves/{row['id']}/{path}").status_code == 400

    def test_a_tile_is_asked_of_the_process_with_whether_it_is_wanted(self) -> None:
        asked = list[int]()

        class Quiet(Process):
            async def _ask(self, do: str, heard: Any, given: dict[str, Any]) -> Any:
                asked.append(given["place"][2])
                return {}, b"tile"

        weaves = Weaves(None, Pictures())  # type: ignore[arg-type]
        weaves.weaver, weaves._known["w"] = Quiet(), ({}, {})

        async def drawn(x: int, wanted: bool) -> Any:
            async def gone() -> bool:
                return not wanted

            return await weaves.tile("w", [0, 0, x], gone)

        assert asyncio.run(drawn(1, True)) == b"tile"
        with pytest.raises(FailedError, match="nobody waits"):
            asyncio.run(drawn(2, False))
        assert asked == [1]

    def test_tiles_nobody_waits_for_are_not_drawn(self, served: Served) -> None:
        row = begun(served, served.post("/api/exemplars", {"sample": "stones"})["id"], seed=77)
        weaver = weaver_of(served, row)
        begin = worked(weaver)
        for x in range(10):
            tile(served, row, 0, x)
        one, sockets = (worked(weaver) - begin) / 10, []
        begin = worked(weaver)
        for x in range(60):
            asked = socket.create_connection((served.host, served.port))
            lines = (f"GET /api/weaves/{row['id']}/0/9/{x}.png HTTP/1.1", f"Host: {served.host}:{served.port}",
                     f"Authorization: Bearer {served.token}", "", "")  # fmt: skip
            asked.sendall("\r\n".join(lines).encode())
            sockets.append(asked)
        for asked in sockets:
            asked.close()
        assert tile(served, row, 0, 30).status_code == 200
        assert worked(weaver) - begin < 10 * one


class TestWindows:
    @pytest.mark.parametrize("painted", [False, True])
    def test_a_part_is_made_by_a_command_byte_for_byte(self, served: Served, small: str, painted: bool) -> None:
        gray = np.full((64, 64), 99, np.uint8)
        row = begun(served, small, kappa=3, **({"jitter_output": served.image(gray)} if painted else {}))
        asked = {"size": "300x200", "origin": "100,20"}
        found = served.post(f"/api/weaves/{row['id']}/window", asked, 200)
        first = "intarsia weave small.png --origin=100,20 -o small_woven.png --size=300x200 --method="
        assert found["command"].startswith(first)
        assert " --seed=5" in found["command"]
        assert ("--jitter-output=jitter_output.png" in found["command"]) == painted
        job = served.ended(served.post("/api/jobs", found["job"], 202))
        result = served.get(f"/api/results/{job['result']}")
        assert [entry["holds"] for entry in result["files"]] == ["albedo"]
        assert (result["size"], result["command"]) == ([300, 200], found["command"])
        drawn = opened(served.bytes(f"/api/results/{result['id']}/view/albedo.png?side=512"))
        whole = np.concatenate([opened(tile(served, row, 0, x).content) for x in (0, 1)], axis=1)
        assert np.array_equal(drawn, whole[20:220, 100:400])

    def test_what_is_no_part_is_refused(self, served: Served, small: str) -> None:
        row = begun(served, small)
        for change in ({"size": "0x5"}, {"size": 1.5}, {"origin": "1"}, {"origin": "1.5,2"}, {"z": 1}, {"size": True}):
            asked = {"size": "10x10", "origin": "0,0"} | change
            assert served.client.post(f"/api/weaves/{row['id']}/window", json=asked).status_code == 400
        assert served.client.post("/api/weaves/0123456789abcdef/window", json={}).status_code == 404

    def test_a_job_never_weaves_on_other_machines(self, served: Served, small: str) -> None:
        job = {"verb": "weave", "exemplars": [small], "options": {"size": "64", "dask": "tcp://127.0.0.1:1"}}
        answer = served.client.post("/api/jobs", json=job)
        assert answer.status_code == 400
        assert "dask" in answer.json()["error"]
