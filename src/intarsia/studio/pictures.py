"""Pictures for the page, drawn by worker processes and cached: views, findings, drafts, sketches, reports, archives."""

from __future__ import annotations

import asyncio
import json
import shutil
import zipfile
from collections import OrderedDict
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path
from shlex import quote
from typing import Any

from ..foundation import AUTO_METHOD, InputError, ParameterError, said
from ..methods import METHODS
from ..request import from_json
from .processes import FailedError, Gone, Process
from .requests import MAP, origin_of, words_of
from .store import Row, Store
from .uploads import Uploads

VIEWS = ("pieces", "seams", "usage", "provenance")
LABELS = 6  # that the page paints with
DRAFTED = ("grow", "paint")
"""The verbs of which there are drafts."""

WITHIN = 120.0  # s for one picture
REPORT = "report.html"
EDITS = ("straighten", "propose")
HELD = 64 << 20  # bytes of cached pictures
AGAIN = 0.1  # s between two checks for other work
LONGEST_WAY = 99  # steps of which an archive tells
IDLE = 60.0  # s after which an idle process ends


class Pictures:
    """An LRU cache of pictures, limited in bytes."""

    def __init__(self, most: int = HELD) -> None:
        self._held: OrderedDict[tuple[Any, ...], bytes] = OrderedDict()
        self._most, self._size = most, 0

    async def get(self, key: tuple[Any, ...], draw: Callable[[], Awaitable[bytes | None]]) -> bytes:
        """Return a cached picture, or draw it, again until it is not None; the least recently used ones are dropped."""
        found = self._held.get(key)
        while found is None:
            found = await draw()
        self._size += len(found) - len(self._held.pop(key, b""))
        self._held[key] = found
        while self._size > self._most:
            self._size -= len(self._held.popitem(last=False)[1])
        return found


