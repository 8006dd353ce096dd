"""Endless canvases: how they are begun, their tiles, what was painted on them, and the command for a part of them."""

from __future__ import annotations

import hashlib
import json
from collections import OrderedDict
from itertools import pairwise
from typing import Any

from starlette.exceptions import HTTPException

from ..choosing.auto import AUTO_METHOD
from ..errors import InputError, ParameterError
from ..request.argv import to_line
from .processes import Process, Wanted
from .showing import Pictures
from .store import Row, Store
from .uploads import Uploads
from .words import options as options_of
from .words import words_of

WITHIN = 120.0  # s for one answer
FARTHEST = 1 << 40  # px from the middle
WEAVES = 200
SIDE, LEVELS = 256, 4  # px of a tile; from a pixel for a pixel to one for 8 x 8
LARGEST = 16384  # px a side of a part that a command makes
STROKES, POINTS, APART, WIDEST = 500, 5000, 1024, 512
"""Most strokes, most points of all of them, px from point to point, px of a radius."""


class Weaves:
    """The endless canvases that pages look at, and the process that draws them."""

    def __init__(self, store: Store, uploads: Uploads, pictures: Pictures) -> None:
        self.store, self.uploads, self.pictures, self.weaver = store, uploads, pictures, Process()
        self._known: OrderedDict[str, Row] = OrderedDict()

    async def begin(self, given: dict[str, Any]) -> Row:
        """Begin an endless canvas."""
        if unknown := set(given) - {"exemplar", "method", "options", "seed", "jitter"}:
            listed = ", ".join(sorted(unknown))[:100]
            raise ParameterError(f"{listed} is unknown; give exemplar, method, options, seed and jitter.")
        method, seed, options = given.get("method", AUTO_METHOD), given.get("seed", 0), given.get("options", {})
        if type(seed) is not int or not 0 <= seed < 1 << 64:
            raise ParameterError("the seed is a whole number from 0 to 2**64 - 1.")
        known = options_of("weave")
        if not isinstance(options, dict) or any(n in known and not known[n]["parameter"] for n in options):
            raise ParameterError("options is an object of the method's parameters.")
        asked = {"exemplars": [given.get("exemplar")], "options": {**options, "method": method, "size": "1x1"}}
        words, jitter = words_of({"verb": "weave", **asked}, self.store), jitter_of(given.get("jitter"))
        if jitter is not None and (method == AUTO_METHOD or "jitter_output" in options):
            raise ParameterError("what is painted needs a method that is named, and no jitter_output besides.")
        name = given["exemplar"]
        base = _digest([name, method, options, seed])
        own = base if jitter is None else _digest([base, jitter])
        row = {
            "id": own, "base": base, "exemplar": name, "words": words.said, "method": method, "options": options,
            "folder": str(self.store.folder / "exemplars" / name), "seed": seed, "jitter": jitter,
        }  # fmt: skip
        told, _ = await self.weaver.ask("begin", within=WITHIN, **row)
        while len(self._known) >= WEAVES:
            self._known.popitem(last=False)
        self._known[own] = row
        return {"id": own, "exemplar": name, "seed": seed, "side": SIDE, "levels": LEVELS, **told}

    def get(self, name: str) -> Row:
        """Return what was asked for under this id, while it is known."""
        if name not in self._known:
            raise HTTPException(404, "there is no such endless canvas; begin one with POST /api/weaves.")
        self._known.move_to_end(name)
        return self._known[name]

    async def tile(
        self, name: str, place: tuple[int, int, int], known: str, wanted: Wanted
    ) -> tuple[str, bytes | None]:
        """Draw a tile (level, row, column), unless nobody waits for it any more: what it depends on, and its bytes.

        None where it depends on what is `known` already.
        """
        level, y, x = place
        row = self.get(name)
        if not 0 <= level < LEVELS or (max(abs(y), abs(x)) + 1) * (SIDE << level) > FARTHEST:
            raise InputError(f"there is no such tile; levels are 0 to {LEVELS - 1}, and 2**40 px is as far as it goes.")
        found = self.pictures.get(("tile", name, *place))
        if found is None:
            answer, data = {"more": True}, b""
            while answer.get("more"):
                given = row | {"level": level, "y": y, "x": x, "known": known}
                answer, data = await self.weaver.ask("tile", within=WITHIN, wanted=wanted, **given)
            key = str(answer["key"])
            if key == known:
                return key, None
            found = self.pictures.keep(("tile", name, *place), key.encode() + b"\n" + data)
        kept, _, bytes_ = found.partition(b"\n")
        return kept.decode(), None if kept.decode() == known else bytes_

    async def window(self, name: str, given: dict[str, Any]) -> Row:
        """The job that makes a part of a canvas, and its command; what was painted becomes an image."""
        row = self.get(name)
        place = [given.get(key) for key in ("x", "y", "width", "height")]
        if set(given) - {"x", "y", "width", "height"} or not all(type(n) is int for n in place):
            raise ParameterError("give x, y, width and height in px, and nothing else.")
        x, y, width, height = (int(n or 0) for n in place)
        if not (min(width, height) >= 1 and max(width, height) <= LARGEST and max(abs(x), abs(y)) < FARTHEST):
            raise ParameterError(f"give 1 to {LARGEST} px a side, not farther than 2**40 px out.")
        options: dict[str, Any] = {"size": f"{width}x{height}", "origin": f"{x},{y}", "method": row["method"]}
        options |= {"seed": row["seed"], **row["options"]}
        if row["jitter"] is not None:
            asked = row | {"box": [y, x, y + height, x + width]}
            _, picture = await self.weaver.ask("painted", within=WITHIN, **asked)
            same = round(round(row["jitter"]["ground"] * 255) / 255, 7)  # as exactly as it is used
            options["jitter_output"] = (await self.uploads.image(picture))["id"] if picture else same
        job = {"verb": "weave", "exemplars": [row["exemplar"]], "options": options}
        words, known = words_of(job, self.store), self.store.get("exemplars", row["exemplar"])
        told = words.asked(f"{known['name'] if known else 'picture'}_woven.tif")
        return {"job": job, "command": to_line(told, joined=True), "needs": list(words.called.values())}


