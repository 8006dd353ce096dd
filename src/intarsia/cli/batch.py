"""Batches of outputs: all are planned and checked, then made one after another; ``grow``, ``replay`` and the like."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import click

from ..disk import check_fits
from ..files import write, write_bytes
from ..files.material_sets import Material
from ..foundation import CancelledError, IntarsiaError, ParameterError
from ..foundation.run import Run
from ..methods import Method, keeps_lattice
from ..model.image import Plane
from ..request import Json, Request, inputs_of, repeated, to_line
from ..synthesis import Scene, Synthesis, recipe_exemplars
from ..tasks import made_of
from . import CANCEL, Progress, Report, Step, as_json, callers, describe_error, explain, one_line
from .exemplars import Inputs
from .outputs import Staging, check_all, write_page
from .plan import PREVIEWED, Output, materials_of, method_as_json, orders_of, shelves_of

if TYPE_CHECKING:
    from ..tasks.drawings import Pixels
    from ..tasks.scoring import Outcome

MOST_HEALED = 0.5  # share of a picture: with more, its mask is probably inverted


@dataclass
class Batch:
    """Textures to grow, one after another; mostly one.

    Every material of a folder is grown by itself, atomically, and an error with one stops no other. ``lots``: name of a
    material ("" for none) and orders of the same exemplars. ``thumbnails``: what the contact sheet shows.
    """

    request: Request
    report: Report
    materials: list[Material] = field(default_factory=list)
    groups: list[tuple[str, list[Output]]] = field(default_factory=list)
    named: set[str] = field(default_factory=set)
    thumbnails: list[Pixels] = field(default_factory=list)
    results: list[Json] = field(default_factory=list)
    failed: list[Json] = field(default_factory=list)

    @classmethod
    def plan(cls, request: Request, report: Report, check: Callable[[Scene], None] | None = None) -> Batch:
        """Read and check everything that can be checked; nothing is written yet. `check` may refuse what was read."""
        batch = cls(request, report)
        check_all(filter(None, (request.sheet,)), request.force, batch.named)
        if request.into_folder:
            batch.materials = materials_of(request, report)
            if request.page is not None and len(batch.materials) > 1 and "{stem}" not in request.page:
                raise ParameterError(f"--report {request.page}: it tells of one material; put {{stem}} into its name.")
        shelves = [] if batch.materials else shelves_of(request, report)
        for shelf in shelves:
            batch._plan(shelf, "", check)
            if len(shelves) > 1:
                shelf.forget()
        return batch

    def _plan(self, shelf: Inputs, name: str, check: Callable[[Scene], None] | None = None) -> None:
        """Plan the outputs of some exemplars; ResourceError if one does not fit into memory, except on a dry run."""
        request, orders = shelf.request, orders_of(shelf, check)
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
        with self.report.watching(parts) as meter:
            if self.materials:
                self._plan_materials(meter.stage("check", 0.0, 1.0))
                meter.next_part(1 + each * len(self.failed))
            for name, orders in self.groups:
                left = len(orders)
                with self._minding(name):
                    for order in orders:
                        self._make(order, meter)
                        left -= 1
                        meter.next_part()
                if left:
                    meter.next_part(left)
                orders[0].shelf.forget()
            sheet = self._write_sheet()
        self._end(sheet)

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
            names, code = [str(f["material"]) for f in self.failed], int(self.failed[0]["exit_code"])
            of = f"{len(names)} of {len(self.materials)}"
            callers.say_error(one_line(f"{of} materials failed: {', '.join(names)}"), "materials", code)
            raise click.exceptions.Exit(code)

    def _planned(self, order: Output) -> Json:
        """Print what would be made, and return it as JSON."""
        plan, memory = order.shelf.plan, order.memory >> 20
        self.report.warn(*order.warnings)
        about = self._about(order, None) | {
            "exemplars": recipe_exemplars(plan.scene.exemplars), "memory_mib": memory,
        }  # fmt: skip
        self.report.note(f"{order.line(plan.method.slug)}, about {memory} MiB; not written (--dry-run)")
        explain(self.report, about, order.warnings)
        return about

    def _make(self, order: Output, meter: Progress) -> None:
        """Make one output, write its files, which appear together, and report it."""
        began, request, shelf = time.perf_counter(), order.shelf.request, order.shelf
        plan = shelf.plan
        grown_at, share = 0.6 if request.repair else 0.9, 0.1 / len(order.pictures)
        run = Run(request.threads, meter.stage("grow", 0.0, grown_at, plan.scene.exemplars), CANCEL)
        grown, seams = made_of(request, plan, order.seed, run), Json()
        if request.repair:
            step = meter.stage("repair", grown_at, 0.9, grown.exemplars)
            grown, seams = self._repaired(grown, replace(run, step=step))
        said = {"inputs": inputs_of(request) or None, "depth": request.depth, **request.said}
        grown = replace(grown, recipe=grown.recipe | {name: value for name, value in said.items() if value is not None})
        self.report.warn(*run.notes)
        about = self._about(order, grown) | seams

        def drawn(name: str) -> Plane:
            begin = 0.9 + share * list(order.pictures).index(name)
            return grown.render(name, run=Run(request.threads, meter.stage("render", begin, begin + share), CANCEL))

        base = next(iter(order.pictures))
        first, found = drawn(base), None
        if request.page is not None:
            from ..tasks.scoring import Outcome

            found = Outcome.of(grown, order.pictures[base], first)
            found = found.but(command=_again(order, grown.method, grown.recipe["seed"]))
            about |= {"score": found.score.as_dict()}
        if request.sheet is not None:
            from ..tasks import drawings

            self.thumbnails.append(drawings.thumbnail(first, drawings.THUMBNAIL))
        with Staging(request.force, bool(self.materials)) as staging:
            for path, picture in self._written(order, lambda name: first if name == base else drawn(name), about):
                write(staging.place(path), picture, depth=request.depth, recipe=grown.recipe_text, run=run)
            _write_more(order, grown, staging, found)
            staging.commit()
        seconds = time.perf_counter() - began
        about |= {"timings": {"total": round(seconds, 3)}}
        self.results.append(about)
        self.report.warn(*order.warnings)
        self.report.note(f"{order.line(about['method'])}, {seconds:.1f} s")
        explain(self.report, about, order.warnings)

    def _written(self, order: Output, draw: Callable[[str], Plane], about: Json) -> Iterator[tuple[str, Plane]]:
        """Yield the pictures of an output by file, or what its engine reads of them, which `about` then tells."""
        if not order.exported:
            yield from ((path, draw(name)) for name, path in order.pictures.items())
            return
        made, about["told"] = order.for_engine({name: draw(name) for name in order.pictures})
        yield from made.items()
        for line in about["told"]:
            self.report.note(line)

    def _write_sheet(self) -> Json:
        """Write the contact sheet of all outputs, if one is asked for; return its name."""
        if self.request.sheet is None or not self.thumbnails:
            return {}
        from ..tasks.drawings import contact_sheet

        with Staging(self.request.force) as staging:
            write(staging.place(self.request.sheet), contact_sheet(self.thumbnails))
            staging.commit()
        self.report.note(f"{self.request.sheet}: contact sheet of {len(self.thumbnails)}")
        return {"sheet": self.request.sheet}

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
    """Return the command that makes an output again; empty for one that continues a map: its recipe does."""
    request, sets, picture = order.shelf.request, order.shelf.sets, next(iter(order.pictures.values()))
    if request.start is not None:
        return ""
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


def _write_more(order: Output, grown: Synthesis, staging: Staging, found: Outcome | None) -> None:
    """Write the other files of an output: map, report, preview and the like."""
    from ..tasks import tileable

    request, run = order.shelf.request, Run(order.shelf.request.threads)
    for what, path in order.beside.items():
        if what == "map":
            smap = replace(grown.map, blend=grown.blend)  # so that `intarsia render` draws the same picture
            write_bytes(staging.place(path), smap.to_bytes())
        elif what == "report" and found is not None:
            write_page(staging, path, found)
        elif what == "preview":
            many = tileable.repeated(grown.render(), grown.map.wrap, PREVIEWED)
            write(staging.place(path), many, depth=request.depth, run=run)