class Showing:
    """Has worker processes draw what is requested, and caches it."""

    def __init__(self, store: Store, uploads: Uploads, beside: Process) -> None:
        self.store, self.uploads, self.beside, self.pictures = store, uploads, beside, Pictures()

    async def _drawn(self, process: Process, do: str, **given: Any) -> bytes:
        async def draw() -> bytes:
            _, data = await process.ask(do, within=WITHIN, **given)
            return data

        return await self.pictures.get((do, str(given)), draw)  # files are named by their contents

    # exemplars

    async def exemplar(self, row: Row, plane: str, sight: Row) -> bytes:
        """Return a plane of an exemplar as PNG."""
        if plane not in [known["name"] for known in row["planes"]]:
            raise InputError(f"this exemplar has no plane {said(plane)}.")
        return await self.seen(self.uploads.paths_of(row), plane, sight)

    async def seen(self, paths: list[str], plane: str, sight: Row) -> bytes:
        """Return a plane of files as PNG."""
        return await self._drawn(self.uploads.looker, "see", paths=paths, plane=plane, **sight)

    async def found(self, row: Row) -> Row:
        """Return the findings of an exemplar, stored because the analysis is slow."""
        known = self.store.get("found", row["id"])
        if known is None:
            answer, _ = await self.beside.ask("find", within=WITHIN, paths=self.uploads.paths_of(row))
            known = self.store.put("found", answer | {"id": row["id"]})
        return known

    async def overlay(self, row: Row, kind: str) -> bytes:
        """Return findings as a picture to overlay on the exemplar."""
        return await self._drawn(self.beside, "overlay", paths=self.uploads.paths_of(row), kind=kind)

    async def labels(self, row: Row, count: int) -> bytes:
        """Return so many labels that are proposed for an exemplar, as a picture of numbers."""
        if not 2 <= count <= LABELS:
            raise ParameterError(f"{count} labels cannot be proposed; ask for 2 to {LABELS}.")
        return await self._drawn(self.beside, "propose", paths=self.uploads.paths_of(row), count=count)

    async def rim(self, row: Row, image: Row) -> tuple[int, bytes]:
        """Return by how many px a hole would grow to cover the rim of a defect, and that area as an overlay."""
        paths, mask = self.uploads.paths_of(row), str(self.store.place("images", image["id"]))
        told, data = await self.beside.ask("rim", within=WITHIN, paths=paths, mask=mask)
        return told["grow"], data

    async def edited(self, row: Row, given: Row) -> Row:
        """Crop, straighten or flatten an exemplar, or propose its maps, into a new one; `crop` is as in `grow`."""
        does = {"straighten": False, "propose": False, **given}
        if set(does) - {"crop", "flatten", *EDITS} or not all(isinstance(does[name], bool) for name in EDITS):
            raise ParameterError("give crop (x, y, width, height), straighten, flatten and propose (true or false).")
        asked = from_json("grow", given)
        does |= {"crop": asked.crop, "flatten": asked.flatten}
        if not any(does.values()):
            raise ParameterError("nothing is asked for; give crop, straighten, flatten or propose.")

        with self.uploads.folder("exemplars") as folder:
            given = {"paths": self.uploads.paths_of(row), "stem": row["name"], "folder": str(folder), **does}
            answer, _ = await self.beside.ask("edit", within=WITHIN, **given)
            return await self.uploads.kept(folder, answer["names"], {"name": answer["stem"]})

    # results

    async def result(self, row: Row, kind: str, sight: Row) -> bytes:
        """Return a plane of a result, or a part of it, or a view of its map."""
        place = self.store.place("results", row["id"])
        planes = {e["holds"]: e["name"] for e in row["files"] if e["name"] in row["pictures"]}
        if kind in planes:
            paths = [str(place / name) for name in row["pictures"]]
            return await self.seen(paths, kind, sight)
        if "box" in sight or kind not in VIEWS or not (place / MAP).is_file():
            raise InputError(f"this result has no view {said(kind)}.")
        given: Row = {"map": str(place / MAP), "kind": kind, **sight}
        if kind == "seams":
            given |= self._judged(row)
        return await self._drawn(self.beside, "view", **given)

    def _judged(self, row: Row) -> Row:
        """Return what the process that draws scores a result with; InputError if it cannot be judged."""
        if row["score_words"] is None:
            raise InputError("this result cannot be judged.")
        place = self.store.place("results", row["id"])
        words = [w.replace("../../exemplars/", f"{self.store.folder / 'exemplars'}/") for w in row["score_words"]]
        return {"map": str(place / MAP), "words": words, "picture": str(place / row["pictures"][0])}

    async def places(self, row: Row) -> Row:
        """Return where a result loses its score, by part: squares, each as x, y and side."""
        found: Row = json.loads(await self._drawn(self.beside, "places", **self._judged(row)))
        return found

    async def origins(self, row: Row, box: list[int]) -> tuple[int, int, bytes]:
        """Return width and height of a map, and where each pixel of a box comes from."""
        path = self.store.place("results", row["id"]) / MAP
        if not path.is_file():
            raise InputError("this result has no map.")
        told, data = await self.uploads.looker.ask("origins", within=WITHIN, map=str(path), box=box)
        return told["width"], told["height"], data

    async def report(self, row: Row) -> bytes:
        """Return the page that `score --report` writes for a result."""
        self._judged(row)

        async def draw() -> bytes:
            place = self.store.place("results", row["id"])
            with self.store.under_way("results") as folder:
                words = [*row["score_words"], f"--report=../{folder.name}/{REPORT}"]
                await self.beside.ask("command", within=WITHIN, words=words, folder=str(place))
                return (folder / REPORT).read_bytes()

        return await self.pictures.get(("report", row["id"]), draw)

    async def for_engine(self, kind: str, row: Row, engine: str) -> Path:
        """Write an archive of an exemplar or a result as `intarsia export` names and packs it; the caller removes it.

        ``told.txt`` says what was turned and packed.
        """
        place, folder = self.store.place("results", row["id"]), self.store.begun("results")
        paths = self.uploads.paths_of(row) if kind == "exemplar" else [str(place / name) for name in row["pictures"]]
        try:
            words = ["export", *paths, f"--for={engine}", "--output=made", "--json"]
            answer, _ = await self.beside.ask("command", within=WITHIN, words=words, folder=str(folder))
            (folder / "made" / "told.txt").write_text("\n".join([*answer["told"], ""]), encoding="utf-8")
            return Path(await asyncio.to_thread(shutil.make_archive, str(folder / "all"), "zip", folder / "made"))
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise

    def _steps(self, row: Row) -> list[Row]:
        """Return the results of which each was made of the one before it, to the one given."""
        steps = [row]
        while len(steps) < LONGEST_WAY and (before := origin_of(self.store, steps[0]["exemplars"])) is not None:
            steps.insert(0, before)
        return steps

    async def archive(self, row: Row) -> Path:
        """Write the command, its inputs and all files of a result into an archive; the caller removes it.

        The command writes beside its inputs, so the files that were made are in a folder of their own. Each step that
        led to the exemplar has a folder with its command and inputs, and ``steps.txt`` runs them one after another.
        """
        folder, place, steps = self.store.begun("results"), self.store.place("results", row["id"]), self._steps(row)
        homes = [f"{n}-{step['verb']}/" for n, step in enumerate(steps[:-1], 1)] + [""]

        def pack() -> Path:
            path, script = folder / "all.zip", list[str]()
            with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
                for entry in row["files"]:
                    archive.write(place / entry["name"], f"made/{entry['name']}")
                for n, (home, step) in enumerate(zip(homes, steps, strict=True)):
                    own = self.store.place("results", step["id"])
                    for name, found in step.get("inputs", {}).items():
                        if (own / found).is_file():  # its exemplar may be gone
                            archive.write(own / found, home + name)
                    archive.writestr(f"{home}command.txt", step["command"] + "\n")
                    script.append("sh command.txt")
                    if home:
                        after = self.store.row("exemplars", steps[n + 1]["exemplars"][0])
                        files = zip(step["pictures"], after["files"], strict=True)
                        copied = [f"cp -- {quote(made)} {quote(f'../{homes[n + 1]}{name}')}" for made, name in files]
                        script[-1] = f"({' && '.join([f'cd {home}', script[-1], *copied])}) &&"
                if len(steps) > 1:
                    archive.writestr("steps.txt", "\n".join(script) + "\n")
            return path

        try:
            return await asyncio.to_thread(pack)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise


