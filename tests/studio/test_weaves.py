"""Endless canvases over HTTP: tiles against windows of the library, strokes against a naive brush."""

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
from intarsia.field import Field
from intarsia.studio.beside import weaving
from intarsia.studio.beside.weaving import Painting, Stroke, painting_of
from intarsia.studio.processes import FailedError, Process
from intarsia.studio.showing import Pictures
from intarsia.studio.weaves import Weaves

PARALLEL = "parallel-controllable"
STROKES = [
    {"radius": 40, "strength": 0, "points": [[200, 100], [260, 130], [300, 130]]},
    {"radius": 24, "strength": 0.5, "points": [[250, 120]]},
    {"radius": 30, "strength": None, "points": [[290, 140], [310, 160]]},
]
PAINTED = {"ground": 0.9, "strokes": STROKES}


@pytest.fixture(scope="module")
def texture(tmp_path_factory: pytest.TempPathFactory) -> ia.Weave:
    """The small exemplar without end, in the library."""
    path = tmp_path_factory.mktemp("weave") / "small.png"
    path.write_bytes(png(pixels()))
    return ia.weave(str(path), PARALLEL, 5)


def naive(painted: Any) -> Any:
    """What strokes say, place by place."""

    def numbers(y: Any, x: Any) -> Any:
        y, x = np.broadcast_arrays(y, x)
        found = np.full(y.shape, float(painted["ground"]))
        for stroke in painted["strokes"]:
            points, radius = np.array(stroke["points"], float), stroke["radius"]
            apart = np.full(y.shape, np.inf)
            for (ax, ay), (bx, by) in zip(points, points[1:] if len(points) > 1 else points, strict=False):
                along = (x - ax) * (bx - ax) + (y - ay) * (by - ay)
                share = np.clip(along / max((bx - ax) ** 2 + (by - ay) ** 2, 1e-9), 0, 1)
                apart = np.minimum(apart, np.hypot(x - ax - share * (bx - ax), y - ay - share * (by - ay)))
            soft = np.clip(2 * (1 - apart / radius), 0, 1)
            weight = soft * soft * (3 - 2 * soft)
            aim = painted["ground"] if stroke["strength"] is None else stroke["strength"]
            found = found + (aim - found) * weight
        return np.rint(255 * found) / 255

    return numbers


def begun(served: Served, exemplar: str, jitter: Any = None, **more: Any) -> Any:
    asked = {"exemplar": exemplar, "method": PARALLEL, "seed": 5, **more}
    return served.post("/api/weaves", asked | ({"jitter": jitter} if jitter else {}), 201)


