"""The routes of the studio, in one table, and what each answers."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.background import BackgroundTask
from starlette.convertors import IntegerConvertor, register_url_convertor
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from ..arguments import SAMPLES
from ..errors import IntarsiaError, ParameterError
from . import jobs, uploads
from .jobs import Jobs
from .processes import Process, Wanted
from .safety import Safety, error
from .showing import FOUND, LABELS, Showing, Sketches
from .store import Bin, Events, Store
from .weaves import Weaves
from .words import LIMITS, result_told, schema

STATIC = Path(__file__).parent / "static"
LENGTH = re.compile("[0-9]{1,8}")
SIDE = 4096  # px: no picture for a page is larger
KEPT = {"Cache-Control": "private, max-age=31536000, immutable"}
"""What is named by its contents does not change."""

Handler = Callable[[Request], Awaitable[Response]]


class Whole(IntegerConvertor):
    """A whole number in a path."""

    regex = "-?[0-9]{1,15}"


register_url_convertor("whole", Whole())


class Studio:
    """Everything that the routes work on."""

    def __init__(self, folder: str | Path) -> None:
        self.store, self.events = Store(folder), Events()
        self.looker = Process(uploads.MOST_BYTES)
        beside = Process(nice=10)  # growing goes first
        self.bin = Bin(self.store, self.events)
        self.jobs = Jobs(self.store, self.events, Process(), Process(nice=10), beside)
        self.uploads = uploads.Uploads(self.store, self.looker)
        self.showing = Showing(self.store, self.uploads, beside)
        self.weaves = Weaves(self.store, self.showing.pictures)
        self.sketches = Sketches(self.uploads, self.showing.pictures, lambda: self.jobs.busy)

    @asynccontextmanager
    async def living(self, app: Starlette) -> AsyncIterator[None]:
        """Work as long as the server runs; nothing is left afterwards."""
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

    def row(self, request: Request, kind: str, word: str = "id") -> dict[str, Any]:
        """The row that a request names."""
        row = self.store.get(kind, request.path_params[word])
        if row is None:
            raise HTTPException(404, f"there is no such {kind[:-1]}.")
        return row

    # routes

    async def page(self, request: Request) -> Response:
        return FileResponse(STATIC / "index.html", media_type="text/html")

    async def schema(self, request: Request) -> Response:
        return JSONResponse(schema())

    async def sample_view(self, request: Request) -> Response:
        name = request.path_params["name"]
        if name not in SAMPLES:
            raise HTTPException(404, "there is no such sample.")
        return picture(await self.showing.sample(name, side_of(request)))

    async def put_exemplar(self, request: Request) -> Response:
        if request.headers.get("content-type", "").startswith("multipart/form-data"):
            form = await request.form(max_files=LIMITS["files"], max_fields=8)
            parts = [(f.filename or "", await f.read()) for f in form.getlist("files") if not isinstance(f, str)]
            await form.close()
            if not parts:
                raise ParameterError("no file came; send them as the field files.")
            return self._opened(await self.uploads.exemplar(parts))
        given = await said(request)
        if set(given) == {"sample"}:
            return self._opened(await self.uploads.sample(given["sample"]))
        if set(given) == {"result"}:
            return self._opened(await self.uploads.result(given["result"]))
        raise ParameterError("send files, or the name of a sample, or the id of a result.")

    def _opened(self, row: dict[str, Any]) -> Response:
        self.events.tell("exemplar", row)
        self.jobs.prepare(row["id"])
        return JSONResponse(row, 201)

    async def exemplars(self, request: Request) -> Response:
        return JSONResponse([uploads.told(row) for row in self.store.all("exemplars")])

    async def exemplar(self, request: Request) -> Response:
        return JSONResponse(uploads.told(self.row(request, "exemplars")))

    async def drop_exemplar(self, request: Request) -> Response:
        self.bin.take("exemplars", self.row(request, "exemplars"))
        return Response(status_code=204)

    async def exemplar_back(self, request: Request) -> Response:
        row = uploads.told(self.bin.back("exemplars", request.path_params["id"]))
        self.events.tell("exemplar", row)
        return JSONResponse(row)

    async def exemplar_view(self, request: Request) -> Response:
        row = self.row(request, "exemplars")
        return picture(await self.showing.exemplar(row, request.path_params["plane"], sight_of(request)))

    async def edit(self, request: Request) -> Response:
        row = self.row(request, "exemplars")
        return self._opened(await self.showing.edited(row, await said(request)))

    async def found(self, request: Request) -> Response:
        row = self.row(request, "exemplars")
        self.jobs.prepare(row["id"])
        return JSONResponse(await self.showing.found(row))

    async def overlay(self, request: Request) -> Response:
        kind = request.path_params["kind"]
        if kind not in (*FOUND, LABELS):
            raise HTTPException(404, f"there is no such overlay; give {', '.join(FOUND)}.")
        return picture(await self.showing.overlay(self.row(request, "exemplars"), kind))

    async def rim(self, request: Request) -> Response:
        row, image = self.row(request, "exemplars"), self.row(request, "images", "image")
        grow, data = await self.showing.rim(row, image)
        return picture(data, KEPT | {"X-Grow": str(grow)})

    async def sketch(self, request: Request) -> Response:
        row, method = self.row(request, "exemplars"), request.path_params["method"]

        data = await self.sketches.get(row, method, wanted_by(request))
        return picture(data) if data else Response(status_code=204, headers=KEPT)

    async def put_image(self, request: Request) -> Response:
        return JSONResponse(await self.uploads.image(await request.body()), 201)

    async def image(self, request: Request) -> Response:
        row = self.row(request, "images", "image")
        return FileResponse(self.store.image(row["id"]), media_type="image/png", headers=KEPT)

    async def kept(self, request: Request) -> Response:
        return JSONResponse({row["id"]: row["value"] for row in self.store.all("kept")})

    async def keep(self, request: Request) -> Response:
        key = request.path_params["key"]
        if key != "page" and self.store.get("exemplars", key) is None:
            raise HTTPException(404, "there is no such exemplar; give its id, or page.")
        self.store.put("kept", {"id": key, "value": await said(request)})
        return Response(status_code=204)

    async def put_job(self, request: Request) -> Response:
        return JSONResponse(self.jobs.add(await said(request)), 202)

    async def all_jobs(self, request: Request) -> Response:
        return JSONResponse([self.jobs.get(row["id"]) for row in self.store.all("jobs")])

    async def job(self, request: Request) -> Response:
        return JSONResponse(self.jobs.get(request.path_params["id"]))

    async def cancel(self, request: Request) -> Response:
        return JSONResponse(self.jobs.cancel(request.path_params["id"]))

    async def again(self, request: Request) -> Response:
        return JSONResponse(self.jobs.again(request.path_params["id"]), 202)

    async def drop_job(self, request: Request) -> Response:
        self.bin.take("jobs", self.row(request, "jobs"))
        return Response(status_code=204)

    async def job_back(self, request: Request) -> Response:
        row = jobs.told(self.bin.back("jobs", request.path_params["id"]))
        self.events.tell("job", row)
        return JSONResponse(row)

    async def preview(self, request: Request) -> Response:
        job = self.jobs.get(request.path_params["id"])
        number, data = self.jobs.previews.get(job["id"], (0, b""))
        return Response(data, media_type="image/png") if number else Response(status_code=204)  # it may just have ended

    async def listen(self, request: Request) -> Response:
        return StreamingResponse(self.events.heard(self.jobs.now), media_type="text/event-stream")

    async def result(self, request: Request) -> Response:
        return JSONResponse(result_told(self.row(request, "results")))

    async def result_file(self, request: Request) -> Response:
        row, name = self.row(request, "results"), request.path_params["name"]
        if name not in [entry["name"] for entry in row["files"]]:
            raise HTTPException(404, "there is no such file.")
        path = self.store.folder / "results" / row["id"] / name
        return FileResponse(path, filename=name, headers=KEPT)

    async def view(self, request: Request) -> Response:
        row = self.row(request, "results")
        return picture(await self.showing.result(row, request.path_params["kind"], sight_of(request)))

    async def origins(self, request: Request) -> Response:
        width, height, data = await self.showing.origins(self.row(request, "results"), box_of(request))
        headers = KEPT | {"X-Size": f"{width}x{height}"}
        return Response(data, media_type="application/octet-stream", headers=headers)

    async def archive(self, request: Request) -> Response:
        row = self.row(request, "results")
        path = await self.showing.archive(row)
        name = f"{Path(row['pictures'][0]).stem if row['pictures'] else 'result'}.zip"
        return FileResponse(path, filename=name, background=BackgroundTask(shutil.rmtree, path.parent, True))

    async def report(self, request: Request) -> Response:
        row = self.row(request, "results")
        page, name = await self.showing.report(row), f"{Path(row['pictures'][0]).stem}_report.html"
        headers = KEPT | {"Content-Disposition": f'attachment; filename="{name}"'}
        return Response(page, media_type="text/html", headers=headers)

    async def put_weave(self, request: Request) -> Response:
        return JSONResponse(await self.weaves.begin(await said(request)), 201)

    async def window(self, request: Request) -> Response:
        return JSONResponse(self.weaves.window(request.path_params["id"], await said(request)))

    async def tile(self, request: Request) -> Response:
        name, place = request.path_params["id"], [request.path_params[part] for part in ("level", "y", "x")]
        return picture(await self.weaves.tile(name, place, wanted_by(request)))

    @property
    def table(self) -> list[tuple[str, str, Handler]]:
        """Method, path, handler."""
        return [
            ("GET", "/", self.page),
            ("GET", "/api/schema", self.schema),
            ("GET", "/api/samples/{name}.png", self.sample_view),
            ("POST", "/api/exemplars", self.put_exemplar),
            ("GET", "/api/exemplars", self.exemplars),
            ("GET", "/api/exemplars/{id}", self.exemplar),
            ("DELETE", "/api/exemplars/{id}", self.drop_exemplar),
            ("POST", "/api/exemplars/{id}/back", self.exemplar_back),
            ("GET", "/api/exemplars/{id}/{plane}.png", self.exemplar_view),
            ("POST", "/api/exemplars/{id}/edit", self.edit),
            ("GET", "/api/exemplars/{id}/found", self.found),
            ("GET", "/api/exemplars/{id}/found/{kind}.png", self.overlay),
            ("GET", "/api/exemplars/{id}/rim/{image}.png", self.rim),
            ("GET", "/api/exemplars/{id}/methods/{method}.png", self.sketch),
            ("POST", "/api/images", self.put_image),
            ("GET", "/api/images/{image}.png", self.image),
            ("GET", "/api/kept", self.kept),
            ("POST", "/api/kept/{key}", self.keep),
            ("POST", "/api/jobs", self.put_job),
            ("GET", "/api/jobs", self.all_jobs),
            ("GET", "/api/jobs/{id}", self.job),
            ("DELETE", "/api/jobs/{id}", self.drop_job),
            ("POST", "/api/jobs/{id}/back", self.job_back),
            ("POST", "/api/jobs/{id}/cancel", self.cancel),
            ("POST", "/api/jobs/{id}/again", self.again),
            ("GET", "/api/jobs/{id}/preview.png", self.preview),
            ("GET", "/api/events", self.listen),
            ("GET", "/api/results/{id}", self.result),
            ("GET", "/api/results/{id}/files/{name}", self.result_file),
            ("GET", "/api/results/{id}/all.zip", self.archive),
            ("GET", "/api/results/{id}/report.html", self.report),
            ("GET", "/api/results/{id}/view/{kind}.png", self.view),
            ("GET", "/api/results/{id}/map.bin", self.origins),
            ("POST", "/api/weaves", self.put_weave),
            ("POST", "/api/weaves/{id}/window", self.window),
            ("GET", "/api/weaves/{id}/{level:whole}/{y:whole}/{x:whole}.png", self.tile),
        ]


def picture(data: bytes, headers: Mapping[str, str] = KEPT) -> Response:
    """A PNG that is named by its contents."""
    return Response(data, media_type="image/png", headers=headers)


def wanted_by(request: Request) -> Wanted:
    """Whether who asks still waits for the answer."""

    async def wanted() -> bool:
        return not await request.is_disconnected()

    return wanted


async def said(request: Request) -> dict[str, Any]:
    """The JSON object of a request."""
    try:
        given = json.loads(await request.body())
    except (ValueError, RecursionError):
        given = None
    if not isinstance(given, dict):
        raise ParameterError("send a JSON object.")
    return given


def side_of(request: Request) -> int:
    """How large a picture shall be at most."""
    text = request.query_params.get("side", "1024")
    if not (LENGTH.fullmatch(text) and 1 <= int(text) <= SIDE):
        raise ParameterError(f"side: give 1 to {SIDE} px.")
    return int(text)


def box_of(request: Request) -> list[int] | None:
    """Which part is asked for: x, y, width, height; None: all of it."""
    text = request.query_params.get("box")
    if text is None:
        return None
    found = [int(word) if LENGTH.fullmatch(word) else -1 for word in text.split(",")]
    if len(found) != 4 or min(found) < 0 or not 1 <= min(found[2:]) <= max(found[2:]) <= SIDE:
        raise ParameterError(f"box: give x,y,width,height in px, at most {SIDE} px a side.")
    return found


def sight_of(request: Request) -> dict[str, Any]:
    """What of a picture is seen: all of it, reduced, or a part of it, pixel for pixel."""
    box = box_of(request)
    return {"side": side_of(request)} if box is None else {"box": box}


async def refused(request: Request, e: Exception) -> Response:
    """One line for every error; what is not meant for a client is not told."""
    if isinstance(e, HTTPException):
        return error(e.status_code, str(e.detail))
    if not isinstance(e, IntarsiaError):
        return error(500, f"internal error, {type(e).__name__}; please report it.")
    return error(400 if e.exit_code in (2, 3, 4) else 500, str(e))


HANDLERS: dict[Any, Any] = dict.fromkeys((IntarsiaError, HTTPException, Exception), refused)


def app_of(studio: Studio, token: str | None = None) -> Safety:
    """Return the application, with the safety layer around it."""
    routes: list[Any] = [Route(path, handler, methods=[method]) for method, path, handler in studio.table]
    routes.append(Mount("/static", StaticFiles(directory=STATIC)))
    return Safety(Starlette(routes=routes, exception_handlers=HANDLERS, lifespan=studio.living), token)
