"""From a job to the words of a command, and from what the command said back to what can be told and copied."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import click

from ..cli.app import cli
from ..cli.exits import judge
from ..errors import InputError, ParameterError, said
from ..methods.base import METHODS, method_class
from ..params import OVER, parameters, parse
from . import schema
from .store import Row, Store

LONGEST, MOST = 10_000, 100  # characters of a value, values of an option
ID = re.compile(r"[0-9a-f]{16}")
MAP = "map.npz"
"""The file of a result that holds its map."""

SIDES = {"size": "x", "extent": "x"}


@dataclass
class Words:
    """The words of a job as the worker gets them, and how people call the files among them."""

    said: list[str]
    called: dict[str, str] = field(default_factory=dict)

    def name(self, path: str, name: str) -> str:
        """Call a file by a name of its own."""
        stem, dot, ending = name.rpartition(".")
        taken, n = set(self.called.values()) - {self.called.get(path)}, 2
        own = name
        while own in taken:
            own, n = f"{stem}_{n}{dot}{ending}", n + 1
        self.called[path] = own
        return path

    def cleaned(self, told: Any) -> Any:
        """Return JSON or a text with files called as people call them."""
        if isinstance(told, dict):
            return {key: self.cleaned(value) for key, value in told.items()}
        if isinstance(told, list):
            return [self.cleaned(value) for value in told]
        if isinstance(told, str):
            for path in sorted(self.called, key=len, reverse=True):
                told = told.replace(path, self.called[path])
        return told

    def command(self, out: str) -> str:
        """The line for a shell that makes the file `out`."""
        own = ("--json", f"--save-map={MAP}", "--output=")
        kept = [self.cleaned(w) for w in self.said if not w.startswith(own)]
        return shlex.join(["intarsia", *kept, "-o", out])


def words_of(job: Mapping[str, Any], store: Store) -> Words:
    """Return the words of a job, checked as the command checks them; ParameterError in one line."""
    verb, exemplars, given = job["verb"], job["exemplars"], job["options"]
    if verb not in schema.VERBS:
        raise ParameterError(f"{said(verb)} is no verb; give one of {', '.join(schema.VERBS)}.")
    words, known = Words([verb]), schema.options(verb)
    if verb == "render":
        words.said.append(words.name(_map_of(given.get("map"), store), MAP))
    _add_exemplars(words, verb, exemplars, store)
    for name in given:
        if name not in known and not (verb == "render" and name == "map"):
            raise ParameterError(f"{verb} has no option {said(name)} here; GET /api/schema tells which there are.")
    for name, option in known.items():
        if given.get(name) is not None:
            words.said += _option(option, given[name], words, store)
    _check(words.said)
    words.said.append("--json")
    if verb == "render":
        words.said.append(f"--output={_usual(job, store)}_rendered.png")
    elif verb != "weave":
        words.said.append(f"--save-map={MAP}")
    return words


def _usual(job: Mapping[str, Any], store: Store) -> str:
    row = store.get("exemplars", job["exemplars"][0]) if job["exemplars"] else None
    return "map" if row is None else str(row["name"])


def _add_exemplars(words: Words, verb: str, exemplars: Sequence[str], store: Store) -> None:
    most = {"render": 64, "grow": 64, "paint": 64}.get(verb, 1)
    if not 1 <= len(exemplars) <= most and not (verb == "render" and not exemplars):
        raise ParameterError(f"{verb} takes {'one picture' if most == 1 else 'at least one exemplar'}.")
    for name in exemplars:
        for path in exemplar_words(name, words, store):
            words.said += [f"--exemplar={path}"] if verb == "render" else [path]


def exemplar_words(name: str, words: Words, store: Store) -> list[str]:
    """Return the files of an exemplar, as the working folder of a job sees them."""
    row = _row("exemplars", name, "an exemplar", store)
    if row.get("sample"):
        return [f"sample:{row['sample']}"]
    return [words.name(f"../../exemplars/{name}/{file}", file) for file in row["files"]]


def _row(kind: str, name: Any, what: str, store: Store) -> Row:
    row = store.get(kind, name) if isinstance(name, str) and ID.fullmatch(name) else None
    if row is None:
        raise InputError(f"{said(name)} is not the id of {what}.")
    return row


def _map_of(name: Any, store: Store) -> str:
    row = _row("results", name, "a result; the option map needs one", store)
    if not (store.folder / "results" / row["id"] / MAP).is_file():
        raise InputError("this result has no map.")
    return f"../{row['id']}/{MAP}"


def _option(option: schema.Option, value: Any, words: Words, store: Store) -> list[str]:
    """An option with its value, or its values, as one word each."""
    flag, name = option["flag"], option["name"]
    if option["kind"] == "flag":
        if not isinstance(value, bool):
            raise ParameterError(f"{name} is yes or no; give true or false.")
        return [flag] if value else []
    values = value if option["multiple"] and isinstance(value, list) else [value]
    if len(values) > MOST:
        raise ParameterError(f"{name} has {len(values)} values; at most {MOST}.")
    found = []
    for one in values:
        if option["kind"] == "exemplar":
            found += exemplar_words(one, words, store)
        elif option["kind"] == "image" or (option.get("image") and isinstance(one, str) and ID.fullmatch(one)):
            found.append(_image(option, one, words, store))
        else:
            found.append(_text(option, one))
    return [f"{flag}={text}" for text in found]


SCORED = ("--alpha", "--avoid", "--toroidal", "--crop", "--scale", "--flatten")
"""Options on exemplars that the command score has, too."""


def score_words(words: Words, picture: str) -> list[str]:
    """The words that score the picture of a result in its folder."""
    sources = [w for w in words.said[1:] if not w.startswith("-")]
    shared = [w for w in words.said if w.partition("=")[0] in SCORED]
    mapped = [f"--map={MAP}"] if f"--save-map={MAP}" in words.said else []
    return ["score", *sources, *shared, picture, *mapped, "--json"]


def _image(option: schema.Option, value: Any, words: Words, store: Store) -> str:
    if value in option["choices"]:
        return str(value)
    row = _row("images", value, f"an image; {option['name']} needs one", store)
    return words.name(f"../../images/{row['id']}.png", f"{option['name']}.png")


def _text(option: schema.Option, value: Any) -> str:
    """A value as a command reads it; what would be the name of a file is refused."""
    name = option["name"]
    if isinstance(value, list) and value and all(isinstance(v, int | float | str) for v in value):
        between = SIDES.get(option["kind"], ",")
        value = between.join(map(str, value))
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ParameterError(f"{name}={said(value)} is not allowed; give a number or a text.")
    text = str(value)
    if len(text) > LONGEST or not text.isprintable():
        raise ParameterError(f"{name} is too long, or holds what cannot be printed; give something legible.")
    if option["parameter"]:
        if option["image"] and text not in option["choices"]:
            try:
                float(text)
            except ValueError:
                raise ParameterError(f"{name}={said(text)} is not allowed; give a number or an image's id.") from None
        parse(schema.parameter(option["field"]), text)
    return text


def method_values(method: str, given: Any) -> dict[str, str]:
    """Return parameters of a method as texts that are checked; a picture is none of them here."""
    if not isinstance(given, dict):
        raise ParameterError("options is an object.")
    known = {p.name: p for p in parameters(method_class(method))} if method in METHODS else {}
    for name in given:
        if name not in known:
            raise ParameterError(f"{said(method)} has no parameter {said(name)}.")
    texts = {}
    for name, value in given.items():
        p = known[name]
        option = {"name": name, "field": name, "kind": p.kind, "choices": p.choices, "image": p.kind in OVER}
        if value is not None:
            texts[name] = _text(option | {"parameter": True}, value)
    return texts


def _check(words: Sequence[str]) -> None:
    """Have the command read its words, as far as that needs no file."""
    verb, *rest = words
    command = cli.get_command(click.Context(cli), verb)
    assert command is not None
    rest = [*rest, "--output=out.png"] if verb == "render" else rest
    try:
        with command.make_context(verb, rest):
            pass
    except click.ClickException as e:
        raise ParameterError(plain(judge(e)[1].partition(" (see ")[0])) from None


def plain(line: str) -> str:
    """An error of the command, said of the option by the name that it has here."""
    return re.sub(r"^Invalid value for '--([a-z-]+)'[^:]*", lambda found: found[1].replace("-", "_"), line)
