"""The work behind ``grow`` and ``replay``: plan everything, refuse what cannot work, then make one after another."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..disk.depth import dtype_of
from ..disk.limits import check_fits
from ..files import write, write_bytes
from ..image import Kind, Plane, Transfer
from ..lazy import lazy
from ..methods.base import Method, keeps_lattice
from ..request.argv import once_more, to_line
from ..request.recipe import inputs_of
from ..request.request import FIELDS, Request
from ..run import Probe, Run
from ..sourcemap import SourceMap
from ..synthesis import Scene, Synthesis, carry_out, recipe_exemplars
from .choosing import as_json, explain
from .exemplars import Shelf, donors_of, sets_of
from .exits import CANCEL
from .outputs import Staging, by_file, check_all
from .plan import Order, check_begin, method_as_json, orders_of, scene_of
from .report import Meter, Report
from .reporting import Judging, index_name, memory_of, write_page

if TYPE_CHECKING:
    from ..search import distance_map
    from ..tasks import completion, drawings, repair, tileable
else:  # only --distance-map, holes, --sheet, --repair and tiling need them
    distance_map, repair = lazy("intarsia.search.distance_map"), lazy("intarsia.tasks.repair")
    completion, tileable = lazy("intarsia.tasks.completion"), lazy("intarsia.tasks.tileable")
    drawings = lazy("intarsia.tasks.drawings")


@dataclass
class Batch:
    """Textures to grow, one after another; mostly one."""

    shelf: Shelf
    report: Report
    orders: list[Order] = field(default_factory=list)
    named: set[str] = field(default_factory=set)
    sheet: str | None = None
    thumbnails: list[drawings.Pixels] = field(default_factory=list)
    judging: Judging = field(init=False)

    def __post_init__(self) -> None:
        self.judging = Judging(self.request)

    @property
    def request(self) -> Request:
        """What was asked for."""
        return self.shelf.request

    @classmethod
    def plan(
        cls, request: Request, report: Report, check: Callable[[Scene], None] | None = None,
        named: set[str] | None = None,
    ) -> Batch:  # fmt: skip
        """Read and check everything that can be checked; nothing is written yet. `check` may refuse what was read.

        `named` remembers the places of all files, also for batches that come after.
        """
        sets = sets_of(request, report)
        each = "{stem}" in (request.out or "") or (not request.out and request.begun)
        lots = [[found] for found in sets] if each else [sets]
        check_begin(request, lots, sets)
        donors, index = donors_of(request), index_name(request, len(lots) * len(request.seeds) > 1)
        shelf = Shelf([lot + donors for lot in lots], request if index is None else replace(request, page=None), report)
        batch = cls(shelf, report, named=set() if named is None else named)
        batch.judging.index = index
        if index is not None:
            check_all([index], request.force, batch.named)
        for lot in range(len(shelf.lots)):
            found = orders_of(shelf, lot, check)
            if request.verb == "tile" and request.size is None:
                shelf.warn(*tileable.remarks(scene_of(shelf, lot)))
            if batch.judging.wanted:
                found = [replace(o, memory=o.memory + memory_of(o.size)) for o in found]
            check_all((p for order in found for p, _ in order.files), request.force, batch.named, bool(request.folder))
            batch.orders += found
        return batch

    def add_sheet(self, path: str) -> None:
        """Ask for a contact sheet as well."""
        check_all([path], self.request.force, self.named)
        self.sheet = path

    def tell_plan(self) -> None:
        """Say what would be made."""
        as_json = self.plans()
        self.report.result({"dry_run": True, **(as_json[0] if len(as_json) == 1 else {"results": as_json})})

    def plans(self) -> list[dict[str, Any]]:
        """Tell a person what would be made, and return what JSON says of it."""
        as_json = []
        for order in self.orders:
            self.shelf.warn(*order.warnings)
            about = self._about(order, None) | {
                "exemplars": recipe_exemplars(scene_of(self.shelf, order.lot, order.guide).exemplars),
                "patches": order.patches,
                "pixels_bytes": self._bytes(order),
                "memory_mib": order.memory >> 20,
            }
            as_json.append(about)
            patches = "" if about["patches"] is None else f"{about['patches']} patches, "
            self.report.note(f"{order.line}, {patches}about {about['memory_mib']} MiB; not written (--dry-run)")
            explain(self.report, about, order.warnings)
        return as_json

    def carry_out(self) -> None:
        """Make everything, and report it; what cannot fit into memory is refused before anything is made."""
        for order in self.orders:
            self.check_memory(order)
        results = []
        with self.report.watching(len(self.orders)) as meter, Staging(self.request.force) as whole:
            for order in self.orders:
                if self.judging.together:
                    results.append(self._make(order, meter, whole))
                else:
                    results.append(self.make(order, meter))
                meter.next_part()
            if self.judging.refused:
                self.judging.check()
            self.judging.write_index(whole)
            whole.commit()
        if self.judging.together:
            for order, about in zip(self.orders, results, strict=True):
                self._tell(order, about)
        if self.sheet is not None:
            write_sheet(self.sheet, self.thumbnails, self.request.force, self.report)
        together: dict[str, Any] = results[0] if len(results) == 1 else {"results": results}
        beside = {"sheet": self.sheet, "report": self.judging.index}
        self.report.result(together | {what: path for what, path in beside.items() if path is not None})
        self.judging.check()

    def check_memory(self, order: Order) -> None:
        """Refuse what cannot fit into memory."""
        check_fits(order.memory, order.line)

    def make(self, order: Order, meter: Meter) -> dict[str, Any]:
        """Grow, draw and write one order: all of its files, or none; return what JSON says of it."""
        with Staging(self.request.force, bool(self.request.folder)) as staging:
            about = self._make(order, meter, staging)
            staging.commit()
        if not self.judging.refused:
            self._tell(order, about)
        return about

    def _make(self, order: Order, meter: Meter, staging: Staging) -> dict[str, Any]:
        """Make one output and write its files, to appear when `staging` is committed; return what JSON says of it."""
        began, threads = time.perf_counter(), self.request.threads
        scene = scene_of(self.shelf, order.lot, order.guide)
        clock = {"read": time.perf_counter() - began}
        asked = self.request.distance_map
        probe = None if asked is None else Probe(asked[0][1] // order.times, asked[0][0] // order.times)
        grown_at = 0.6 if self.request.repair else 0.9
        run = Run(threads, meter.stage("grow", 0.0, grown_at, scene.exemplars), CANCEL, probe=probe)
        grown, seams = self._grow(order, scene, run), dict[str, Any]()
        if self.request.repair:
            step = meter.stage("repair", grown_at, 0.9, scene.exemplars)
            grown, seams = self._repaired(grown, replace(run, step=step))
        for note in run.notes:
            self.report.warn(note)
        clock["grow"] = time.perf_counter() - began - sum(clock.values())
        about = self._about(order, grown) | seams

        def drawing(begin: float, end: float) -> Run:
            return Run(threads, meter.stage("render", begin, end), CANCEL)

        self._write(order, grown, drawing, staging, about)
        if order.distance_map is not None and probe is not None and probe.maps is not None:
            write(staging.place(order.distance_map), distance_plane(probe.maps, order.distance_map))
        if not self.judging.refused:
            self._write_tiled(order, scene, grown, staging)
        clock["write"] = time.perf_counter() - began - sum(clock.values())
        clock["total"] = time.perf_counter() - began
        return about | {"timings": {k: round(v, 3) for k, v in clock.items()}}

    def _write(
        self, order: Order, grown: Synthesis, drawing: Callable[[float, float], Run], staging: Staging,
        about: dict[str, Any],
    ) -> None:  # fmt: skip
        """Judge what was grown, if that is asked for, and write its files unless it is refused."""
        base, found, share = next(iter(order.pictures)), None, 0.1 / len(order.pictures)
        first = grown.render(base, run=drawing(0.9, 0.9 + share))
        if self.judging.wanted:
            again = self._again(order, grown.method, grown.recipe["seed"])
            found = self.judging.of(grown, order.pictures[base], first, again)
            about |= {"score": found.score.as_dict(), "missed": list(found.missed)}
            if self.judging.refused:
                return
        begin = 0.9
        for path, names in by_file(order.pictures).items():
            planes = {}
            for name in names:
                planes[name] = first if name == base else grown.render(name, run=drawing(begin, begin + share))
                begin += share
            picture = planes if self.request.layers else planes[names[0]]
            write(staging.place(path), picture, depth=self.request.depth, recipe=grown.recipe_text)
        if self.sheet is not None:
            self.thumbnails.append(drawings.looked(first, drawings.THUMBNAIL))
        if order.save_map is not None:
            smap = replace(grown.map, blend=grown.blend)  # so that `intarsia render` draws the same picture
            write_bytes(staging.place(order.save_map), smap.to_bytes())
        if order.st_map is not None:
            write(staging.place(order.st_map), _st_plane(grown.map))
        if order.page is not None and found is not None:
            write_page(staging, order.page, found)

    def _tell(self, order: Order, about: dict[str, Any]) -> None:
        """Say that an output is there."""
        self.shelf.warn(*order.warnings)
        self.report.note(f"{order.made_by(about['method'])}{_laid(about)}, {about['timings']['total']:.1f} s")
        explain(self.report, about, order.warnings)

    def _again(self, order: Order, method: Method, seed: int) -> str:
        """The command that makes an output again; a map that was continued is known to its recipe alone."""
        request, picture = self.request, next(iter(order.pictures.values()))
        if request.start is not None:
            kept = {f.name: getattr(request, f.name) for f in FIELDS if f.of_exemplars}
            again = once_more(request, order.sets[:1], method, seed)
            files = tuple(next(iter(found.values())) for found in order.sets)
            return to_line(Request(
                "replay", picture=picture, out="again.png", files=files, maps=again.maps, masks=again.masks,
                pictures=again.pictures, start=request.start, **kept,
            ))  # fmt: skip
        labels, holes = request.labels, request.holes
        more: dict[str, Any] = {
            "several": not request.begun and len(order.sets) > 1,
            "labels": labels if len(labels) == len(order.sets) else labels[order.lot : order.lot + 1],
            "holes": holes[order.lot :][:1] if len(holes) > 1 else holes,
            "size": order.size if request.verb == "grow" else request.size,
            "out": picture,
            "folder": "",
        }
        meant = () if request.begun or request.finishing is not None else order.blend.finish
        if meant:  # evened out, as it was chosen
            more["level"] = meant[0].radius
        sets = order.sets[:1] if request.begun else order.sets
        return to_line(once_more(request, sets, method, seed, **more))

    def _about(self, order: Order, grown: Synthesis | None) -> dict[str, Any]:
        """What JSON says of a result, x before y, and of how its method was chosen."""
        files = [{"path": path, "holds": held} for path, held in order.files]
        about = {"files": files, "size": list(order.size), "seed": order.seed, "wrap": self.request.closing}
        about |= method_as_json(order.method if grown is None else grown.method, order.blend)
        if order.cut_from is not None:
            about["cut_from"] = list(order.cut_from)
        if order.times > 1:
            about["magnify"] = order.times
        if grown is not None:
            about |= {"exemplars": grown.recipe["exemplars"], "energy": grown.energy}
            about |= {name: grown.recipe[name] for name in ("overlaps",) if name in grown.recipe}
        if order.choice is None:
            return about
        choice = order.choice if grown is None or grown.choice is None else grown.choice
        auto = as_json(choice, self.request.explain)
        if grown is not None and grown.trials:
            auto["scores"] = [score.as_dict() for score in grown.trials]
        if grown is not None and grown.energies:
            auto["energies"] = list(grown.energies)
        method, seed = (order.method, order.seed) if grown is None else (grown.method, grown.recipe["seed"])
        auto["command"] = self._again(order, method, seed)
        return about | {"auto": auto}

    def _bytes(self, order: Order) -> int:
        """How many bytes the pixels of an order take, as they are written."""
        exemplar = self.shelf.get(order.lot)[0]
        area, total = exemplar.height * exemplar.width * order.times**2, 0
        for plane in filter(None, map(exemplar.picture, order.pictures)):
            deep = plane.pixels.dtype if self.request.depth is None else np.dtype(dtype_of(self.request.depth))
            total += plane.height * plane.width * order.size[0] * order.size[1] // area * plane.channels * deep.itemsize
        return total

    def _grow(self, order: Order, scene: Scene, run: Run) -> Synthesis:
        plan = order.plan(scene)
        if self.request.verb == "tile":
            grown = tileable.tiled(plan, order.seed, run)
        elif self.request.verb == "heal":
            grown = completion.fill_holes(plan, order.seed, run, self.request.edge)
        else:
            grown = carry_out(plan, order.seed, run)
        more: dict[str, Any] = dict(self.request.said)
        if said := inputs_of(self.request):
            more["inputs"] = said
        if self.request.depth is not None:
            more["depth"] = self.request.depth
        return replace(grown, recipe=grown.recipe | more)

    def _repaired(self, grown: Synthesis, run: Run) -> tuple[Synthesis, dict[str, Any]]:
        """Cover the worst seams; what JSON says of it."""
        if keeps_lattice(grown.method):  # it was chosen; where it was named, this was refused
            run.notes.append(f"{grown.method.slug} keeps a lattice, which a repair would break: nothing was repaired.")
            return grown, {}
        grown, done = repair.mended(grown, self.request.repair, run)
        share = done.after / done.before if done.before else 1.0
        said = {"passes": self.request.repair, "patches": done.patches, "seams": round(share, 4)}
        self.report.note(f"repaired with {done.patches} patches: seams cost {100 * share:.0f} % of what they did")
        return grown, {"repair": said}

    def _write_tiled(self, order: Order, scene: Scene, grown: Synthesis, staging: Staging) -> None:
        """Write the result side by side with itself, and the picture as it was, moved by half its size."""
        depth, axes = self.request.depth, scene.canvas.wrap
        if order.preview is not None:
            many = tileable.repeated(grown.render(), axes, self.request.tiles)
            write(staging.place(order.preview), many, depth=depth)
        if order.offset is not None:
            write(staging.place(order.offset), tileable.half_shifted(scene), depth=depth)


def _laid(about: dict[str, Any]) -> str:
    """What patches really share, where it is more than was said."""
    found = about.get("overlaps", {})
    said = {name: about["footprint"][n] - about["pitch"][n] for n, name in enumerate("xy")} if found else {}
    if all(found[name] == [px, px] for name, px in said.items()):
        return ""
    low, high = min(v[0] for v in found.values()), max(v[1] for v in found.values())
    return f", overlaps of {low} px" if low == high else f", overlaps of {low} to {high} px"


def write_sheet(path: str, thumbnails: list[drawings.Pixels], force: bool, report: Report) -> None:
    """Write a contact sheet, and tell of it."""
    with Staging(force) as staging:
        write(staging.place(path), drawings.contact_sheet(thumbnails))
        staging.commit()
    report.note(f"{path}: contact sheet of {len(thumbnails)}")


def _st_plane(smap: SourceMap) -> Plane:
    """An ST map as red and green; blue is 0, so that every program opens it as colour."""
    st = smap.st_map()
    return Plane(np.dstack([st, np.zeros(st.shape[:2], np.float32)]), Kind.DATA, Transfer.LINEAR)


def distance_plane(maps: list[Any], path: str) -> Plane:
    """Distances as a picture: as they are, or stretched to 16 bits where the format holds no others."""
    whole = distance_map.side_by_side(maps)
    pixels = distance_map.as_16_bit(whole) if path.lower().endswith(".png") else whole
    return Plane(pixels, Kind.DATA, Transfer.LINEAR)
