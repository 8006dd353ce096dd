"""The work of ``weave``: the stores of all planes planned and checked, then streamed one after another."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field

from ..disk import check_fits
from ..files.formats import SUFFIXES
from ..foundation import CancelledError, ParameterError
from ..foundation.arrays import Pair
from ..foundation.run import Run
from ..giant import Weave, planned_windows, woven
from ..giant.exports import PictureStore, TiffStore
from ..giant.picture import Store
from ..giant.stream import check_dask, estimated, fill, finish, memory_of
from ..giant.zarrays import ZarrStore
from ..request import Json, Request, repeated, to_line
from ..synthesis import as_exemplars, recipe_exemplars
from ..tasks import with_joins
from . import CANCEL, Interrupted, Report, as_json, explain, unbroken
from .exemplars import Inputs, sets_of, stem_of
from .outputs import filled_name, usual_name
from .plan import method_as_json

STORES: dict[str, type[Store]] = dict.fromkeys(SUFFIXES, PictureStore) | {
    ".zarr": ZarrStore, ".tif": TiffStore, ".tiff": TiffStore
}  # fmt: skip
"""Ending of a name -> how the picture is stored."""

USUAL = ".tif"
"""Ending of the default name: one file of any size."""


@dataclass
class Weaving:
    """The planes of one giant picture: their names, textures and stores."""

    names: dict[str, str]
    texture: Weave
    size: Pair  # width, height
    request: Request
    report: Report
    stores: dict[str, Store]
    auto: Json = field(default_factory=dict)  # how the method was chosen, where it was not named
    warnings: tuple[str, ...] = ()
    read: float = 0.0  # seconds

    @classmethod
    def plan(cls, request: Request, report: Report) -> Weaving:
        """Read and check everything; nothing is written yet."""
        assert request.size is not None
        began = time.perf_counter()
        check_dask(request.dask)
        ending = os.path.splitext(request.out)[1].lower() if request.out else USUAL
        if ending not in STORES:
            raise ParameterError(f"-o {request.out}: name a .zarr, a .tif, or a picture such as .png.")
        (width, height), origin, times = request.size, request.origin, request.magnify
        if any(side % times for side in (*request.size, *origin)):
            raise ParameterError(
                f"--size {width}x{height} and --origin {origin[0]},{origin[1]} do not suit --magnify "
                f"{times}; give multiples of {times}."
            )
        seed, method = request.seed or 0, request.chosen
        filled_name(request.out or "", {})  # refuses unknown fields before anything is read
        sets = sets_of(request, report)
        exemplars = as_exemplars(list(Inputs(sets, request, report).exemplars))
        plan = with_joins(planned_windows(exemplars, method), request)
        texture, choice = woven(plan, seed), plan.choice
        fields = {"stem": stem_of(sets[0]), "method": texture.method.slug, "seed": seed, "w": width, "h": height}
        out = filled_name(request.out, fields) if request.out else usual_name(sets, "woven") + USUAL
        stem, own = os.path.splitext(out)
        names = {name: f"{stem}_{name}{own}" if n else out for n, name in enumerate(texture.planes)}
        place, stores = [n // times for n in (height, width, *origin[::-1])], dict[str, Store]()
        for name, path in names.items():
            drawn = texture.plane(name)
            grow, shrink = drawn.scale
            if any(n % shrink for n in place):
                raise ParameterError(
                    f"{width}x{height} px do not suit the plane {name}, {shrink}x smaller; give multiples of {shrink}."
                )
            h, w, y, x = (n * grow // shrink for n in place)
            stores[name] = STORES[ending].of(drawn, path, (h, w), (y, x), request.chunk, request.force)
            stores[name].look()
        auto = {} if choice is None else as_json(choice, request.explain)
        if choice is not None:
            auto["command"] = to_line(repeated(request, sets, texture.method, seed, out=out, force=False))
        warnings, spent = () if choice is None else choice.warnings, time.perf_counter() - began
        return cls(names, texture, (width, height), request, report, stores, auto, warnings, spent)

    def tell_plan(self) -> None:
        """Report what would be made, its memory and time, which drawing one cell measures."""
        workers, seconds, memory, raw = Run(self.request.threads).workers, 0.0, 0, 0
        for store in self.stores.values():
            spent, needed = estimated(store, workers)
            seconds, memory = seconds + spent, max(memory, needed)
            raw += store.grid.height * store.grid.width * store.texture.channels * store.texture.dtype.itemsize
        about = self._about() | {
            "cells": sum(len(s.grid) for s in self.stores.values()),
            "pixels_bytes": raw, "memory_mib": memory >> 20, "seconds": round(seconds, 1),
        }  # fmt: skip
        self.report.warn(*self.warnings)
        self.report.note(
            f"{', '.join(self.names.values())}: {self._line()}, {raw >> 20} MiB of pixels, about {memory >> 20} MiB "
            f"of memory, {_span(seconds)} with {workers} workers like this one; not written (--dry-run)"
        )
        explain(self.report, about, self.warnings)
        self.report.result({"dry_run": True, **about})

    def carry_out(self) -> None:
        """Stream every plane, and report it; ResourceError before any work if something does not fit into memory."""
        workers = Run(self.request.threads).workers
        for name, store in self.stores.items():
            instead = "name a .zarr or a .tif, which need not fit" if store.held else "use fewer --threads"
            check_fits(memory_of(store, workers), f"{self.names[name]}: {self._line()}", instead)
        began = time.perf_counter()
        self._make()
        spent = time.perf_counter() - began
        self.report.warn(*self.warnings)
        self.report.note(f"{', '.join(self.names.values())}: {self._line()}, {spent:.1f} s")
        explain(self.report, self._about(), self.warnings)
        timings = {"read": self.read, "weave": spent, "total": self.read + spent}
        self.report.result(self._about() | {"timings": {k: round(v, 3) for k, v in timings.items()}})

    def _make(self) -> None:
        """Fill the stores of all planes; they are renamed together when all are complete."""
        stores = self.stores.values()
        try:
            with self.report.watching(len(stores)) as meter:
                for store in stores:
                    fill(store, self.request.dask, Run(self.request.threads, meter.stage("weave", 0.0, 1.0), CANCEL))
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

    def _line(self) -> str:
        return f"{self.size[0]}x{self.size[1]} px, {self.texture.method.slug}, seed {self.texture.seed}"

    def _about(self) -> Json:
        """Return the result as JSON, x before y."""
        return {
            "files": [{"path": path, "holds": name} for name, path in self.names.items()],
            "size": list(self.size),
            **({"magnify": times} if (times := self.texture.exemplars[0].times) > 1 else {}),
            "origin": list(self.request.origin),
            "seed": self.texture.seed,
            "wrap": "none",
            **method_as_json(self.texture.method, self.texture.blend),
            "exemplars": recipe_exemplars(self.texture.exemplars),
            **({"auto": self.auto} if self.auto else {}),
        }


def _span(seconds: float) -> str:
    """Return a time in words."""
    for unit, length in (("h", 3600), ("min", 60)):
        if seconds >= 1.5 * length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds:.1f} s"
