"""How the studio begins and ends, and what is said when it cannot."""

from __future__ import annotations

import asyncio
import json
import os
import re
import socket
import stat
import subprocess
import sys
import time
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any

import httpx
import pytest
from starlette.exceptions import HTTPException
from studio.served import QUICK, Served, lives, pixels, png, run, studio

import intarsia as ia
from intarsia.cli.commands import studio as command
from intarsia.plugins import CONTRACT
from intarsia.studio import security, serving


def test_from_its_first_second_to_an_end_without_a_trace(tmp_path: Path) -> None:
    """The page does not wait for kernels, they are told of, files are taken, and nothing is left at the end."""
    (tmp_path / "rock.png").write_bytes(png(pixels()))
    served = Served(tmp_path / "folder", str(tmp_path / "rock.png"), "sample:tiles")
    began = time.monotonic()
    assert b"<html" in served.bytes("/").lower()
    assert served.get("/api/schema")["verbs"]
    assert served.get("/api/jobs") == []
    assert time.monotonic() - began < 1
    told = []
    for kind, said in served.events():
        assert kind == "warm"
        told.append(said)
        if said["done"] == said["total"]:
            break
    assert [t["done"] for t in told] == sorted(t["done"] for t in told)
    until = time.monotonic() + 30
    while len(served.get("/api/exemplars")) < 2 and time.monotonic() < until:
        time.sleep(0.05)
    found = {row["name"]: row["id"] for row in served.get("/api/exemplars")}
    assert set(found) == {"rock", "tiles"}
    served.done("grow", [found["rock"]], **QUICK)
    with served.client.stream("GET", "/api/events"):  # somebody still listens
        pids = served.processes()
        assert len(pids) >= 2
        began = time.monotonic()
        said = served.close()
    assert time.monotonic() - began < 5
    assert said.strip() == "the studio has ended"
    assert served.process.returncode == 0
    assert not any(map(lives, pids))


def test_a_port_that_is_taken_is_told_in_one_line(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("0.0.0.0", 0))
        taken.listen()
        port = taken.getsockname()[1]
        done = run("--folder", str(tmp_path / "folder"), "--port", str(port))
    assert done.returncode != 0
    assert f"port {port}" in done.stderr
    assert "--port" in done.stderr
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize(
    "words", [("missing.png",), ("--port", "70000"), ("--folder", "/proc/nowhere/x"), ("--folder", __file__)]
)
def test_what_cannot_be_is_told_in_one_line(tmp_path: Path, words: tuple[str, ...]) -> None:
    folder = () if "--folder" in words else ("--folder", str(tmp_path / "folder"))
    done = run(*words, *folder)
    assert done.returncode in (1, 2, 3)
    assert len(done.stderr.strip().splitlines()) == 1
    assert "Traceback" not in done.stderr
    assert "Errno" not in done.stderr


def test_without_its_packages_it_says_how_they_are_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = """
import sys
from importlib.abc import MetaPathFinder
class Missing(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("starlette", "uvicorn"):
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Missing())
import importlib.util
real = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: None if name in ("starlette", "uvicorn") else real(name, package)
sys.argv = ["intarsia", "studio", "--no-browser"]
from intarsia.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.returncode == 1
    assert "needs starlette and uvicorn; " in done.stderr
    assert "pip install starlette uvicorn (in a checkout make studio does it)" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())
    assert set(command.NEEDED) == {"starlette", "uvicorn", "python_multipart"}


def test_the_browser_is_opened_by_a_file_that_nobody_else_reads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Everybody sees what a program is started with: that holds no secret. The file is gone once it was used."""
    browser, seen = tmp_path / "browser", tmp_path / "seen"
    browser.write_text(f'#!/bin/sh\nprintf "%s\\n" "$@" > {seen}.part\nmv {seen}.part {seen}\n')
    browser.chmod(0o755)
    monkeypatch.setenv("BROWSER", f"{browser} %s")
    with studio(tmp_path / "folder", browser=True) as served:
        until = time.monotonic() + 30
        while not seen.exists() and time.monotonic() < until:
            time.sleep(0.05)
        page = Path(seen.read_text().strip().removeprefix("file://"))
        code = re.search("url=(.*[?]enter=([0-9a-f]{32}))", page.read_text())
        assert code is not None
        for secret in (served.token, code[2]):
            assert secret not in seen.read_text()
            assert secret not in Path(f"/proc/{served.process.pid}/cmdline").read_text()
        for path in (page, served.folder / ".authorization"):
            assert path.stat().st_mode & 0o77 == 0
        sent = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}
        assert httpx.get(code[1], headers=sent).status_code == 200
        assert not page.exists()
        assert httpx.get(code[1], headers=sent).status_code == 401
        assert httpx.get(served.entrance()).status_code == 200  # what was printed is good as well
        assert "a browser came in" in served.close()
    assert not (served.folder / ".authorization").exists()
    assert not list((served.folder / "images").iterdir())


