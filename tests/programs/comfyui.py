"""Run the nodes in a real ComfyUI server, on the processor, and compare what it saves with what the library makes.

    INTARSIA_COMFYUI=~/ComfyUI python tests/programs/comfyui.py

INTARSIA_COMFYUI is a folder with main.py; INTARSIA_COMFYUI_PYTHON a Python that has ComfyUI's packages and intarsia's
(by default that of .venv or venv in the folder). Nothing is written there: the server works in a temporary folder.
Exits with 77 where there is no ComfyUI, with 1 if a check fails.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import intarsia as ia

PACKAGE = Path(ia.__file__).resolve().parent
NODES = PACKAGE / "plugins" / "hosts" / "comfyui" / "intarsia-textures"
WAIT = 300  # s: for the server to start, or one workflow to end
SKIPPED = 77
Graph = dict[str, dict[str, Any]]


class Failed(Exception):
    pass


def check(what: str, good: object) -> None:
    if not good:
        raise Failed(what)
    print(f"  {what}", flush=True)


def found() -> tuple[Path, str] | str:
    """The folder of ComfyUI and its Python, or why there is none."""
    named = os.environ.get("INTARSIA_COMFYUI")
    if not named:
        return "INTARSIA_COMFYUI names no folder of ComfyUI"
    folder = Path(named).expanduser().resolve()
    if not (folder / "main.py").is_file():
        return f"{folder} has no main.py"
    pythons = [folder / venv / part for venv in (".venv", "venv") for part in ("bin/python", "Scripts/python.exe")]
    python = os.environ.get("INTARSIA_COMFYUI_PYTHON") or next((str(p) for p in pythons if p.is_file()), sys.executable)
    packages = "import torch, aiohttp, numba, numpy, scipy, skimage"
    if subprocess.run([python, "-c", packages], capture_output=True, check=False).returncode:
        return f"{python} lacks packages of ComfyUI or intarsia; name another as INTARSIA_COMFYUI_PYTHON"
    return folder, python


class Server:
    """A running ComfyUI, asked as its page asks it."""

    def __init__(self, home: Path, port: int) -> None:
        self.home, self.address = home, f"http://127.0.0.1:{port}"

    def ask(self, path: str, data: Any = None) -> Any:
        body = None if data is None else json.dumps(data).encode()
        request = urllib.request.Request(self.address + path, body, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=60) as answer:
            text = answer.read()
        return json.loads(text) if text else None

    def begin(self, graph: Graph) -> str:
        return str(self.ask("/prompt", {"prompt": graph})["prompt_id"])

    def end(self, job: str) -> dict[str, Any]:
        """Wait for a workflow; return what its history tells."""
        for _ in range(WAIT * 10):
            if told := self.ask(f"/history/{job}").get(job):
                return dict(told)
            time.sleep(0.1)
        raise Failed(f"a workflow did not end in {WAIT} s")

    def saved(self, graph: Graph) -> dict[str, Any]:
        """Run a workflow; return the pictures of its Save Images by their prefixes."""
        told = self.end(self.begin(graph))
        if told["status"]["status_str"] != "success":
            raise Failed(f"a workflow ended with {self.error(told)}")
        pictures = {}
        for node, output in told["outputs"].items():
            for one in output.get("images", []):
                path = self.home / one["type"] / one["subfolder"] / one["filename"]
                pictures[graph[node]["inputs"].get("filename_prefix", one["type"])] = ia.read(path).base.pixels
        return pictures

    @staticmethod
    def error(told: dict[str, Any]) -> str:
        messages = [data for event, data in told["status"]["messages"] if event == "execution_error"]
        return str(messages[0]["exception_message"]).strip() if messages else str(told["status"])


@contextmanager
def running(folder: Path, python: str) -> Iterator[Server]:
    """ComfyUI with these nodes and no others, in a temporary folder."""
    with tempfile.TemporaryDirectory(prefix="intarsia-comfyui-") as name:
        home = Path(name)
        for part in ("input", "output", "temp", "user", "models", "custom_nodes"):
            (home / part).mkdir()
        shutil.copytree(NODES, home / "custom_nodes" / "intarsia-textures")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        options = ["--cpu", "--disable-auto-launch", "--disable-api-nodes", "--base-directory", name]
        paths = [str(PACKAGE.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
        with open(home / "log.txt", "wb") as log:
            process = subprocess.Popen(
                [python, "main.py", *options, "--port", str(port)], cwd=folder, stdout=log, stderr=log,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
            )  # fmt: skip
            try:
                server = Server(home, port)
                for _ in range(WAIT * 2):
                    try:
                        server.ask("/system_stats")
                        break
                    except OSError:
                        if process.poll() is not None:
                            raise Failed("ComfyUI ended: " + (home / "log.txt").read_text()[-2000:]) from None
                        time.sleep(0.5)
                else:
                    raise Failed(f"ComfyUI did not answer in {WAIT} s")
                yield server
            finally:
                process.terminate()
                process.wait()


def load(name: str) -> dict[str, Any]:
    return {"class_type": "LoadImage", "inputs": {"image": name}}


def keep(node: str, output: int, name: str) -> dict[str, Any]:
    return {"class_type": "SaveImage", "inputs": {"images": [node, output], "filename_prefix": name}}


def node(name: str, **inputs: Any) -> dict[str, Any]:
    return {"class_type": f"Intarsia{name}", "inputs": inputs}


def checks(server: Server) -> None:
    """A material grown, tiled, healed, judged and shown; an error; an interrupt."""
    known = {name: told for name, told in server.ask("/object_info").items() if name.startswith("Intarsia")}
    version = server.ask("/system_stats")["system"].get("comfyui_version", "")
    check(f"ComfyUI {version} has {len(known)} nodes of ours", len(known) == 5)
    colour = ia.read("sample:setts").base.pixels[:128, :128, :3]
    normal = np.dstack([colour[:, :, :2] // 4 + 96, np.full((128, 128), 250, np.uint8)])
    gray = np.repeat(colour[:, :, 1:2], 3, axis=2)
    hole = np.zeros((128, 128), bool)
    hole[40:70, 50:90] = True
    holed = np.dstack([colour, np.where(hole, 0, 255).astype(np.uint8)])
    for name, pixels in {"colour": colour, "normal": normal, "gray": gray, "holed": holed}.items():
        ia.write(server.home / "input" / f"{name}.png", pixels)
    sources = {"1": load("colour.png"), "2": load("normal.png"), "3": load("gray.png"), "4": load("holed.png")}
    planes = {"albedo": colour, "normal": normal, "roughness": gray}

    size = {"width": 192, "height": 160}
    grow = node("Grow", image=["1", 0], normal_map=["2", 0], roughness_map=["3", 0], tileable="both", method="auto",
                seed=2, unusable=["1", 1], **size)  # fmt: skip
    made = server.saved(sources | {"5": grow, "6": keep("5", 0, "albedo"), "7": keep("5", 1, "normal"),
                                   "8": keep("5", 2, "roughness"), "9": keep("5", 3, "metallic")})  # fmt: skip
    wanted = ia.synthesize(planes, (160, 192), seed=2, wrap="both")
    same = all((made[name] == wanted.render(name).pixels).all() for name in planes)
    check("Grow Texture: image and maps are the library's", same)
    check("and what is linked to a map that is not there is not run", "metallic" not in made)

    tile = node("Tile", image=["1", 0], tileable="both", crop="to whole periods", band=0, seed=1)
    preview = node("TilePreview", image=["5", 0], times=2)
    made = server.saved(sources | {"5": tile, "6": keep("5", 0, "a"), "7": preview})
    wanted = ia.tile(colour, seed=1)
    check("Make Tileable: the library's", (made["a"] == wanted.render().pixels).all())
    check("Tile Preview: four of them", (made["temp"] == np.tile(made["a"], (2, 2, 1))).all())

    heal = node("Heal", image=["4", 0], mask=["4", 1], grow_mask=0, seed=0)
    made = server.saved(sources | {"5": heal, "6": keep("5", 0, "a")})
    check("Heal Texture: by the mask of Load Image, the library's",
          (made["a"] == ia.heal(colour, hole, grow=0).render().pixels).all())  # fmt: skip

    for least, passes in ((0.0, True), (100.0, False)):
        judge = node("Score", example=["1", 0], image=["5", 0], tileable="both", least=least)
        made = server.saved(sources | {"5": tile, "6": judge, "7": keep("6", 2, "a"), "8": keep("5", 0, "b")})
        check(f"Score Texture: {'passes' if passes else 'stops'} with least {least:g}", ("a" in made) is passes)

    white = {"class_type": "SolidMask", "inputs": {"value": 1.0, "width": 128, "height": 128}}
    all_of_it = node("Heal", image=["1", 0], mask=["5", 0], grow_mask=0, seed=0)
    told = server.end(server.begin(sources | {"5": white, "6": all_of_it, "7": keep("6", 0, "a")}))
    check(f"an error is one line: {server.error(told)}", server.error(told).startswith("the hole covers all of image"))

    large = grow["inputs"] | {"width": 4096, "height": 4096, "seed": 9}
    job = server.begin(sources | {"5": {**grow, "inputs": large}, "6": keep("5", 0, "never")})
    time.sleep(3)
    server.ask("/interrupt", {})
    events = [event for event, _ in server.end(job)["status"]["messages"]]
    check("an interrupt ends a large one", "execution_interrupted" in events)
    check("and leaves no picture", not list((server.home / "output").glob("never*")))


def main() -> int:
    place = found()
    if isinstance(place, str):
        print(f"comfyui: skipped, {place}.")
        return SKIPPED
    print("comfyui:", flush=True)
    try:
        with running(*place) as server:
            checks(server)
    except (Failed, urllib.error.HTTPError) as error:
        detail = error.read().decode() if isinstance(error, urllib.error.HTTPError) else ""
        print(f"comfyui: FAILED: {error} {detail}".rstrip())
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
