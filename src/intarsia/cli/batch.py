"""Batches of outputs: all are planned and checked, then made one after another; ``grow``, ``replay`` and the like."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import click
import numpy as np

from ..disk import check_fits
from ..files import write, write_bytes
from ..files.material_sets import Material
from ..foundation import CancelledError, IntarsiaError, QualityError
from ..foundation.run import Run
from ..methods import Method, keeps_lattice
from ..model.image import Kind, Plane, Transfer, dtype_of
from ..request import FIELDS, Json, Request, inputs_of, repeated, to_line
from ..synthesis import Scene, Synthesis, recipe_exemplars
from ..tasks import made_of
from . import CANCEL, Progress, Report, Step, as_json, describe_error, explain, one_line
from .exemplars import Inputs
from .outputs import Staging, by_file, check_all, index_name, write_page
from .plan import Output, materials_of, method_as_json, orders_of, shelves_of

if TYPE_CHECKING:
    from ..tasks.drawings import Pixels
    from ..tasks.scoring import Outcome

MOST_HEALED = 0.5  # share of a picture: with more, its mask is probably inverted


@dataclass
class Batch:
    """Textures to grow, one after another; mostly one.

    Every material of a folder is grown by itself, atomically, and an error with one stops no other. ``lots``: name of a
    material ("" for none) and orders of the same exemplars. ``index`` is the name of the one report on all outputs, if
    there is one, and ``judged`` its entries.
    """

    request: Request
    report: Report
    materials: list[Material] = field(default_factory=list)
    groups: list[tuple[str, list[Output]]] = field(default_factory=list)
    named: set[str] = field(default_factory=set)
    index: str | None = None
    thumbnails: list[Pixels] = field(default_factory=list)
    judged: list[tuple[Outcome, Pixels]] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)
    results: list[Json] = field(default_factory=list)
    failed: list[Json] = field(default_factory=list)
    made: list[tuple[str, Json, tuple[str, ...]]] = field(default_factory=list)  # not printed yet

    @classmethod
    def plan(cls, request: Request, report: Report, check: Callable[[Scene], None] | None = None) -> Batch:
        """Read and check everything that can be checked; nothing is written yet. `check` may refuse what was read."""
        batch = cls(request, report)
        check_all(filter(None, (request.sheet,)), request.force, batch.named)
        if request.into_folder:
            batch.materials = materials_of(request, report)
        shelves = [] if batch.materials else shelves_of(request, report)
        batch.index = index_name(request, bool(batch.materials) or len(shelves) * len(request.seeds) > 1)
        check_all(filter(None, (batch.index,)), request.force, batch.named)
        for shelf in shelves:
            batch._plan(shelf, "", check)
            if len(shelves) > 1:
                shelf.forget()
        return batch

    def _plan(self, shelf: Inputs, name: str, check: Callable[[Scene], None] | None = None) -> None:
        """Plan the outputs of some exemplars; ResourceError if one does not fit into memory, except on a dry run."""
        request, orders = shelf.request, orders_of(shelf, self.index is None, check)
        if request.verb == "tile" and request.size is None:
            from ..tasks.tileable import remarks

            self.report.warn(*remarks(shelf.scene))
        start = shelf.scene.canvas.start if request.verb == "heal" else None
        if start is not None and (share := float(start.holes.mean())) > MOST_HEALED:
            self.report.warn(f"{share:.0%} of the picture is healed; white is healed: is the mask inverted?")
        check_all((p for order in orders for p, _ in order.files), request.force, self.named, bool(request.folder))
        for order in orders:
            if not request.dry_run:
                check_fits(order.memory, order.line(shelf.plan.method.slug))
        self.groups.append((name, orders))

    def _plan_materials(self, step: Step) -> None:
        """Plan each material; those that cannot be made are reported at once.

        Its planes keep their place relative to the folder. Each material is read again when it is made.
        """
        for number, material in enumerate(self.materials, 1):
            with self._minding(material.name):
                request = replace(
                    self.request, files=tuple(os.fspath(path) for path in material.files), as_set=True, several=False,
                    out=None, folder=os.path.join(self.request.out or "", material.place),
                )  # fmt: skip
                (shelf,) = shelves_of(request, self.report)
                self._plan(shelf, material.name)
                shelf.forget()
            step(number, len(self.materials), None)

    def tell_plan(self) -> None:
        """Report what would be made (a dry run)."""
        self._plan_materials(lambda *_: None)
        for name, orders in self.groups:
            with self._minding(name):
                self.results += map(self._planned, orders)
            orders[0].shelf.forget()
        self._end({"dry_run": True})

    def carry_out(self) -> None:
        """Make everything, and report it."""
        each = len(self.request.seeds)
        parts = 1 + len(self.materials) * each if self.materials else sum(len(orders) for _, orders in self.groups)
        with self.report.watching(parts) as meter, Staging(self.request.force) as whole:
            if self.materials:
                self._plan_materials(meter.stage("check", 0.0, 1.0))
                meter.next_part(1 + each * len(self.failed))
            for name, orders in self.groups:
                left = len(orders)
                with self._minding(name):
                    for order in orders:
                        self._carry_out(order, meter, whole)
                        left -= 1
                        meter.next_part()
                    if name:
                        self._check_missed()
                if left:
                    meter.next_part(left)
                orders[0].shelf.forget()
            if self._refused:
                self._check_missed()
            beside = self._write_beside(whole)
            whole.commit()
        self._tell()
        self._end(beside)

    def _carry_out(self, order: Output, meter: Progress, whole: Staging) -> None:
        """Make an output; with gates or one report on all, files appear together at the end, else one by one."""
        if not self.materials and (self.request.gates or self.index is not None):
            self._make(order, meter, whole)
            return
        with Staging(self.request.force, bool(self.materials)) as staging:
            self._make(order, meter, staging)
            staging.commit()
        self._tell()

    @property
    def _refused(self) -> bool:
        """Whether a gate was missed, so that nothing is written."""
        return bool(self.missed) and not self.request.keep

    def _check_missed(self) -> None:
        """Raise QualityError if a gate was missed."""
        if self.missed:
            said = "all was kept" if self.request.keep else "nothing was written; --keep writes it all the same"
            missed, self.missed = "; ".join(self.missed), []
            raise QualityError(f"{missed}; {said}.")

    @contextmanager
    def _minding(self, name: str) -> Iterator[None]:
        """Report an error with a material in one line, and go on; without a name let it pass."""
        try:
            yield
        except (IntarsiaError, OSError, MemoryError) as e:
            if not name or isinstance(e, (CancelledError, BrokenPipeError)):
                raise
            code, said = describe_error(e)
            self.failed.append({"material": name, "error": said, "exit_code": code})
            self.report.say(one_line(f"intarsia: {name}: {said}"))

    def _end(self, more: Json) -> None:
        """Print the result, and leave with the exit code of the first failure."""
        alone = len(self.results) == 1 and not self.materials
        answer = self.results[0] if alone else {"results": self.results}
        self.report.result(answer | more | ({"failed": self.failed} if self.failed else {}))
        if self.failed:
            names = [str(f["material"]) for f in self.failed]
            of = f"{len(names)} of {len(self.materials)}"
            self.report.say(one_line(f"intarsia: {of} materials failed: {', '.join(names)}"))
            raise click.exceptions.Exit(int(self.failed[0]["exit_code"]))
        self._check_missed()

    def _planned(self, order: Output) -> Json:
        """Print what would be made, and return it as JSON."""
        plan, memory = order.shelf.plan, order.memory >> 20
        self.report.warn(*order.warnings)
        about = self._about(order, None) | {
            "exemplars": recipe_exemplars(plan.scene.exemplars), "patches": plan.patches,
            "pixels_bytes": _bytes(order), "memory_mib": memory,
        }  # fmt: skip
        patches = "" if plan.patches is None else f"{plan.patches} patches, "
        self.report.note(f"{order.line(plan.method.slug)}, {patches}about {memory} MiB; not written (--dry-run)")
        explain(self.report, about, order.warnings)
        return about

    def _make(self, order: Output, meter: Progress, staging: Staging) -> None:
        """Make one output and score it; unless it is refused write its files, to appear when `staging` is committed."""
        began, request, shelf = time.perf_counter(), order.shelf.request, order.shelf
        plan = shelf.plan
        clock = {"read": time.perf_counter() - began}
        grown_at, share = 0.6 if request.repair else 0.9, 0.1 / len(order.pictures)
        run = Run(request.threads, meter.stage("grow", 0.0, grown_at, plan.scene.exemplars), CANCEL)
        grown, seams = made_of(request, plan, order.seed, run), Json()
        if request.repair:
            step = meter.stage("repair", grown_at, 0.9, grown.exemplars)
            grown, seams = self._repaired(grown, replace(run, step=step))
        said = {"inputs": inputs_of(request) or None, "depth": request.depth, **request.said}
        grown = replace(grown, recipe=grown.recipe | {name: value for name, value in said.items() if value is not None})
        self.report.warn(*run.notes)
        clock["grow"] = time.perf_counter() - began - sum(clock.values())
        about = self._about(order, grown) | seams

        def drawn(name: str) -> Plane:
            begin = 0.9 + share * list(order.pictures).index(name)
            return grown.render(name, run=Run(request.threads, meter.stage("render", begin, begin + share), CANCEL))

        base = next(iter(order.pictures))
        first, found = drawn(base), None
        if request.page is not None or request.gates:
            found = self._judged(order, grown, first)
            about |= {"score": found.score.as_dict(), "missed": list(found.missed)}
        if self._refused:
            return
        for path, names in by_file(order.pictures).items():
            planes = {name: first if name == base else drawn(name) for name in names}
            picture = planes if request.layers else planes[names[0]]
            write(staging.place(path), picture, depth=request.depth, recipe=grown.recipe_text, run=run)
        if request.sheet is not None:
            from ..tasks import drawings

            self.thumbnails.append(drawings.thumbnail(first, drawings.THUMBNAIL))
        _write_more(order, grown, staging, found)
        clock["write"] = time.perf_counter() - began - sum(clock.values())
        clock["total"] = time.perf_counter() - began
        about |= {"timings": {k: round(v, 3) for k, v in clock.items()}}
        self.results.append(about)
        line = f"{order.line(about['method'])}{_laid(about)}, {about['timings']['total']:.1f} s"
        self.made.append((line, about, order.warnings))

    def _judged(self, order: Output, grown: Synthesis, drawn: Plane) -> Outcome:
        """Score an output whose base plane is `drawn`, and keep the gates that it misses."""
        from ..tasks import report, scoring

        name = next(iter(order.pictures.values()))
        found = scoring.Outcome.of(grown, name, drawn)
        missed = scoring.misses(found.score, self.request.gates)
        if missed:
            self.missed.append(f"{name} falls short: {', '.join(missed)}")
        found = found.but(command=_again(order, grown.method, grown.recipe["seed"]), missed=missed)
        if self.index is not None and not self._refused:
            self.judged.append(report.thumbnailed(found))
        return found

    def _write_beside(self, staging: Staging) -> Json:
        """Write what shows all outputs, a contact sheet and a report; return their names."""
        written: Json = {}
        if self.request.sheet is not None and self.thumbnails:
            from ..tasks.drawings import contact_sheet

            written["sheet"] = self.request.sheet
            write(staging.place(self.request.sheet), contact_sheet(self.thumbnails))
            self.made.append((f"{self.request.sheet}: contact sheet of {len(self.thumbnails)}", {}, ()))
        if self.index is not None and self.judged:
            written["report"] = self.index
            write_page(staging, self.index, self.judged)
        return written

    def _tell(self) -> None:
        """Print the outputs that are written."""
        for line, about, warnings in self.made:
            self.report.warn(*warnings)
            self.report.note(line)
            explain(self.report, about, warnings)
        self.made = []

    def _about(self, order: Output, grown: Synthesis | None) -> Json:
        """Return a result as JSON, x before y, with how its method was chosen."""
        request, plan = order.shelf.request, order.shelf.plan
        method, seed = (plan.method, order.seed) if grown is None else (grown.method, grown.recipe["seed"])
        files = [{"path": path, "holds": held} for path, held in order.files]
        about = {"files": files, "size": list(order.shelf.size), "seed": order.seed, "wrap": request.wrap_axes}
        about |= method_as_json(method, plan.joined)
        if order.cut_from is not None:
            about["cut_from"] = list(order.cut_from)
        if request.magnify > 1:
            about["magnify"] = request.magnify
        if grown is not None:
            about |= {"exemplars": grown.recipe["exemplars"], "energy": grown.energy}
            if "overlaps" in grown.recipe:
                about["overlaps"] = grown.recipe["overlaps"]
        if plan.choice is None:
            return about
        auto = as_json(plan.choice if grown is None or grown.choice is None else grown.choice, request.explain)
        if grown is not None and grown.trials:
            auto["scores"] = [score.as_dict() for score in grown.trials]
        return about | {"auto": auto | {"command": _again(order, method, seed)}}

    def _repaired(self, grown: Synthesis, run: Run) -> tuple[Synthesis, Json]:
        """Repair the worst seams; return the result, and what JSON reports of the repair."""
        if keeps_lattice(grown.method):  # it was chosen; where it was named, this was refused
            run.notes.append(f"{grown.method.slug} keeps a lattice, which a repair would break: nothing was repaired.")
            return grown, {}
        from ..tasks.repair import repaired_with_statistics

        grown, done = repaired_with_statistics(grown, self.request.repair, run)
        share = done.after / done.before if done.before else 1.0
        said = {"passes": self.request.repair, "patches": done.patches, "seams": round(share, 4)}
        self.report.note(f"repaired with {done.patches} patches: seams cost {100 * share:.0f} % of what they did")
        return grown, {"repair": said}


def _again(order: Output, method: Method, seed: int) -> str:
    """Return the command that makes an output again; one that continued a map is made again from its recipe."""
    request, sets, picture = order.shelf.request, order.shelf.sets, next(iter(order.pictures.values()))
    if request.start is not None:
        kept = {f.name: getattr(request, f.name) for f in FIELDS if f.of_exemplars}
        again = repeated(request, sets[:1], method, seed)
        files = tuple(next(iter(found.values())) for found in sets)
        return to_line(Request(
            "replay", picture=picture, out="again.png", files=files, maps=again.maps, masks=again.masks,
            pictures=again.pictures, start=request.start, **kept,
        ))  # fmt: skip
    more: Json = {
        "several": not request.begun and len(sets) > 1,
        "size": order.shelf.size if request.verb == "grow" else request.size,
        "out": picture,
        "folder": "",
    }
    meant = () if request.begun or request.corrections is not None else order.shelf.plan.joined.finish
    if meant:  # evened out, as it was chosen
        more["even_tone"] = meant[0].radius
    return to_line(repeated(request, sets[:1] if request.begun else sets, method, seed, **more))


def _bytes(order: Output) -> int:
    """Return the bytes of the pixels of an order in the depth that is written."""
    request, exemplar, (width, height) = order.shelf.request, order.shelf.scene.exemplars[0], order.shelf.size
    area, total = exemplar.height * exemplar.width * request.magnify**2, 0
    for plane in filter(None, map(exemplar.picture, order.pictures)):
        deep = plane.pixels.dtype if request.depth is None else np.dtype(dtype_of(request.depth))
        total += plane.height * plane.width * width * height // area * plane.channels * deep.itemsize
    return total


def _write_more(order: Output, grown: Synthesis, staging: Staging, found: Outcome | None) -> None:
    """Write the other files of an output: map, report, preview and the like."""
    from ..tasks import tileable

    request, run = order.shelf.request, Run(order.shelf.request.threads)
    for what, path in order.beside.items():
        if what == "map":
            smap = replace(grown.map, blend=grown.blend)  # so that `intarsia render` draws the same picture
            write_bytes(staging.place(path), smap.to_bytes())
        elif what == "st map":
            # Red and green; blue is 0, so that every program opens it as colour.
            pixels = np.pad(grown.map.st_map(), ((0, 0), (0, 0), (0, 1)))
            write(staging.place(path), Plane(pixels, Kind.DATA, Transfer.LINEAR), run=run)
        elif what == "report" and found is not None:
            write_page(staging, path, found)
        elif what == "preview":
            many = tileable.repeated(grown.render(), grown.map.wrap, request.tiles)
            write(staging.place(path), many, depth=request.depth, run=run)
        elif what == "offset":
            write(staging.place(path), tileable.half_shifted(order.shelf.scene), depth=request.depth, run=run)


def _laid(about: Json) -> str:
    """Return words for the overlaps of patches, if they are larger than the method's."""
    found = about.get("overlaps", {})
    said = {name: about["footprint"][n] - about["pitch"][n] for n, name in enumerate("xy")} if found else {}
    if all(found[name] == [px, px] for name, px in said.items()):
        return ""
    low, high = min(v[0] for v in found.values()), max(v[1] for v in found.values())
    return f", overlaps of {low} px" if low == high else f", overlaps of {low} to {high} px"
