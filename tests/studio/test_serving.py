"""How the studio begins and ends, and what is said when it cannot."""

from __future__ import annotations

import asyncio
import socket
import subprocess
import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from starlette.exceptions import HTTPException
from studio.served import QUICK, Served, lives, pixels, png

from intarsia.cli.commands import studio as command
from intarsia.studio import safety


def run(*words: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "intarsia", "studio", "--no-browser", *words]
    return subprocess.run(line, capture_output=True, text=True, timeout=60)


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
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        done = run("--folder", str(tmp_path / "folder"), "--port", str(port))
    assert done.returncode != 0
    assert f"port {port}" in done.stderr
    assert "--port" in done.stderr
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("words", [("missing.png",), ("--port", "70000"), ("--folder", "/proc/nowhere/x")])
def test_what_cannot_be_is_told_in_one_line(tmp_path: Path, words: tuple[str, ...]) -> None:
    folder = () if "--folder" in words else ("--folder", str(tmp_path / "folder"))
    done = run(*words, *folder)
    assert done.returncode in (1, 2, 3)
    assert len(done.stderr.strip().splitlines()) == 1
    assert "Traceback" not in done.stderr


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
from intarsia.cli import main
main()
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.returncode == 1
    assert "pip install 'intarsia[studio]'" in done.stderr
    assert "starlette and uvicorn" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())
    assert set(command.NEEDED) == {"starlette", "uvicorn", "python_multipart"}


@pytest.mark.parametrize("parts", [[True], [False, True]], ids=["slow", "whole"])
def test_a_body_that_does_not_come_is_not_waited_for(parts: list[bool], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(safety, "SLOWEST", 0.05)
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
    layer = safety.Safety(app, "t")
    layer.port = 1
    with pytest.raises(HTTPException, match="408") if slow else nullcontext():
        asyncio.run(layer(scope, receive, None))  # type: ignore[arg-type]
