"""The HTTP routes of the studio, in one table, and their handlers."""

from __future__ import annotations

import json
import re
import shutil
from collections import OrderedDict
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from inspect import isawaitable
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.background import BackgroundTask
from starlette.convertors import IntegerConvertor, StringConvertor, register_url_convertor
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from ..foundation import AUTO_METHOD, SAMPLES, InputError, IntarsiaError, ParameterError
from ..request import to_argv, to_line
from . import uploads
from .jobs import Jobs
from .pictures import WITHIN, Drafts, Pictures, Showing, Sketches
from .processes import Gone, Process
from .requests import LIMITS, asked_of, schema, words_of
from .requests import options as options_of
from .security import Safety, error
from .store import Bin, Events, Row, Store, digest

STATIC = Path(__file__).parent / "static"
VERSION = f"{max(path.stat().st_mtime_ns for path in STATIC.rglob('*')):x}"  # in the paths of files, which are cached
LENGTH = re.compile("[0-9]{1,8}")
SIDE = 4096  # px: largest picture for a page
EVENTS = "text/event-stream"
KEPT = {"Cache-Control": "private, max-age=31536000, immutable"}
"""For what is named by its contents, and so never changes."""

ROWS = ("exemplar", "image", "job", "result")
"""Parts of paths that are ids."""

Answer = Callable[..., Any]
"""Handler of a request and the parts of its path: returns JSON, a PNG that is named by its contents, or a response."""


class Whole(IntegerConvertor):
    """An integer in a path."""

    regex = "-?[0-9]{1,15}"


class Taken(StringConvertor):
    """What can be removed, and restored."""

    regex = "exemplars|jobs"


register_url_convertor("whole", Whole())
register_url_convertor("taken", Taken())


