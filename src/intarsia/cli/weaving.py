"""The work behind ``weave``: every store planned and checked, then streamed one after another."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field
from typing import Any

from ..disk.memory import check_fits
from ..errors import CancelledError, ParameterError
from ..files.formats import SUFFIXES
from ..giant.cells import gigabytes
from ..giant.executors import check_executor
from ..giant.picture import Store
from ..giant.stream import estimated, fill, finish, memory_of, store_of
from ..giant.texture import Weave, planned_windows, woven
from ..run import Run
from ..synthesis import as_exemplars, recipe_exemplars
from .again import weave_command_of
from .choosing import as_json, explain
from .exemplars import Shelf, sets_of, stem_of
from .exits import CANCEL, Interrupted, unbroken
from .outputs import filled_name, usual_name
from .plan import method_as_json, with_joins
from .report import Report
from .request import Inputs, Loom, Wish

ENDINGS = dict.fromkeys(SUFFIXES, "picture") | {".zarr": "zarr", ".tif": "tiff", ".tiff": "tiff", "": "tiles"}
USUAL = ".tif"
"""How the name ends that is given where none is: one file, however large."""


@dataclass
class Weaving:
    """The planes of one giant picture: their names, textures and stores."""

    names: dict[str, str]
    texture: Weave
    size: tuple[int, int]  # width, height
    loom: Loom
    report: Report
    stores: dict[str, Store]
    auto: dict[str, Any] = field(default_factory=dict)  # how the method was chosen, where it was not named
    warnings: tuple[str, ...] = ()
    read: float = 0.0  # seconds

    @classmethod
    def plan(cls, inputs: Inputs, wish: Wish, loom: Loom, report: Report) -> Weaving:
        """Read and check everything; nothing is written yet."""
        assert wish.size is not None
        began = time.perf_counter()
        check_executor(loom.who)
        ending = os.path.splitext(loom.out)[1].lower() if loom.out else USUAL
        if ending not in ENDINGS:
            raise ParameterError(
                f"-o {loom.out}: name a .zarr, a .tif, a picture such as .png, or a folder (no ending) for tiles."
            )
        width, height = wish.size
        if any(side % inputs.magnify for side in (*wish.size, *loom.origin)):
            raise ParameterError(
                f"--size {width}x{height} and --origin {loom.origin[0]},{loom.origin[1]} do not suit --magnify "
                f"{inputs.magnify}; give multiples of {inputs.magnify}."
            )
        fields = {"seed": loom.seed, "method": wish.method.slug, "w": width, "h": height, "stem": ""}
        filled_name(loom.out, fields)  # refuses unknown fields before anything is read
        inputs.check_standard_input(*wish.files)
        sets = sets_of(inputs, report)
        exemplars = as_exemplars(list(Shelf([sets], inputs, report).get(0)))
        plan = with_joins(planned_windows(exemplars, wish.method), wish)
        texture, choice = woven(plan, loom.seed), plan.choice
        fields |= {"stem": stem_of(sets[0]), "method": texture.method.slug}
        out = filled_name(loom.out, fields) if loom.out else usual_name(sets, "woven") + USUAL
        stem, own = os.path.splitext(out)
        names = {name: f"{stem}_{name}{own}" if n else out for n, name in enumerate(texture.planes)}
        place, stores = [n // inputs.magnify for n in (height, width, *loom.origin[::-1])], dict[str, Store]()
        for name, path in names.items():
            drawn = texture.plane(name)
            grow, shrink = drawn.scale
            if any(n % shrink for n in place):
                raise ParameterError(
                    f"{width}x{height} px do not suit the plane {name}, {shrink}x smaller; give multiples of {shrink}."
                )
            h, w, y, x = (n * grow // shrink for n in place)
            stores[name] = store_of(ENDINGS[ending], drawn, path, (h, w), (y, x), loom.chunk, loom.force)
            stores[name].look()
        auto = {} if choice is None else as_json(choice, wish.explain)
        if choice is not None:
            auto["command"] = weave_command_of(texture.method, out, sets, inputs, wish, loom)
        warnings, spent = () if choice is None else choice.warnings, time.perf_counter() - began
        return cls(names, texture, (width, height), loom, report, stores, auto, warnings, spent)

    def tell_plan(self, threads: int | None) -> None:
        """Say what would be made, how much memory it takes, and how long; one cell is drawn to know it."""
        workers, seconds, memory, raw = Run(threads).workers, 0.0, 0, 0
        for store in self.stores.values():
            needed = estimated(store, workers)
            seconds, memory = seconds + needed.seconds, max(memory, needed.memory)
            raw += store.grid.height * store.grid.width * store.texture.channels * store.texture.dtype.itemsize
        about = self._about() | {
            "patches": None, "cells": sum(len(s.grid) for s in self.stores.values()),
            "pixels_bytes": raw, "memory_mib": memory >> 20, "seconds": round(seconds, 1),
        }  # fmt: skip
        self._warn()
        self.report.note(
            f"{', '.join(self.names.values())}: {self._line()}, {gigabytes(raw)} of pixels, about {memory >> 20} MiB "
            f"of memory, {_span(seconds)} with {workers} workers like this one; not written (--dry-run)"
        )
        explain(self.report, about, self.warnings)
        self.report.result({"dry_run": True, **about})

    def carry_out(self, threads: int | None) -> None:
        """Stream every plane, and report it; what cannot fit into memory is refused before anything is made."""
        workers = Run(threads).workers
        for name, store in self.stores.items():
            instead = "name a .zarr or a .tif, which need not fit" if store.held else "use fewer --threads"
            check_fits(memory_of(store, workers), f"{self.names[name]}: {self._line()}", instead)
        began = time.perf_counter()
        self._make(threads)
        spent = time.perf_counter() - began
        self._warn()
        self.report.note(f"{', '.join(self.names.values())}: {self._line()}, {spent:.1f} s")
        explain(self.report, self._about(), self.warnings)
        timings = {"read": self.read, "weave": spent, "total": self.read + spent}
        self.report.result(self._about() | {"timings": {k: round(v, 3) for k, v in timings.items()}})

    def _make(self, threads: int | None) -> None:
        """Fill the stores of all planes; when all of them are whole, they take their names together."""
        stores = self.stores.values()
        try:
            with self.report.watching(len(stores)) as meter:
                for store in stores:
                    fill(store, self.loom.who, Run(threads, meter.stage("weave", 0.0, 1.0), CANCEL))
                    meter.next_part()
            with unbroken():
                for store in stores:
                    finish(store)
        except (Interrupted, CancelledError):
            if all(store.resumes for store in stores):
                raise CancelledError("stopped; the same command goes on where it was.") from None
            raise CancelledError("stopped; nothing was written, and the same command begins anew.") from None
        finally:
            with unbroken():
                for store in stores:
                    store.close()

    def _warn(self) -> None:
        for line in self.warnings:
            self.report.warn(line)

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
            "wrap": "none",
            **method_as_json(self.texture.method, self.texture.blend),
            "exemplars": recipe_exemplars(self.texture.exemplars),
            **({"auto": self.auto} if self.auto else {}),
        }


def _span(seconds: float) -> str:
    """A time in words."""
    for unit, length in (("h", 3600), ("min", 60)):
        if seconds >= 1.5 * length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds:.1f} s"
