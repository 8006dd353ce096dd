"""A studio in a process of its own, and what a client does with it."""

from __future__ import annotations

import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from PIL import Image

QUICK = {"method": "image-quilting", "patch": "8", "size": "48x40"}
"""Options of a job that takes no time to speak of."""


ENTRANCE = re.compile(r"(http://(127(?:\.\d+){3}):(\d+)/)\?enter=[0-9a-f]{32}")


class Served:
    """A running studio."""

    def __init__(self, folder: Path, *words: str, browser: bool = False) -> None:
        self.folder = folder
        words = (*words, "--folder", str(folder)) if browser else (*words, "--folder", str(folder), "--no-browser")
        command = [sys.executable, "-m", "intarsia", "studio", *words]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
        assert self.process.stderr is not None
        self.line = self.process.stderr.readline()
        found = ENTRANCE.search(self.line)
        if found is None:
            self.line += self.process.communicate(timeout=20)[1]
            raise AssertionError(self.line)
        self.address, self.host, self.port = found[1], found[2], int(found[3])
        self.token = (folder / ".authorization").read_text().split()[-1]
        headers = {"Authorization": f"Bearer {self.token}", "X-Intarsia": "1"}
        self.said = ""
        self.client = httpx.Client(base_url=self.address, headers=headers, timeout=120)

    def entrance(self) -> str:
        """The address that was printed last, to be opened now, as it lets in once; the next is printed then."""
        assert self.process.stderr is not None
        while (found := ENTRANCE.search(self.line)) is None:
            self.line = self.process.stderr.readline()
            assert self.line
        self.line = ""
        return found[0]

    def close(self) -> str:
        """End it as Ctrl-C does; return what it said since it began."""
        self.client.close()
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        assert self.process.stderr is not None
        if not self.process.stderr.closed:
            self.said = self.process.communicate(timeout=30)[1]
        return self.said

    def kill(self) -> None:
        """End it as a power cut does."""
        self.client.close()
        self.process.kill()
        self.process.wait()
        assert self.process.stderr is not None
        self.process.stderr.close()

    def get(self, path: str) -> Any:
        """JSON of an address that is there."""
        answer = self.client.get(path)
        assert answer.status_code == 200, answer.text
        return answer.json()

    def bytes(self, path: str) -> bytes:
        """Bytes of an address that is there."""
        answer = self.client.get(path)
        assert answer.status_code == 200, answer.text
        return answer.content

    def post(self, path: str, given: Any = None, status: int | None = None) -> Any:
        """JSON of what was sent."""
        answer = self.client.post(path, json=given)
        assert answer.status_code == status if status else answer.status_code < 300, answer.text
        return answer.json()

    def exemplar(self, **files: bytes) -> Any:
        """Send the files of an exemplar: name without .png -> contents."""
        parts = [("files", (f"{name}.png", data)) for name, data in files.items()]
        answer = self.client.post("/api/exemplars", files=parts)
        assert answer.status_code == 201, answer.text
        return answer.json()

    def image(self, pixels: np.ndarray) -> str:
        """Send a picture of numbers; its id."""
        answer = self.client.post("/api/images", content=png(pixels))
        assert answer.status_code == 201, answer.text
        return str(answer.json()["id"])

    def job(self, verb: str, exemplars: list[str], **options: Any) -> Any:
        """Queue a job."""
        return self.post("/api/jobs", {"verb": verb, "exemplars": exemplars, "options": options}, 202)

    def held(self, exemplar: str) -> list[Any]:
        """Jobs that keep both processes busy for minutes: one that is long, and one that is taken for short."""
        return [
            self.job("grow", [exemplar], method="image-quilting", patch="4", overlap="3", size=size)
            for size in ("1600x1600", "724x724")
        ]

    def let(self, held: list[Any]) -> None:
        """Stop these jobs."""
        for job in held:
            self.post(f"/api/jobs/{job['id']}/cancel")
        for job in held:
            self.ended(job)

    def ended(self, job: Any, within: float = 240) -> Any:
        """Wait for the end of a job."""
        until = time.monotonic() + within
        while time.monotonic() < until:
            now = self.get(f"/api/jobs/{job['id']}")
            if now["state"] not in ("queued", "running"):
                return now
            time.sleep(0.02)
        raise AssertionError(now)

    def done(self, verb: str, exemplars: list[str], **options: Any) -> Any:
        """The result of a job that succeeds."""
        job = self.ended(self.job(verb, exemplars, **options))
        assert job["state"] == "done", job
        return self.get(f"/api/results/{job['result']}")

    def file(self, result: Any, entry: Any) -> str:
        """Where a file of a result lies."""
        return f"/api/results/{result['id']}/files/{entry['name']}"

    def plane(self, row: Any, number: int = 0) -> bytes:
        """What is seen of a plane of an exemplar."""
        return self.bytes(f"/api/exemplars/{row['id']}/{row['planes'][number]['name']}.png")

    def files(self, result: Any) -> dict[str, bytes]:
        """The files of a result."""
        return {entry["name"]: self.bytes(self.file(result, entry)) for entry in result["files"]}

    def events(self) -> Iterator[tuple[str, Any]]:
        """What is told, one event after another."""
        with self.client.stream("GET", "/api/events") as answer:
            kind = ""
            for line in answer.iter_lines():
                if line.startswith("event: "):
                    kind = line[7:]
                elif line.startswith("data: "):
                    yield kind, json.loads(line[6:])

    def processes(self) -> list[int]:
        """The processes that the server has started and that live."""
        return children(self.process.pid)


def run(*words: str) -> subprocess.CompletedProcess[str]:
    """What the command says that ends by itself, mostly because it refuses."""
    line = [sys.executable, "-m", "intarsia", "studio", "--no-browser", *words]
    return subprocess.run(line, capture_output=True, text=True, timeout=60)


def children(parent: int) -> list[int]:
    """The numbers of living processes whose parent is this one."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == parent and fields[0] != "Z":
            found.append(int(path.parent.name))
    return found


def lives(pid: int) -> bool:
    """Whether a process is there."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return "Z" not in Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]


@contextmanager
def studio(folder: Path, *words: str, browser: bool = False) -> Iterator[Served]:
    """A studio for a while."""
    served = Served(folder, *words, browser=browser)
    try:
        yield served
    finally:
        served.close()


def png(pixels: np.ndarray) -> bytes:
    """A PNG of these pixels."""
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "png")
    return out.getvalue()


def pixels(height: int = 32, width: int = 36, seed: int = 0) -> np.ndarray:
    """A small colourful picture."""
    y, x = np.mgrid[:height, :width]
    planes = [(x * (7 + seed) + y * (3 + k) + (x * y * (k + 5)) % 31) % 256 for k in range(3)]
    return np.stack(planes, axis=2).astype(np.uint8)


def opened(data: bytes) -> np.ndarray:
    """The pixels of a PNG."""
    return np.asarray(Image.open(io.BytesIO(data)))