class Studio:
    """All that the routes work on."""

    def __init__(self, folder: str | Path) -> None:
        self.store, self.events = Store(folder), Events()
        self.looker = Process(uploads.MOST_BYTES)
        beside = Process(nice=10)  # synthesis has priority
        self.bin = Bin(self.store, self.events)
        self.uploads = uploads.Uploads(self.store, self.looker)
        self.showing = Showing(self.store, self.uploads, beside)
        self.drafts = Drafts(self.store, self.showing.pictures, beside)
        self.jobs = Jobs(self.store, self.events, beside, self.drafts)
        self.weaves = Weaves(self.store, self.showing.pictures)
        self.sketches = Sketches(self.uploads, self.showing.pictures, lambda: self.jobs.busy)

    @asynccontextmanager
    async def living(self, app: Starlette) -> AsyncIterator[None]:
        """Run the queue as long as the server runs; end all processes and empty the bin afterwards."""
        self.bin.empty()
        self.jobs.begin()
        try:
            yield
        finally:
            self.events.close()
            await self.jobs.end()
            await self.looker.end()
            await self.weaves.weaver.end()
            await self.sketches.end()
            self.bin.empty()
            self.store.close()

    # exemplars

    async def sample(self, request: Request, name: str) -> bytes:
        if name not in SAMPLES:
            raise HTTPException(404, "there is no such sample.")
        return await self.showing.seen([f"sample:{name}"], "albedo", sight_of(request))

    async def bring(self, request: Request) -> Row:
        if request.headers.get("content-type", "").startswith("multipart/form-data"):
            async with request.form(max_files=LIMITS["files"], max_fields=8) as form:
                parts = [(f.filename or "", await f.read()) for f in form.getlist("files") if not isinstance(f, str)]
            if not parts:
                raise ParameterError("no file came; drop a picture.")
            return await self._brought(parts)
        given = await said(request)
        if set(given) == {"sample"}:
            return self._opened(await self.uploads.sample(given["sample"]))
        if set(given) == {"result"}:
            return self._opened(await self.uploads.result(given["result"]))
        raise ParameterError("send files, or the name of a sample, or the id of a result.")

    async def _brought(self, parts: list[uploads.Part]) -> Row:
        """Open files, one exemplar or several; return the first one, how many there are, and which were refused."""
        rows, refused = list[Row](), list[str]()
        for files in reversed(await self.uploads.sets(parts)):  # so that the first one is the newest
            try:
                rows.append(self._opened(await self.uploads.exemplar(files)))
            except IntarsiaError as e:
                refused.append(str(e))
        if not rows:
            raise InputError(" ".join(refused))
        return rows[-1] | {"opened": len(rows), "refused": refused}

    async def rename(self, request: Request, kind: str, name: str) -> Row:
        row, own = self.store.row(kind, name), (await said(request)).get("name")
        if not isinstance(own, str) or not own.isprintable() or len(own.strip()) not in range(kind != "jobs", 81):
            raise ParameterError("name: give 1 to 80 characters that can be printed.")
        row = self.jobs.now(self.store.put(kind, row | {"name": own.strip()}))
        self.events.tell(kind[:-1], row)
        return row

    def _opened(self, row: Row) -> Row:
        self.events.tell("exemplar", row)
        self.jobs.prepare(row["id"])
        return row

    async def edit(self, request: Request, exemplar: Row) -> Row:
        return self._opened(await self.showing.edited(exemplar, await said(request)))

    async def found(self, request: Request, exemplar: Row) -> Row:
        self.jobs.prepare(exemplar["id"])
        return await self.showing.found(exemplar)

    async def rim(self, request: Request, exemplar: Row, image: Row) -> Response:
        grow, data = await self.showing.rim(exemplar, image)
        return Response(data, headers=KEPT | {"X-Grow": str(grow)}, media_type="image/png")

    async def put_image(self, request: Request) -> Row:
        return await self.uploads.image(await request.body())

    # jobs, and what they made

    async def keep(self, request: Request, key: str) -> None:
        if key != "page" and self.store.get("exemplars", key) is None:
            raise HTTPException(404, "there is no such exemplar; give its id, or page.")
        self.store.put("kept", {"id": key, "value": await said(request)})

    async def draft(self, request: Request) -> bytes:
        asked, fine = asked_of(await said(request)), "fine" in request.query_params
        return await self.drafts.get(asked, request.is_disconnected, fine)

    async def put_job(self, request: Request) -> Row:
        return self.jobs.add(await said(request))

    def preview(self, request: Request, job: Row) -> Response:
        number, data = self.jobs.previews.get(job["id"], (0, b""))
        return Response(data, media_type="image/png") if number else Response(status_code=204)  # it may just have ended

    def file(self, request: Request, result: Row, file: str) -> Response:
        if file not in [entry["name"] for entry in result["files"]]:
            raise HTTPException(404, "there is no such file.")
        return FileResponse(
            self.store.place("results", result["id"]) / file, filename=self.called(result, file), headers=KEPT
        )

    async def origins(self, request: Request, result: Row) -> Response:
        width, height, data = await self.showing.origins(result, box_of(request) or [0, 0, SIDE, SIDE])
        headers = KEPT | {"X-Size": f"{width}x{height}"}
        return Response(data, media_type="application/octet-stream", headers=headers)

    async def archive(self, request: Request, result: Row) -> Response:
        path = await self.showing.archive(result)
        stem = Path(result["pictures"][0]).stem if result["pictures"] else "result"
        return _once(path, self.called(result, f"{stem}.zip"))

    async def engine(self, request: Request, engine: str, **row: Row) -> Response:
        ((kind, of),) = row.items()
        path = await self.showing.for_engine(kind, of, engine)
        own = of["name"] if kind == "exemplar" else Path(self.called(of, of["pictures"][0])).stem
        return _once(path, f"{own}_{engine}.zip")

    def called(self, result: Row, name: str) -> str:
        """Return the name under which a file of a result is downloaded: the given one, or with what they differ by."""
        given = (job.get("name") for job in self.store.all("jobs") if job["result"] == result["id"])
        if own := next(filter(None, given), ""):
            return re.sub(r"\W+", "_", own) + name.removeprefix(Path((result["pictures"] or [name])[0]).stem)
        method, seed, feather = map(result["options"].get, ("method", "seed", "feather"))
        more = [method, seed and f"s{seed}", feather and f"f{feather}"]
        return "_".join([Path(name).stem, *(each for each in more if each and each != AUTO_METHOD)]) + Path(name).suffix

    async def report(self, request: Request, result: Row) -> Response:
        page, own = await self.showing.report(result), f"{Path(result['pictures'][0]).stem}_report.html"
        headers = KEPT | {"Content-Disposition": f'attachment; filename="{own}"'}
        return Response(page, media_type="text/html", headers=headers)

    async def put_weave(self, request: Request) -> Row:
        return await self.weaves.begin(await said(request))

    async def window(self, request: Request, name: str) -> Row:
        return self.weaves.window(name, await said(request))

    @property
    def table(self) -> list[tuple[str, str, int, Answer]]:
        """Method, path, status and handler; handlers get the request and the parts of the path, ids as rows."""
        store, jobs, bin, showing = self.store, self.jobs, self.bin, self.showing
        page = (STATIC / "index.html").read_text(encoding="utf-8").replace("/static/", f"/static/{VERSION}/")
        return [
            ("GET", "/", 200, lambda _: HTMLResponse(page)),
            ("GET", "/api/schema", 200, lambda _: schema()),
            ("GET", "/api/samples/{name}.png", 200, self.sample),
            ("POST", "/api/exemplars", 201, self.bring),
            ("GET", "/api/{kind:taken}", 200, lambda _, kind: [jobs.now(row) for row in store.all(kind)]),
            ("GET", "/api/{kind:taken}/{name}", 200, lambda _, kind, name: jobs.now(store.row(kind, name))),
            ("DELETE", "/api/{kind:taken}/{name}", 204, lambda _, kind, name: bin.take(kind, name)),
            ("POST", "/api/{kind:taken}/{name}/name", 200, self.rename),
            ("GET", "/api/disk", 200, lambda _: {"folder": str(store.folder), "bytes": store.weight()}),
            ("POST", "/api/{kind:taken}/{name}/back", 200, lambda _, kind, name: bin.back(kind, name)),
            ("GET", "/api/exemplars/{exemplar}/{plane}.png", 200,
             lambda request, exemplar, plane: showing.exemplar(exemplar, plane, sight_of(request))),
            ("POST", "/api/exemplars/{exemplar}/edit", 201, self.edit),
            ("GET", "/api/exemplars/{exemplar}/found", 200, self.found),
            ("GET", "/api/exemplars/{exemplar}/found/{kind}.png", 200,
             lambda _, exemplar, kind: showing.overlay(exemplar, kind)),
            ("GET", "/api/exemplars/{exemplar}/labels/{count:whole}.png", 200,
             lambda _, exemplar, count: showing.labels(exemplar, count)),
            ("GET", "/api/exemplars/{exemplar}/rim/{image}.png", 200, self.rim),
            ("GET", "/api/exemplars/{exemplar}/methods/{method}.png", 200,
             lambda request, exemplar, method: self.sketches.get(exemplar, method, request.is_disconnected)),
            ("POST", "/api/images", 201, self.put_image),
            ("GET", "/api/images/{image}.png", 200,
             lambda _, image: FileResponse(store.place("images", image["id"]), headers=KEPT)),
            ("GET", "/api/kept", 200, lambda _: {row["id"]: row["value"] for row in store.all("kept")}),
            ("POST", "/api/kept/{key}", 204, self.keep),
            ("POST", "/api/drafts", 200, self.draft),
            ("POST", "/api/jobs", 202, self.put_job),
            ("POST", "/api/jobs/{job}/cancel", 200, lambda _, job: jobs.cancel(job)),
            ("POST", "/api/jobs/{job}/again", 202, lambda _, job: jobs.again(job)),
            ("GET", "/api/jobs/{job}/preview.png", 200, self.preview),
            ("GET", "/api/events", 200, lambda _: StreamingResponse(self.events.heard(jobs.open), media_type=EVENTS)),
            ("GET", "/api/results/{result}", 200, lambda _, result: result),
            ("GET", "/api/results/{result}/files/{file}", 200, self.file),
            ("GET", "/api/results/{result}/all.zip", 200, self.archive),
            ("GET", "/api/results/{result}/for/{engine}.zip", 200, self.engine),
            ("GET", "/api/exemplars/{exemplar}/for/{engine}.zip", 200, self.engine),
            ("GET", "/api/results/{result}/report.html", 200, self.report),
            ("GET", "/api/results/{result}/places", 200, lambda _, result: showing.places(result)),
            ("GET", "/api/results/{result}/view/{kind}.png", 200,
             lambda request, result, kind: showing.result(result, kind, sight_of(request))),
            ("GET", "/api/results/{result}/map.bin", 200, self.origins),
            ("POST", "/api/weaves", 201, self.put_weave),
            ("POST", "/api/weaves/{name}/window", 200, self.window),
            ("GET", "/api/weaves/{name}/{level:whole}/{y:whole}/{x:whole}.png", 200,
             lambda request, name, level, y, x: self.weaves.tile(name, [level, y, x], request.is_disconnected)),
        ]  # fmt: skip

    def answered(self, answer: Answer, status: int) -> Callable[[Request], Awaitable[Response]]:
        """Return a handler that writes what `answer` returns; an empty picture becomes status 204."""

        async def handler(request: Request) -> Response:
            parts = request.path_params
            rows = {kind: self.store.row(f"{kind}s", name) for kind, name in parts.items() if kind in ROWS}
            found = answer(request, **parts | rows)
            if isawaitable(found):
                found = await found
            if isinstance(found, bytes):
                return Response(found, status if found else 204, KEPT, "image/png")
            if found is None:
                return Response(status_code=status)
            return found if isinstance(found, Response) else JSONResponse(found, status)

        return handler


