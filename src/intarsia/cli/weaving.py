"""The work behind ``weave``: every store planned and checked, then streamed one after another."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, replace
from typing import Any

from ..errors import CancelledError, ParameterError
from ..giant.cells import gigabytes
from ..giant.executors import AHEAD, check_executor
from ..giant.stores import store_of
from ..giant.stream import DrawnAndPacked, Store, stream
from ..giant.texture import Weave, weave
from ..run import Run
from ..synthesis import check_between, recipe_settings
from .exemplars import Shelf, sets_of, stem_of
from .exits import CANCEL, Interrupted
from .outputs import filled
from .plan import blend_of
from .report import Report
from .request import Inputs, Wish
from .weave import ENDINGS, Loom

BASE, PER_PX, BETWEEN = 250 << 20, 60, 140
"""Memory of Python and its libraries in bytes; of a px that is drawn: its map, its weights, its pixels; and what a px
takes besides that is read between pixels."""

DRAWN = 1 << 22
"""Px of the map that a worker holds at most."""


@dataclass
class Weaving:
    """The planes of one giant picture: their names, textures and stores."""

    names: dict[str, str]
    texture: Weave
    size: tuple[int, int]  # width, height
    loom: Loom
    report: Report
    stores: dict[str, Store]

    @classmethod
    def plan(cls, inputs: Inputs, wish: Wish, loom: Loom, seed: int, report: Report) -> Weaving:
        """Read and check everything; nothing is written yet."""
        assert wish.size is not None
        check_executor(loom.who)
        ending = os.path.splitext(loom.out)[1].lower()
        if not loom.out or ending not in ENDINGS:
            raise ParameterError(f"-o {loom.out}: name a .zarr, a .tif, or a folder (without an ending) for tiles.")
        width, height = wish.size
        if any(side % inputs.magnify for side in (*wish.size, *loom.origin)):
            raise ParameterError(
                f"--size {width}x{height} and --origin {loom.origin[0]},{loom.origin[1]} do not suit --magnify "
                f"{inputs.magnify}; give multiples of {inputs.magnify}."
            )
        fields = {"seed": seed, "method": wish.method.slug, "w": width, "h": height, "stem": ""}
        filled(loom.out, fields)  # refuses unknown fields before anything is read
        inputs.check_standard_input(*wish.files)
        sets = sets_of(inputs, report)
        shelf = Shelf([sets], inputs, report)
        texture = weave(list(shelf.get(0)), wish.method, seed)
        texture = replace(texture, blend=blend_of(wish, texture.method, texture.exemplars[0]))
        check_between(texture.method, texture.blend)
        out = filled(loom.out, fields | {"stem": stem_of(sets[0]), "method": texture.method.slug})
        stem, own = os.path.splitext(out)
        names = {name: f"{stem}_{name}{own}" if n else out for n, name in enumerate(texture.planes)}
        grown_height, grown_width = height // inputs.magnify, width // inputs.magnify
        origin, stores = [n // inputs.magnify for n in (loom.origin[1], loom.origin[0])], dict[str, Store]()
        for name, path in names.items():
            shown = texture.plane(name)
            (grow, shrink), (h, w) = shown.scale, (grown_height, grown_width)
            if h % shrink or w % shrink or origin[0] % shrink or origin[1] % shrink:
                raise ParameterError(
                    f"{width}x{height} px do not suit the plane {name}, {shrink}x smaller; give multiples of {shrink}."
                )
            sides, first = (h * grow // shrink, w * grow // shrink), tuple(n * grow // shrink for n in origin)
            store = store_of(ENDINGS[ending], shown, path, sides, first, loom.chunk, loom.force)
            store.look()
            stores[name] = store
        return cls(names, texture, (width, height), loom, report, stores)

    def tell_plan(self, threads: int | None) -> None:
        """Say what would be made, how much memory it takes, and how long; one cell is drawn to know it."""
        workers, seconds, memory, raw = Run(threads).workers, 0.0, 0, 0
        each = PER_PX + (0 if getattr(self.texture.method, "exact", True) else BETWEEN)
        for store in self.stores.values():
            task, cell = DrawnAndPacked(store.texture, store.origin, store.packer), store.grid.cell(0)
            task(cell)
            began = time.perf_counter()
            packed = sum(map(len, task(cell)))
            px = (cell.box.y1 - cell.box.y0) * (cell.box.x1 - cell.box.x0)
            seconds += (time.perf_counter() - began) / px * store.grid.height * store.grid.width / workers
            deep = store.texture.channels * store.texture.dtype.itemsize
            raw += store.grid.height * store.grid.width * deep
            drawn = min(px * store.texture.scale[1] ** 2, DRAWN) * each + px * 2 * deep
            memory = max(memory, BASE + workers * drawn + AHEAD * workers * packed)
        about = self._about() | {
            "cells": sum(len(s.grid) for s in self.stores.values()),
            "pixels_bytes": raw, "memory_mib": memory >> 20, "seconds": round(seconds, 1),
        }  # fmt: skip
        self.report.note(
            f"{', '.join(self.names.values())}: {self._line()}, {gigabytes(raw)} of pixels, about {memory >> 20} MiB "
            f"of memory, {_span(seconds)} with {workers} workers like this one; not written (--dry-run)"
        )
        self.report.result({"dry_run": True, **about})

    def carry_out(self, threads: int | None) -> None:
        """Stream every plane, and report it."""
        began = time.perf_counter()
        try:
            with self.report.watching(len(self.stores)) as meter:
                for store in self.stores.values():
                    stream(store, self.loom.who, Run(threads, meter.stage("weave", 0.0, 1.0), CANCEL))
                    meter.next_part()
        except (Interrupted, CancelledError):
            raise CancelledError("stopped; the same command goes on where it was.") from None
        spent = time.perf_counter() - began
        self.report.note(f"{', '.join(self.names.values())}: {self._line()}, {spent:.1f} s")
        self.report.result(self._about() | {"seconds": round(spent, 3)})

    def _line(self) -> str:
        return f"{self.size[0]}x{self.size[1]} px, {self.texture.method.slug}, seed {self.texture.seed}"

    def _about(self) -> dict[str, Any]:
        """What JSON says of it, x before y."""
        return {
            "files": [{"path": path, "holds": name} for name, path in self.names.items()],
            "size": list(self.size),
            **({"magnify": times} if (times := self.texture.exemplars[0].times) > 1 else {}),
            "origin": list(self.loom.origin),
            "seed": self.texture.seed,
            "method": self.texture.method.slug,
            "parameters": recipe_settings(self.texture.method),
            "blend": self.texture.blend.told,
        }


def _span(seconds: float) -> str:
    """A time in words."""
    for unit, length in (("h", 3600), ("min", 60)):
        if seconds >= 1.5 * length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds:.1f} s"