def tile(served: Served, weave: Any, y: int, x: int, known: str = "", level: int = 0) -> Any:
    return served.client.get(
        f"/api/weaves/{weave['id']}/{y}/{x}.png?level={level}", headers={"If-None-Match": known} if known else {}
    )


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
        row = served.post("/api/weaves", {"exemplar": small, "method": "repeat", "seed": 5}, 201)
        assert row["brush"] is False
        path = tmp_path / "small.png"
        path.write_bytes(png(pixels()))
        texture = ia.weave(str(path), "repeat", 5)
        for y, x in ((0, 0), (-1, 2), (1000, -7)):
            drawn = opened(served.bytes(f"/api/weaves/{row['id']}/{y}/{x}.png"))
            assert np.array_equal(drawn, texture[256 * y : 256 * y + 256, 256 * x : 256 * x + 256])

    def test_a_picture_of_a_parameter_holds_on_the_canvas(
        self, served: Served, small: str, texture: ia.Weave
    ) -> None:
        numbers = (np.arange(64 * 64) % 256).reshape(64, 64).astype(np.uint8)
        row = begun(served, small, options={"jitter_output": served.image(numbers)})
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
        row = served.post("/api/weaves", {"exemplar": small, "method": "repeat"}, 201)
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
        row = begun(served, exemplar, method="near-regular")
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
        "given", [{}, {"method": "graphcut"}, {"method": 3}, {"seed": -1}, {"seed": "x"}, {"options": {"nonsense": 1}},
                  {"options": {"jitter_output": "/etc/passwd"}, "method": PARALLEL}, {"exemplar": "x"},
                  {"method": "best-tile"}, {"options": []}, {"words": 1}, {"exemplar": None}, {"jitter": PAINTED},
                  {"jitter": PAINTED, "method": "auto"},
                  {"jitter": PAINTED, "method": PARALLEL, "options": {"jitter_output": 0.5}}]
    )  # fmt: skip
    def test_what_is_no_weave_is_refused(self, served: Served, small: str, given: Any) -> None:
        asked = {"exemplar": small, "method": "repeat"} | given if given else {}
        answer = served.client.post("/api/weaves", json=asked)
        assert answer.status_code == 400
        assert "\n" not in answer.json()["error"]

    @pytest.mark.parametrize(
        "jitter", [[], {"ground": 2}, {"strokes": {}}, {"more": 1}, {"ground": True},
                   {"strokes": [{"radius": 5, "points": [[0, 0]]}]},
                   {"strokes": [{"radius": 0, "strength": 0, "points": [[0, 0]]}]},
                   {"strokes": [{"radius": 5, "strength": 1.5, "points": [[0, 0]]}]},
                   {"strokes": [{"radius": 5, "strength": 0, "points": []}]},
                   {"strokes": [{"radius": 5, "strength": 0, "points": [[0]]}]},
                   {"strokes": [{"radius": 5, "strength": 0, "points": [[0, 0], [0, 1e9]]}]},
                   {"strokes": [{"radius": 5, "strength": 0, "points": [[0, 1e30]]}]},
                   {"strokes": [{"radius": 5, "strength": 0, "points": [[0, 0]]}] * 501},
                   {"strokes": [{"radius": 5, "strength": 0, "points": [[0, 0]] * 5001}]}]
    )  # fmt: skip
    def test_what_is_no_stroke_is_refused(self, served: Served, small: str, jitter: Any) -> None:
        answer = served.client.post("/api/weaves", json={"exemplar": small, "method": PARALLEL, "jitter": jitter})
        assert answer.status_code == 400
        assert "\n" not in answer.json()["error"]

    def test_tiles_that_are_none_are_refused(self, served: Served, small: str) -> None:
        assert served.client.get("/api/weaves/0123456789abcdef/0/0.png").status_code == 404
        row = served.post("/api/weaves", {"exemplar": small, "method": "repeat"}, 201)
        for path in ("x/0.png", "0/1e3.png", "99999999999999999999/0.png", "0/0.png?level=x"):
            assert served.client.get(f"/api/weaves/{row['id']}/{path}").status_code == 404
        for path in (f"{1 << 33}/0.png", "0/0.png?level=4", "0/0.png?level=-1"):
            assert served.client.get(f"/api/weaves/{row['id']}/{path}").status_code == 400

    def test_a_tile_is_asked_of_the_process_with_whether_it_is_wanted(self) -> None:
        asked = list[int]()

        class Quiet(Process):
            async def _ask(self, do: str, heard: Any, given: dict[str, Any]) -> Any:
                asked.append(given["x"])
                return {"key": "k"}, b"tile"

        weaves = Weaves(None, None, Pictures())  # type: ignore[arg-type]
        weaves.weaver, weaves._known["w"] = Quiet(), {"id": "w"}

        async def drawn(x: int, wanted: bool) -> Any:
            async def waits() -> bool:
                return wanted

            return await weaves.tile("w", (0, 0, x), "", waits)

        assert asyncio.run(drawn(1, True)) == ("k", b"tile")
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
            lines = (f"GET /api/weaves/{row['id']}/9/{x}.png HTTP/1.1", f"Host: {served.host}:{served.port}",
                     f"Authorization: Bearer {served.token}", "", "")  # fmt: skip
            asked.sendall("\r\n".join(lines).encode())
            sockets.append(asked)
        for asked in sockets:
            asked.close()
        assert tile(served, row, 0, 30).status_code == 200
        assert worked(weaver) - begin < 10 * one