def test_connections_on_which_nothing_is_asked_end_and_give_way(tmp_path: Path) -> None:
    with studio(tmp_path / "folder") as served:
        place, half = (served.host, served.port), f"GET / HTTP/1.1\r\nHost: {served.host}:{served.port}\r\n".encode()
        began, lines = time.monotonic(), list[socket.socket]()
        for number in range(500):
            lines.append(socket.create_connection(place, 20))
            lines[-1].sendall(half if number % 2 else b"")
        with httpx.Client(headers=served.client.headers) as late:
            assert late.get(f"{served.address}api/jobs").status_code == 200
            assert len(list(Path(f"/proc/{served.process.pid}/fd").iterdir())) < serving.QUIET + 60
            assert time.monotonic() - began < serving.SOON
            slow = socket.create_connection(place, 20)
            slow.sendall(half + f"Authorization: Bearer {served.token}\r\n\r\n".encode())
            assert slow.recv(20).startswith(b"HTTP/1.1 200")
            slow.sendall(half)  # the next one is not waited for, either
            for line in [*lines, slow]:
                with line, suppress(ConnectionResetError):  # by what it had sent already
                    while line.recv(1 << 16):
                        pass
            assert time.monotonic() - began < 3 * serving.SOON
            assert late.get(f"{served.address}api/jobs").status_code == 200


def test_what_is_no_http_is_answered_as_all_is(tmp_path: Path) -> None:
    with studio(tmp_path / "folder") as served, socket.create_connection((served.host, served.port), 20) as line:
        line.sendall(b"nonsense\r\n\r\n")
        answer = line.makefile("rb").read().decode()
    assert answer.startswith("HTTP/1.1 400 ")
    assert all(f"{name}: {value}\r\n" in answer for name, value in security.HEADERS.items())


@pytest.mark.parametrize(
    "head", [b"GET / HTTP/1.1\nHost: x\n\n", b"GET / HTTP/1.1\r\nHost: HOST\nX: y\r\n\r\n",
             b"GET / HTTP/1.1\r\nHost: HOST\r\nX: y\r\n z\r\n\r\n", b"GET / HTTP/1.1\r\nHost: HOST\r\n\tx\r\n\r\n"]
)  # fmt: skip
def test_lines_that_servers_read_in_two_ways_are_refused(served: Served, head: bytes) -> None:
    host = f"{served.host}:{served.port}".encode()
    good = b"GET / HTTP/1.1\r\nHost: HOST\r\n\r\n"
    for sent, status in ((head, [400]), (good + head, [401, 400]), (good, [401])):
        with socket.create_connection((served.host, served.port), 20) as line:
            line.sendall(sent.replace(b"HOST", host))
            if status[-1] != 400:
                line.shutdown(socket.SHUT_WR)
            answer = line.makefile("rb").read().decode()  # it is closed by the server
        assert [int(found) for found in re.findall(r"HTTP/1\.1 (\d+)", answer)] == status


@pytest.mark.parametrize("parts", [[True], [False, True]], ids=["slow", "whole"])
def test_a_body_that_does_not_come_is_not_waited_for(parts: list[bool], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(security, "SLOWEST", 0.05)
    slow = parts == [True]

    async def app(scope: Any, receive: Any, send: Any) -> None:
        while (await receive()).get("more_body"):
            pass

    async def receive() -> Any:
        if not parts:
            await asyncio.sleep(60)
        return {"type": "http.request", "body": b"x", "more_body": parts.pop()}

    host = [(b"host", b"127.0.0.1:1"), (b"authorization", b"Bearer t"), (b"x-intarsia", b"1")]
    scope = {"type": "http", "method": "POST", "path": "/api/jobs", "headers": host, "query_string": b""}
    layer = security.Safety(app, "t")
    layer.port = 1
    with pytest.raises(HTTPException, match="408") if slow else nullcontext():
        asyncio.run(layer(scope, receive, None))  # type: ignore[arg-type]


def test_other_programs_are_told_where_it_listens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Only this user can read it; it goes with the studio, and so do those of studios that were killed."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "run"))
    (tmp_path / "run" / "intarsia").mkdir(parents=True)
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    left, other = (tmp_path / "run" / "intarsia" / f"studio-{pid}.json" for pid in (gone.pid, os.getpid()))
    for path in (left, other):
        path.write_text("{}")
    with studio(tmp_path / "own") as served:
        place = tmp_path / "run" / "intarsia" / f"studio-{served.process.pid}.json"
        assert stat.S_IMODE(place.stat().st_mode) == 0o600
        told = json.loads(place.read_text())
        assert (told["contract"], told["version"]) == (CONTRACT, ia.__version__)
        headers = {"Authorization": f"Bearer {told['token']}", "X-Intarsia": "1"}
        assert httpx.get(f"{told['address']}/api/exemplars", headers=headers).json() == []
        assert (left.exists(), other.exists()) == (False, True)
    assert not place.exists()