def _once(path: Path, name: str) -> Response:
    """Return a file to download, whose folder is removed afterwards."""
    return FileResponse(path, filename=name, background=BackgroundTask(shutil.rmtree, path.parent, True))


async def said(request: Request) -> Row:
    """Return the JSON object of a request; ParameterError if it is none."""
    try:
        given = json.loads(await request.body())
    except (ValueError, RecursionError):
        given = None
    if not isinstance(given, dict):
        raise ParameterError("send a JSON object.")
    return given


def box_of(request: Request) -> list[int] | None:
    """Return the box x, y, width, height that a request asks for; None: all of the picture."""
    text = request.query_params.get("box")
    if text is None:
        return None
    found = [int(word) if LENGTH.fullmatch(word) else -1 for word in text.split(",")]
    if len(found) != 4 or min(found) < 0 or not 1 <= min(found[2:]) <= max(found[2:]) <= SIDE:
        raise ParameterError(f"box: give x,y,width,height in px, at most {SIDE} px a side.")
    return found


def sight_of(request: Request) -> Row:
    """Return what of a picture to send: all of it, at most `side` px, or a box at full size."""
    box, side = box_of(request), request.query_params.get("side", "1024")
    if not (LENGTH.fullmatch(side) and 1 <= int(side) <= SIDE):
        raise ParameterError(f"side: give 1 to {SIDE} px.")
    return {"side": int(side)} if box is None else {"box": box}


