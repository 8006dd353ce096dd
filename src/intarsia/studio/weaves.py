"""Endless canvases: how they are begun, their tiles, and the command for a part of them."""

from __future__ import annotations

import json
from collections import OrderedDict
from dataclasses import replace

from starlette.exceptions import HTTPException

from ..foundation import AUTO_METHOD, InputError, ParameterError
from ..request import to_argv, to_line
from .processes import Gone, Process
from .showing import WITHIN, Pictures
from .store import Row, Store, digest
from .words import options as options_of
from .words import usual, words_of

FARTHEST = 1 << 40  # px from the middle
WEAVES = 200
SIDE, LEVELS = 256, 4  # px of a tile; from a pixel for a pixel to one for 8 x 8
GROWN = ("method", "seed")  # beside the method's parameters


class Weaves:
    """The endless canvases that pages look at, and the process that draws them."""

    def __init__(self, store: Store, pictures: Pictures) -> None:
        self.store, self.pictures, self.weaver = store, pictures, Process()
        self._known: OrderedDict[str, tuple[Row, Row]] = OrderedDict()  # the job, and what its tiles are drawn by

    async def begin(self, given: Row) -> Row:
        """Begin an endless canvas; its options are those of a job, save where it lies and how large it is."""
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
        """What was asked for under this id, while it is known."""
        if name not in self._known:
            raise HTTPException(404, "there is no such endless canvas; begin one with POST /api/weaves.")
        self._known.move_to_end(name)
        return self._known[name]

    async def tile(self, name: str, place: list[int], gone: Gone) -> bytes:
        """Draw a tile (level, row, column) as PNG, unless nobody waits for it any more."""
        level, y, x = place
        _, drawn = self._get(name)
        if not 0 <= level < LEVELS or (max(abs(y), abs(x)) + 1) * (SIDE << level) > FARTHEST:
            raise InputError(f"there is no such tile; levels are 0 to {LEVELS - 1}, and 2**40 px is as far as it goes.")
        key = ("tile", name, *place)
        found = self.pictures.get(key)
        while not found:
            _, found = await self.weaver.ask("tile", within=WITHIN, gone=gone, place=place, **drawn)
        return self.pictures.keep(key, found)

    def window(self, name: str, given: Row) -> Row:
        """The job that makes a part of a canvas, of a size from an origin on, and its command."""
        job, _ = self._get(name)
        if set(given) != {"size", "origin"}:
            raise ParameterError("give size (WIDTHxHEIGHT) and origin (X,Y) in px, and nothing else.")
        job = job | {"options": job["options"] | given}
        words = words_of(job, self.store)
        told = words.asked(f"{usual(job, self.store)}_woven.tif")
        return {"job": job, "command": to_line(told, joined=True), "needs": list(words.called.values())}