class Drafts:
    """Draws at once what jobs will make, coarsely, one after another in a process of its own; finer ones beside."""

    def __init__(self, store: Store, pictures: Pictures, beside: Process) -> None:
        self.store, self.pictures, self.process, self.beside = store, pictures, Process(), beside

    async def begin(self) -> None:
        """Start the process, with all that a draft needs."""
        with suppress(FailedError):
            await self.process.ask("draft", words=["grow", "sample:stones", "--size=64"], folder=str(self.store.folder))

    async def get(self, job: Row, gone: Gone | None = None, fine: bool = False) -> bytes:
        """Return a draft of a job as PNG, a finer one if there is time; empty if there is none, or nobody waits."""
        words = words_of(job, self.store).said
        if job["verb"] not in DRAFTED:
            return b""

        async def draw() -> bytes:
            home = str(self.store.folder / "exemplars" / job["exemplars"][0])
            process = self.beside if fine else self.process
            _, data = await process.ask("draft", within=WITHIN, gone=gone, words=words, folder=home, fine=fine)
            return data

        with suppress(FailedError):
            return await self.pictures.get(("draft", fine, *words), draw)
        return b""


class Sketches:
    """Grows small previews of methods in a process of its own, which yields to jobs and ends when idle."""

    def __init__(self, uploads: Uploads, pictures: Pictures, busy: Callable[[], bool]) -> None:
        self.uploads, self.pictures, self.busy = uploads, pictures, busy
        self.process = Process(nice=19)
        self._asked = 0
        self._rest: asyncio.TimerHandle | None = None

    async def get(self, row: Row, method: str, gone: Gone) -> bytes:
        """Return the sketch of a method as PNG, empty if it cannot serve this exemplar.

        FailedError if the client has gone.
        """
        if method not in (AUTO_METHOD, *METHODS):
            raise InputError(f"{said(method)} is no method; give one of {', '.join((AUTO_METHOD, *METHODS))}.")
        return await self.pictures.get(("sketch", row["id"], method), lambda: self._grown(row, method, gone))

    async def end(self) -> None:
        """Stop at once."""
        if self._rest is not None:
            self._rest.cancel()
        await self.process.end()

    async def _grown(self, row: Row, method: str, gone: Gone) -> bytes | None:
        """Return a sketch, or None if it gave way to a job."""
        watch: list[asyncio.Task[None]] = []

        async def in_vain() -> bool:
            """Wait while there is other work; return whether the client has gone."""
            while self.busy() and not await gone():
                await asyncio.sleep(AGAIN)
            watch.append(asyncio.create_task(self._give_way()))
            return await gone()

        self._asked += 1
        try:
            paths = self.uploads.paths_of(row)
            _, data = await self.process.ask("sketch", within=WITHIN, gone=in_vain, paths=paths, method=method)
            return data
        except FailedError:
            if any(task.done() for task in watch):
                return None
            raise
        finally:
            for task in watch:
                task.cancel()
            self._asked -= 1
            self._let_rest()

    async def _give_way(self) -> None:
        while not self.busy():
            await asyncio.sleep(AGAIN)
        self.process.cancel()

    def _let_rest(self) -> None:
        if self._rest is not None:
            self._rest.cancel()
        self._rest = asyncio.get_running_loop().call_later(IDLE, self._end_idle)

    def _end_idle(self) -> None:
        if not self._asked:
            self._ending = asyncio.create_task(self.process.end())