async def refused(request: Request, e: Exception) -> Response:
    """Return one line for every error, without internals."""
    if isinstance(e, HTTPException):
        return error(e.status_code, str(e.detail))
    if not isinstance(e, IntarsiaError):
        return error(500, f"internal error, {type(e).__name__}; please report it.")
    return error(400 if e.exit_code in (2, 3, 4) else 500, str(e))


HANDLERS: dict[Any, Any] = dict.fromkeys((IntarsiaError, HTTPException, Exception), refused)


class Page(StaticFiles):
    """The files of the page, which browsers cache under the path of their version."""

    def file_response(self, *args: Any, **kwargs: Any) -> Response:
        response = super().file_response(*args, **kwargs)
        response.headers.update(KEPT)
        return response


def app_of(studio: Studio, token: str | None = None) -> Safety:
    """Return the application, with the safety layer around it."""
    routes: list[Any] = [
        Route(path, studio.answered(does, status), methods=[way]) for way, path, status, does in studio.table
    ]
    routes.append(Mount(f"/static/{VERSION}", Page(directory=STATIC)))
    return Safety(Starlette(routes=routes, exception_handlers=HANDLERS, lifespan=studio.living), token)


FARTHEST = 1 << 40  # px from the origin
WEAVES = 200
TILE, LEVELS = 256, 4  # px of a tile; levels from full size to 1/8
GROWN = ("method", "seed")  # besides the method's parameters


