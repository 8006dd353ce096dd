"""The HTTP interface as OpenAPI: every route with a sentence, what is sent and what comes back."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from ..version import VERSION
from .jobs import JOB
from .results import PUBLIC
from .schema import VERBS, options, schema
from .showing import FOUND, VIEWS
from .uploads import EXEMPLAR
from .weaves import LARGEST, LEVELS, SIDE, STROKES, WIDEST

SAYS = {
    "GET /api/openapi.json": "This description.",
    "GET /api/schema": "Verbs with their options, methods with their parameters, built-in exemplars, limits.",
    "GET /api/samples/{name}.png": "What a built-in exemplar looks like.",
    "POST /api/exemplars": "Take the files of one exemplar, a built-in one, or a result.",
    "GET /api/exemplars": "All exemplars.",
    "GET /api/exemplars/{id}": "An exemplar.",
    "DELETE /api/exemplars/{id}": "Take an exemplar away; it goes for ever a minute later.",
    "POST /api/exemplars/{id}/back": "Bring an exemplar back that was taken away within a minute.",
    "GET /api/exemplars/{id}/{plane}.png": "What can be seen of a plane of an exemplar, in 8 bits.",
    "POST /api/exemplars/{id}/edit": "Cut, straighten or flatten an exemplar: a new one.",
    "GET /api/exemplars/{id}/found": "What was found in an exemplar, and how to grow it.",
    "GET /api/exemplars/{id}/found/{kind}.png": f"What was found, to lay over: {', '.join(FOUND)}; labels: numbers.",
    "GET /api/exemplars/{id}/rim/{image}.png": "What `heal --grow auto` adds to a hole; X-Grow: how many px.",
    "GET /api/exemplars/{id}/methods/{method}.png": "What a method makes of an exemplar, 192 px; 204 where it cannot.",
    "POST /api/images": "Keep a picture of numbers, a mask or labels: PNG, one channel, 8 bits.",
    "GET /api/images/{image}.png": "A picture of numbers.",
    "GET /api/kept": "What is kept for the page: by the id of an exemplar, and for all of them as page.",
    "POST /api/kept/{key}": "Keep something for the page: any JSON object, in place of what was kept.",
    "POST /api/jobs": "Queue a job: a command with its options.",
    "GET /api/jobs": "All jobs, in the order in which they came.",
    "GET /api/jobs/{id}": "A job.",
    "DELETE /api/jobs/{id}": "Take a job away that has ended, and what it made; both go for ever a minute later.",
    "POST /api/jobs/{id}/back": "Bring a job back that was taken away within a minute, and what it made.",
    "POST /api/jobs/{id}/cancel": "Stop a job.",
    "POST /api/jobs/{id}/again": "Queue the same job anew.",
    "GET /api/jobs/{id}/preview.png": "What a job that runs has grown so far.",
    "GET /api/events": "Server-sent events: warm, job, preview, exemplar, gone.",
    "GET /api/results/{id}": "A result: its files, what the command told, how it is made again.",
    "GET /api/results/{id}/files/{name}": "A file of a result.",
    "GET /api/results/{id}/all.zip": "All files of a result, the command, and the files that it needs.",
    "GET /api/results/{id}/report.html": "A page on how good a result is, as the command `score` writes it.",
    "GET /api/results/{id}/view/{kind}.png": f"What can be seen of a result: a plane, {', '.join(VIEWS)}.",
    "GET /api/results/{id}/map.bin": "Where every pixel comes from: uint16, little-endian: exemplar, row, column.",
    "POST /api/weaves": "Begin an endless canvas.",
    "POST /api/weaves/{id}/window": "The job that makes a part of an endless canvas, and its command.",
    "GET /api/weaves/{id}/{y}/{x}.png": "A tile of an endless canvas: 256 px that show 256 * 2**level px a side.",
}

ANY: dict[str, Any] = {}
WHOLE = ("weaves", "preview", "found", "methods", "rim", "images")
"""Pictures that are never reduced."""

SENT = {
    "POST /api/jobs": "JobWanted", "POST /api/exemplars/{id}/edit": "Edit", "POST /api/weaves": "WeaveWanted",
    "POST /api/weaves/{id}/window": "WindowWanted",
}  # fmt: skip
BACK = {
    "POST /api/exemplars": "Exemplar", "GET /api/exemplars/{id}": "Exemplar", "GET /api/exemplars": "Exemplar",
    "POST /api/exemplars/{id}/edit": "Exemplar", "POST /api/images": "Image", "POST /api/jobs": "Job",
    "GET /api/jobs": "Job", "GET /api/jobs/{id}": "Job", "POST /api/jobs/{id}/cancel": "Job",
    "POST /api/exemplars/{id}/back": "Exemplar", "POST /api/jobs/{id}/back": "Job",
    "POST /api/jobs/{id}/again": "Job", "GET /api/results/{id}": "Result", "POST /api/weaves": "Weave",
    "POST /api/weaves/{id}/window": "Window",
}  # fmt: skip
LISTS = ("GET /api/exemplars", "GET /api/jobs")
"""What is sent and what comes back, as JSON; some answers are lists of it."""


def openapi(routes: Iterable[tuple[str, str]]) -> dict[str, Any]:
    """Describe these routes: method and path of each."""
    paths: dict[str, Any] = {}
    for method, path in routes:
        if path.startswith("/api/"):
            paths.setdefault(path, {})[method.lower()] = _operation(method, path)
    bearer = {"token": {"type": "http", "scheme": "bearer"}}
    return {
        "openapi": "3.1.0",
        "info": {"title": "intarsia studio", "version": VERSION},
        "security": [{"token": []}],
        "paths": paths,
        "components": {"securitySchemes": bearer, "schemas": _schemas()},
    }


def _operation(method: str, path: str) -> dict[str, Any]:
    route = f"{method} {path}"
    names = re.findall(r"{(\w+)}", path)
    parameters = [{"name": n, "in": "path", "required": True, "schema": {"type": "string"}} for n in names]
    if path.endswith(".png") and not any(word in path for word in WHOLE):
        side = {"type": "integer", "minimum": 1, "maximum": 4096, "default": 1024}
        parameters.append({"name": "side", "in": "query", "required": False, "schema": side})
    if path.endswith(("{plane}.png", "{kind}.png", "map.bin")) and "found" not in path:
        parameters.append({"name": "box", "in": "query", "required": False, "schema": {"type": "string"}})
    if "weaves" in path and method == "GET":
        level = {"type": "integer", "minimum": 0, "maximum": LEVELS - 1, "default": 0}
        parameters.append({"name": "level", "in": "query", "required": False, "schema": level})
        parameters.append({"name": "If-None-Match", "in": "header", "required": False, "schema": {"type": "string"}})
    if method != "GET":
        parameters.append({"name": "X-Intarsia", "in": "header", "required": True, "schema": {"const": "1"}})
    told: dict[str, Any] = {"summary": SAYS[route], "parameters": parameters, "responses": _answers(route, path)}
    if route in SENT:
        told["requestBody"] = {"required": True, "content": {"application/json": {"schema": _named(SENT[route])}}}
    elif route == "POST /api/exemplars":
        many = {"type": "array", "items": {"type": "string", "contentMediaType": "application/octet-stream"}}
        form = {"type": "object", "properties": {"files": many}}
        either = [{"required": [word], "properties": {word: {"type": "string"}}} for word in ("sample", "result")]
        content = {"multipart/form-data": {"schema": form}, "application/json": {"schema": {"oneOf": either}}}
        told["requestBody"] = {"required": True, "content": content}
    elif route == "POST /api/kept/{key}":
        told["requestBody"] = {"required": True, "content": {"application/json": {"schema": {"type": "object"}}}}
    elif route == "POST /api/images":
        told["requestBody"] = {"required": True, "content": {"image/png": ANY}}
    return told


def _answers(route: str, path: str) -> dict[str, Any]:
    kind = "image/png" if path.endswith(".png") else "application/json"
    kind = {
        "GET /api/events": "text/event-stream", "GET /api/results/{id}/all.zip": "application/zip",
        "GET /api/results/{id}/report.html": "text/html",
        "GET /api/results/{id}/map.bin": "application/octet-stream",
        "GET /api/results/{id}/files/{name}": "application/octet-stream",
    }.get(route, kind)  # fmt: skip
    back = BACK.get(route)
    shape = ANY if back is None else _named(back)
    shape = {"type": "array", "items": shape} if route in LISTS else shape
    error = {"description": "Refused, in one line.", "content": {"application/json": {"schema": _named("Error")}}}
    done = {"description": "Done."} | ({} if route.startswith("DELETE") else {"content": {kind: {"schema": shape}}})
    same = {"304": {"description": "It is the one that If-None-Match names."}} if "weaves" in path else {}
    return {"2XX": done, **(same if route.startswith("GET") else {}), "4XX": error}


def _named(name: str) -> dict[str, Any]:
    return {"$ref": f"#/components/schemas/{name}"}


def _object(names: Iterable[str], **known: Any) -> dict[str, Any]:
    return {"type": "object", "properties": {name: known.get(name, ANY) for name in names}}


def _schemas() -> dict[str, Any]:
    text, number, ids = {"type": "string"}, {"type": "number"}, {"type": "array", "items": {"type": "string"}}
    states = {"enum": ["queued", "running", "done", "failed", "cancelled", "interrupted"]}
    fraction = {"type": "number", "minimum": 0, "maximum": 1}
    verb = {"enum": list(VERBS)}
    given: dict[str, Any] = {"type": "object", "description": "By name; pictures by their ids. Those of each verb:"}
    given["oneOf"] = [{"title": v, "properties": {n: _option(o) for n, o in options(v).items()}} for v in VERBS]
    crop = {"type": "array", "items": {"type": "integer"}, "minItems": 4, "maxItems": 4}
    flag = {"type": "boolean"}
    return {
        "Error": _object(["error"], error=text),
        "Exemplar": _object([*EXEMPLAR, "sample"], id=text, name=text, width=number, height=number),
        "Image": _object(["id", "width", "height", "values"], id=text, width=number, height=number),
        "JobWanted": _object(["verb", "exemplars", "options", "label"], verb=verb, exemplars=ids, options=given),
        "Job": _object(JOB, id=text, verb=verb, exemplars=ids, state=states, fraction=fraction),
        "Result": _object(PUBLIC, id=text, job=text, command=text, python=text),
        "Edit": _object(["crop", "straighten", "flatten"], crop=crop, straighten=flag, flatten=flag),
        **_weaves(),
    }


def _weaves() -> dict[str, Any]:
    """What is said of endless canvases."""
    text, whole = {"type": "string"}, {"type": "integer"}
    methods = [entry["slug"] for entry in schema()["methods"] if "window" in entry["supports"]]
    share = {"type": "number", "minimum": 0, "maximum": 1}
    place = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
    stroke = _object(
        ["radius", "strength", "points"], radius={"type": "number", "minimum": 1, "maximum": WIDEST},
        strength=share | {"type": ["number", "null"]}, points={"type": "array", "items": place},
    )  # fmt: skip
    strokes = {"type": "array", "items": stroke, "maxItems": STROKES}
    side = whole | {"minimum": 1, "maximum": LARGEST}
    return {
        "WeaveWanted": _object(
            ["exemplar", "method", "options", "seed", "jitter"], exemplar=text, method={"enum": ["auto", *methods]},
            seed=whole | {"minimum": 0}, jitter=_object(["ground", "strokes"], ground=share, strokes=strokes),
        ),
        "Weave": _object(
            ["id", "exemplar", "seed", "side", "levels", "method", "planes", "brush"], id=text, side={"const": SIDE},
            levels={"const": LEVELS}, brush={"type": "boolean"},
        ),
        "WindowWanted": _object(["x", "y", "width", "height"], x=whole, y=whole, width=side, height=side),
        "Window": _object(["job", "command", "needs"], job=_named("JobWanted"), command=text),
    }  # fmt: skip


def _option(option: dict[str, Any]) -> dict[str, Any]:
    """An option as JSON schema, as far as that tells it."""
    told: dict[str, Any] = {"description": option["help"]}
    if option["kind"] == "flag":
        return told | {"type": "boolean"}
    if option["kind"] == "choice":
        return told | {"enum": option["choices"]}
    if option["kind"] in ("int", "float") and not option["choices"]:
        told |= {"type": ["integer" if option["kind"] == "int" else "number", "string"]}
        return told | {k: option[n] for k, n in (("minimum", "low"), ("maximum", "high")) if option[n] is not None}
    return told