class TestBrush:
    def test_strokes_are_a_function_of_the_place_alone(self) -> None:
        painting, known = painting_of(PAINTED), naive(PAINTED)
        rows, cols = np.arange(20, 260)[:, None], np.arange(120, 380)[None]
        whole = painting(rows, cols)
        assert np.abs(whole - known(rows * 1.0, cols * 1.0)).max() <= 1.01 / 255
        assert (whole == known(rows * 1.0, cols * 1.0)).mean() > 0.999
        assert whole.min() < 0.01
        assert np.array_equal(painting(rows[7:90:5], cols[:, 3:200:7]), whole[7:90:5, 3:200:7])
        assert len(np.unique(np.rint(255 * whole) / 255 - whole)) == 1

    def test_a_further_stroke_goes_on_from_the_others(self) -> None:
        rows, cols = np.arange(0, 256)[:, None], np.arange(0, 512)[None]
        strokes = painting_of(PAINTED).strokes
        for n in (1, 3, 2, 0, 3):
            drawn = Painting(0.9, strokes[:n])(rows, cols)
            fresh = Painting(0.9, (*strokes[:n], Stroke(1.0, 0.0, ((-9e9, -9e9),))))(rows, cols)
            assert np.array_equal(drawn, fresh)

    def test_tiles_are_those_of_the_library_with_the_same_function(
        self, served: Served, small: str, texture: ia.Weave
    ) -> None:
        row = begun(served, small, PAINTED)
        assert row["brush"] is True
        method: Any = texture.method
        jittered = replace(texture, method=replace(method, jitter_output=Field(painting_of(PAINTED))))
        drawn = [opened(tile(served, row, 0, x).content) for x in (0, 1)]
        assert np.array_equal(np.concatenate(drawn, axis=1), jittered[0:256, 0:512])
        assert not np.array_equal(drawn[0], texture[0:256, 0:256])

    def test_only_what_depends_on_a_stroke_is_drawn_anew(self, served: Served, small: str) -> None:
        before = begun(served, small, {"ground": 0.9})
        after = begun(served, small, PAINTED)
        assert before["id"] != after["id"]
        for y, x, touched in ((0, 0, True), (0, 1, True), (90, 3, False), (-40, -40, False)):
            first = tile(served, before, y, x)
            tag = first.headers["etag"]
            again = tile(served, after, y, x, known=tag)
            assert again.status_code == (200 if touched else 304)
            if touched:
                assert again.headers["etag"] != tag
                assert again.content != first.content
            else:
                assert again.content == b""
                assert tile(served, after, y, x).content == first.content
            assert tile(served, after, y, x, known=again.headers["etag"]).status_code == 304

    def test_what_is_known_is_not_drawn(self, monkeypatch: pytest.MonkeyPatch) -> None:
        words = ["weave", "sample:tiles", f"--method={PARALLEL}", "--size=1x1"]
        asked = {"words": words, "folder": os.getcwd(), "seed": 1, "jitter": PAINTED}
        asked |= {"id": "a", "base": "b", "level": 0, "y": 900, "x": 900}
        told, data = weaving.tile(asked | {"known": ""}, lambda **_: None)
        assert opened(data).shape == (256, 256, 3)
        monkeypatch.setattr(weaving, "_tile", None)
        assert weaving.tile(asked | {"known": told["key"]}, lambda **_: None) == (told, b"")

    def test_no_strokes_are_the_texture_itself(self, served: Served, small: str, texture: ia.Weave) -> None:
        row, plain = begun(served, small, {"ground": 1, "strokes": []}), begun(served, small)
        drawn = tile(served, row, 2, 2)
        assert np.array_equal(opened(drawn.content), texture[512:768, 512:768])
        assert tile(served, plain, 2, 2, known=drawn.headers["etag"]).status_code == 304


class TestWindows:
    @pytest.mark.parametrize("jitter", [None, PAINTED, {"ground": 0.5}])
    def test_a_part_is_made_by_a_command_byte_for_byte(self, served: Served, small: str, jitter: Any) -> None:
        row = begun(served, small, jitter, options={"kappa": 3})
        asked = {"x": 100, "y": 20, "width": 300, "height": 200}
        found = served.post(f"/api/weaves/{row['id']}/window", asked, 200)
        first = "intarsia weave small.png --origin=100,20 -o small_woven.tif --size=300x200 --method="
        assert found["command"].startswith(first)
        assert " --seed=5" in found["command"]
        assert ("--jitter-output=jitter_output.png" in found["command"]) == (jitter is PAINTED)
        job = served.ended(served.post("/api/jobs", found["job"], 202))
        result = served.get(f"/api/results/{job['result']}")
        assert [entry["holds"] for entry in result["files"]] == ["albedo"]
        assert (result["size"], result["command"]) == ([300, 200], found["command"])
        drawn = opened(served.bytes(f"/api/results/{result['id']}/view/albedo.png?side=512"))
        whole = np.concatenate([opened(tile(served, row, 0, x).content) for x in (0, 1)], axis=1)
        assert np.array_equal(drawn, whole[20:220, 100:400])

    def test_what_no_picture_can_say_is_refused(self, served: Served, small: str) -> None:
        far = {"ground": 1, "strokes": [{"radius": 40, "strength": 0, "points": [[-60, 100]]}]}
        row = begun(served, small, far)
        near = {"x": -100, "y": 0, "width": 200, "height": 200}
        answer = served.client.post(f"/api/weaves/{row['id']}/window", json=near)
        assert answer.status_code == 400
        assert "Paint farther right" in answer.json()["error"]

    def test_what_is_no_part_is_refused(self, served: Served, small: str) -> None:
        row = begun(served, small)
        for change in ({"width": 0}, {"height": 1 << 15}, {"x": 1 << 41}, {"y": 1.5}, {"z": 1}, {"width": True}):
            asked = {"x": 0, "y": 0, "width": 10, "height": 10} | change
            assert served.client.post(f"/api/weaves/{row['id']}/window", json=asked).status_code == 400
        assert served.client.post("/api/weaves/0123456789abcdef/window", json={}).status_code == 404

    def test_a_job_never_weaves_on_other_machines(self, served: Served, small: str) -> None:
        for name, value in (("dask", "tcp://127.0.0.1:1"), ("executor", "processes")):
            job = {"verb": "weave", "exemplars": [small], "options": {"size": "64", name: value}}
            answer = served.client.post("/api/jobs", json=job)
            assert answer.status_code == 400
            assert name in answer.json()["error"]