class Weaves:
    """The endless canvases of pages, and the process that draws their tiles."""

    def __init__(self, store: Store, pictures: Pictures) -> None:
        self.store, self.pictures, self.weaver = store, pictures, Process()
        self._known: OrderedDict[str, tuple[Row, Row]] = OrderedDict()  # the job, and what its tiles are drawn with

    async def begin(self, given: Row) -> Row:
        """Start an endless canvas; its options are those of a job, except size and origin."""
        options, known = given.get("options", {}), options_of("weave")
        if set(given) - {"exemplar", "options"} or not isinstance(options, dict):
            raise ParameterError("give exemplar (an id) and options (an object).")
        if any(name in known and not known[name]["parameter"] for name in options.keys() - GROWN):
            raise ParameterError("options are the method, the seed, and the method's parameters.")
        name, options = given.get("exemplar"), {"method": AUTO_METHOD, **options}
        job: Row = {"verb": "weave", "exemplars": [name], "options": options | {"size": "1x1"}}
        request = words_of(job, self.store).request
        job["options"] = options | {"seed": request.seed or 0}
        drawn: Row = {"words": to_argv(replace(request, seed=None), joined=True), "seed": request.seed or 0}
        drawn["folder"] = str(self.store.folder / "exemplars" / str(name))
        await self.weaver.ask("begin", within=WITHIN, **drawn)
        while len(self._known) >= WEAVES:
            self._known.popitem(last=False)
        own = digest((), json.dumps(job))
        self._known[own] = job, drawn
        return {"id": own}

    def _get(self, name: str) -> tuple[Row, Row]:
        """Return the job of an id and what its tiles are drawn with; HTTPException 404 if it is unknown."""
        if name not in self._known:
            raise HTTPException(404, "there is no such endless canvas; begin one with POST /api/weaves.")
        self._known.move_to_end(name)
        return self._known[name]

    async def tile(self, name: str, place: list[int], gone: Gone) -> bytes:
        """Return a tile (level, row, column) as PNG, unless its client has gone."""
        level, y, x = place
        _, drawn = self._get(name)
        if not 0 <= level < LEVELS or (max(abs(y), abs(x)) + 1) * (TILE << level) > FARTHEST:
            raise InputError(f"there is no such tile; levels are 0 to {LEVELS - 1}, and 2**40 px is as far as it goes.")

        async def draw() -> bytes | None:
            _, data = await self.weaver.ask("tile", within=WITHIN, gone=gone, place=place, **drawn)
            return data or None

        return await self.pictures.get(("tile", name, *place), draw)

    def window(self, name: str, given: Row) -> Row:
        """Return the job for a part of a canvas, of a size from an origin on, and its command."""
        job, _ = self._get(name)
        if set(given) != {"size", "origin"}:
            raise ParameterError("give size (WIDTHxHEIGHT) and origin (X,Y) in px, and nothing else.")
        job = job | {"options": job["options"] | given}
        words = words_of(job, self.store)
        told = words.asked(words.request.out or "")
        return {"job": job, "command": to_line(told, joined=True), "needs": list(words.called.values())}