def jitter_of(given: Any) -> Row | None:
    """What was painted, checked: `ground`, what holds where nothing was, and `strokes`, the last one on top."""
    if given is None:
        return None
    if not isinstance(given, dict) or set(given) - {"ground", "strokes"}:
        raise ParameterError("jitter is an object of ground and strokes.")
    ground, strokes = given.get("ground", 1), given.get("strokes", [])
    if not _number(ground, 0, 1) or not isinstance(strokes, list) or len(strokes) > STROKES:
        raise ParameterError(f"jitter: ground is 0 to 1, and strokes are at most {STROKES}.")
    kept = [_stroke(stroke) for stroke in strokes]
    if sum(len(stroke["points"]) for stroke in kept) > POINTS:
        raise ParameterError(f"jitter: all strokes have at most {POINTS} points.")
    return {"ground": float(ground), "strokes": kept}


def _stroke(given: Any) -> Row:
    if not isinstance(given, dict) or set(given) != {"radius", "strength", "points"}:
        raise ParameterError("a stroke has a radius, a strength and points.")
    radius, strength, points = given["radius"], given["strength"], given["points"]
    if not _number(radius, 1, WIDEST) or not (strength is None or _number(strength, 0, 1)):
        raise ParameterError(f"a stroke has a radius of 1 to {WIDEST} px, and a strength of 0 to 1, or null.")
    places = points if isinstance(points, list) else []
    whole = [isinstance(p, list) and len(p) == 2 and all(_number(n, -FARTHEST, FARTHEST) for n in p) for p in places]
    if not places or not all(whole):
        raise ParameterError("the points of a stroke are [x, y] in px.")
    if any(max(abs(a[0] - b[0]), abs(a[1] - b[1])) > APART for a, b in pairwise(places)):
        raise ParameterError(f"the points of a stroke are at most {APART} px apart.")
    strength = None if strength is None else float(strength)
    return {"radius": float(radius), "strength": strength, "points": [[float(x), float(y)] for x, y in places]}


def _number(given: Any, low: float, high: float) -> bool:
    return isinstance(given, int | float) and not isinstance(given, bool) and low <= given <= high


def _digest(told: Any) -> str:
    return hashlib.sha256(json.dumps(told).encode()).hexdigest()[:16]
