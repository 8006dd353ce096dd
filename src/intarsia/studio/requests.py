"""Jobs as requests of the command line: the options offered, the request of a job, and the row of its result."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache
from pathlib import Path
from typing import Any

from ..cli.verbs import entries, read_argv
from ..disk import DEFAULT_PIXELS
from ..foundation import SAMPLES, InputError, ParameterError, said
from ..foundation.params import OVER
from ..request import Request, fields_of_verb, from_json, parameters_of_verb, text_of, to_argv, to_line
from ..request.field import Field
from ..request.fields import PICTURE_VERBS
from ..request.python import to_python
from .store import ID, Row, Store
from .uploads import stem_of

VERBS = ("grow", "paint", "extend", "heal", "tile", "weave", "render")
"""The commands that a job can be."""

LIMITS = {
    "pixels": DEFAULT_PIXELS,
    "upload": 512 << 20,
    "files": 24,
    "image": 64 << 20,
    "json": 1 << 20,
    "queue": 1000,
}
"""Most pixels of a picture; bytes of an upload, files in it, bytes of an image and of JSON; queued jobs."""

LONGEST, MOST = 10_000, 100  # characters of a value, values of an option
MAP = "map.npz"
"""The file of a result that holds its map."""


@cache
def options(verb: str) -> dict[str, Row]:
    """Return the options of a verb by name: the fields of a job, and the parameters of methods."""
    fields = [_of_field(f) for f in fields_of_verb(verb) if not f.local and f.flags and f.kind.name != "written"]
    own = [p.as_dict() | {"parameter": True, "image": p.kind in OVER} for p, _ in parameters_of_verb(verb).values()]
    return {option["name"]: option for option in [*fields, *own]}


@cache
def schema() -> Row:
    """Return what the page offers, as JSON: the fields of verbs, and methods with their parameters."""
    verbs = {v: [option for option in options(v).values() if not option["parameter"]] for v in VERBS}
    return {"verbs": verbs, "methods": entries(), "samples": list(SAMPLES)}


def _of_field(f: Field) -> Row:
    """Return a field as JSON."""
    default = f.default if isinstance(f.default, str | int | float) else None
    if default is None and (f.kind.choices or f.default is not None) and not f.many and f.kind.name != "choice":
        default = f.kind.text(f.default)
    return {
        "name": f.key, "kind": f.kind.name, "help": f.help, "default": default, "low": getattr(f.kind, "low", None),
        "high": getattr(f.kind, "high", None), "choices": list(f.kind.choices), "multiple": f.many,
        "parameter": False, "image": False,
    }  # fmt: skip


@dataclass
class Words:
    """The request of a job as the worker gets it, and the file names that users see."""

    store: Store
    request: Request = field(default_factory=lambda: Request("grow"))
    called: dict[str, str] = field(default_factory=dict)

    @property
    def said(self) -> list[str]:
        """The request as words of a command, each option joined with its value."""
        return to_argv(self.request, joined=True)

    def name(self, path: str, name: str) -> str:
        """Give a file a unique name for users."""
        stem, dot, ending = name.rpartition(".")
        taken, n = set(self.called.values()) - {self.called.get(path)}, 2
        own = name
        while own in taken:
            own, n = f"{stem}_{n}{dot}{ending}", n + 1
        self.called[path] = own
        return path

    def cleaned(self, told: Any) -> Any:
        """Return JSON or a text with paths replaced by the names for users."""
        if isinstance(told, dict):
            return {key: self.cleaned(value) for key, value in told.items()}
        if isinstance(told, (list, tuple)):
            return type(told)(map(self.cleaned, told))
        if isinstance(told, str):
            for path in sorted(self.called, key=len, reverse=True):
                told = told.replace(path, self.called[path])
        return told

    def asked(self, out: str) -> Request:
        """Return the request with the names for users, for a result called `out`."""
        named = {f.name: self.cleaned(getattr(self.request, f.name)) for f in fields(self.request)}
        return Request(**named | {"out": out, "save_map": None, "as_json": False})

    def exemplar(self, name: str) -> list[str]:
        """Return the files of an exemplar, relative to the working folder of a job."""
        row = self._row("exemplars", name, "an exemplar")
        if row.get("sample"):
            return [f"sample:{row['sample']}"]
        return [self.name(f"../../exemplars/{name}/{file}", file) for file in row["files"]]

    def saved_map(self, name: Any) -> str:
        """Return the map of a result."""
        row = self._row("results", name, "a result; the option map needs one")
        if not (self.store.place("results", row["id"]) / MAP).is_file():
            raise InputError("this result has no map.")
        return self.name(f"../{row['id']}/{MAP}", MAP)

    def value(self, option: Row, value: Any) -> Any:
        """Return the value of an option, or its values, as texts; files in place of ids."""
        if option["kind"] == "flag":
            return value
        many = option.get("multiple")
        values = value if many and isinstance(value, list) else [value]
        if len(values) > MOST:
            raise ParameterError(f"{option['name']} has {len(values)} values; at most {MOST}.")
        found = list[str]()
        for one in values:
            if option["kind"] == "exemplar":
                found += self.exemplar(one)
            elif option["kind"] == "image" or (option["image"] and isinstance(one, str) and ID.fullmatch(one)):
                found.append(self._image(option, one))
            else:
                found.append(_text(option, one))
        return found if many else found[0]

    def _image(self, option: Row, value: Any) -> str:
        if value in option["choices"]:
            return str(value)
        row = self._row("images", value, f"an image; {option['name']} needs one")
        return self.name(f"../../images/{row['id']}.png", f"{option['name']}.png")

    def _row(self, kind: str, name: Any, what: str) -> Row:
        row = self.store.get(kind, name) if isinstance(name, str) and ID.fullmatch(name) else None
        if row is None:
            raise InputError(f"{said(name)} is not the id of {what}.")
        return row


def asked_of(given: Row) -> Row:
    """Return verb, exemplars and options of a job; ParameterError if it has others, or of a wrong type."""
    asked: Row = {"verb": None, "exemplars": [], "options": {}} | given
    if len(asked) > 3 or not isinstance(asked["exemplars"], list) or not isinstance(asked["options"], dict):
        raise ParameterError("a job has a verb, exemplars (a list of ids) and options (an object), no more.")
    return asked


def words_of(job: Row, store: Store) -> Words:
    """Return the request of a job, checked as the command checks it; ParameterError in one line."""
    verb, exemplars, given = job["verb"], job["exemplars"], dict(job["options"])
    if verb not in VERBS:
        raise ParameterError(f"{said(verb)} is no verb; give one of {', '.join(VERBS)}.")
    words, known, more = Words(store), options(verb), Row()
    if verb == "render":
        more["saved"] = words.saved_map(given.pop("map", None))
    most = 64 if verb in ("render", "grow", "paint") else 1
    if not 1 <= len(exemplars) <= most and not (verb == "render" and not exemplars):
        raise ParameterError(f"{verb} takes {'one picture' if most == 1 else 'at least one exemplar'}.")
    more["files"] = tuple(path for name in exemplars for path in words.exemplar(name))
    for name in given:
        if name not in known:
            raise ParameterError(f"{verb} has no option {said(name)} here; GET /api/schema tells which there are.")
    told = {name: words.value(known[name], value) for name, value in given.items() if value is not None}
    if verb == "render":
        more["out"] = f"{usual(job, store)}_rendered.png"
    elif verb == "weave":
        row = store.get("exemplars", exemplars[0]) or {"depth": 8, "planes": []}
        plain = row["depth"] <= 16 and len(row["planes"]) == 1  # a TIFF is streamed, and has a ledger beside it
        more["out"] = f"{usual(job, store)}_woven.{'png' if plain else 'tif'}"
    else:
        more["save_map"] = MAP
    words.request = from_json(verb, told, as_json=True, **more)
    return words


def usual(job: Row, store: Store) -> str:
    """Return the name of the first exemplar, from which results are named."""
    row = store.get("exemplars", job["exemplars"][0]) if job["exemplars"] else None
    return "map" if row is None else stem_of(f"{row['name']}.")


def origin_of(store: Store, exemplars: Sequence[str]) -> Row | None:
    """Return the result that the first of some exemplars is, if it is one."""
    row = store.get("exemplars", exemplars[0]) if exemplars else None
    return None if row is None else store.get("results", row.get("from", ""))


def score_words(words: Words, picture: str, job: Row) -> list[str]:
    """Return the words that score the picture of a result in its folder.

    What was mended of a result is scored against the exemplars of that result.
    """
    asked, before = words.request, origin_of(words.store, job["exemplars"])
    if job["verb"] in PICTURE_VERBS and before is not None and before["score_words"]:
        wrap = asked.axes if job["verb"] == "tile" else asked.wrap
        told = read_argv(before["score_words"])
        return to_argv(replace(told, output=picture, saved=None, wrap=wrap), joined=True)
    shared = {f.name: getattr(asked, f.name) for f in fields_of_verb("score") if f.of_exemplars}
    saved = None if asked.save_map is None else MAP
    scored = Request("score", files=asked.files, output=picture, saved=saved, as_json=True, **shared)
    return to_argv(scored, joined=True)


def _text(option: Row, value: Any) -> str:
    """Return a value as a command reads it; ParameterError for what could name a file."""
    name, parts = option["name"], value if isinstance(value, list) else [value]
    if not parts or not all(isinstance(v, int | float | str) and not isinstance(v, bool) for v in parts):
        raise ParameterError(f"{name}={said(value)} is not allowed; give a number or a text.")
    text = text_of(option["kind"], value)
    if len(text) > LONGEST or not text.isprintable():
        raise ParameterError(f"{name} is too long, or holds what cannot be printed; give something legible.")
    if option["image"] and text not in option["choices"]:
        try:
            float(text)
        except ValueError:
            raise ParameterError(f"{name}={said(text)} is not allowed; give a number or an image's id.") from None
    return text


def result_of(name: str, job: Row, words: Words, answer: Row, files: Sequence[Path]) -> Row:
    """Return the row of a result: what the command reported, without paths."""
    holds = {Path(entry["path"]).name: entry["holds"] for entry in answer.get("files", [])}
    holds.setdefault(MAP, "map")
    entries = [{"name": p.name, "holds": holds.get(p.name, "recipe"), "bytes": p.stat().st_size} for p in sorted(files)]
    pictures = [Path(entry["path"]).name for entry in answer.get("files", []) if Path(entry["path"]).name != MAP]
    clean, judged = words.cleaned(answer), bool(pictures) and job["verb"] != "render"
    asked = words.asked(pictures[0] if pictures else "out.png")
    return {
        "id": name, "job": job["id"], "verb": job["verb"], "exemplars": job["exemplars"], "options": job["options"],
        "size": answer.get("size"), "files": entries, "pictures": pictures, "told": clean,
        "command": to_line(asked, joined=True), "python": to_python(asked, clean), "made": time.time(), "score": None,
        "label": job["label"], "began": job["began"],
        "inputs": {own: path for path, own in words.called.items()},
        "score_words": score_words(words, pictures[0], job) if judged else None,
    }  # fmt: skip
