"""The work behind ``-o FOLDER/``: materials one after another, each whole or not at all; none stops the others."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import click

from .. import files
from ..errors import CancelledError, IntarsiaError, ParameterError, printable
from ..files.sets import Material
from ..request.request import Request
from .batch import Batch, write_sheet
from .exemplars import stem_of
from .exits import judge, one_line
from .outputs import FIELDS, Staging, check_all, check_place, filled_name
from .report import Report
from .reporting import Judging, index_name


@dataclass
class Materials:
    """What a folder holds, or several: every material is a batch of its own, and its files keep their names."""

    found: list[Material]
    request: Request
    report: Report
    results: list[dict[str, Any]] = field(default_factory=list)
    failed: list[dict[str, Any]] = field(default_factory=list)
    judged: list[Any] = field(default_factory=list)

    @property
    def index(self) -> str | None:
        """The one report on all outputs, if there is one."""
        return index_name(self.request, True)

    @classmethod
    def plan(cls, request: Request, report: Report) -> Materials:
        """Find the materials; refuse what none of them could be made with."""
        out = request.out or ""
        filled_name(out, dict.fromkeys(FIELDS, ""))  # refuses unknown fields
        _check(request)
        _check_folder(out, request.files)
        beside = [path for path in (request.sheet, index_name(request, True)) if path is not None]
        check_all(beside, request.force, set())
        found = materials_of(request.files, request.how)
        report.note(f"{len(found)} material{'s' * (len(found) > 1)}: {', '.join(m.name for m in found)}")
        if left := left_out(request.files, found):
            report.note(f"left out, as other files there say which plane they are: {', '.join(left)}")
        return cls(found, request, report)

    def tell_plan(self) -> None:
        """Say what would be made of each."""
        named = set[str]()
        for material in self.found:
            with self._minding(material):
                self.results += self._batch(material, self.report, named).plans()
        self._end({"dry_run": True})

    def carry_out(self) -> None:
        """Try whether each can be made, then make one after another; what cannot be is told of at once.

        Each is read again, so that a long batch does not fill memory.
        """
        thumbnails, sound, named = list[Any](), list[Material](), set[str]()
        each = len(self.request.seeds)
        with self.report.watching(1 + len(self.found) * each) as meter:
            step = meter.stage("check", 0.0, 1.0)
            for number, material in enumerate(self.found, 1):
                with self._minding(material):
                    self._batch(material, Report(quiet=True), named)
                    sound.append(material)
                step(number, len(self.found), None)
            meter.next_part(1 + each * (len(self.found) - len(sound)))
            for material in sound:
                before = len(self.results)
                with self._minding(material):
                    batch = self._batch(material, self.report, set())
                    batch.sheet, batch.thumbnails = self.request.sheet, thumbnails
                    for order in batch.orders:
                        batch.check_memory(order)
                        about = batch.make(order, meter)
                        self.results += [] if batch.judging.refused else [about]
                        meter.next_part()
                    batch.judging.check()
                meter.next_part(before + each - len(self.results))
        sheet: dict[str, Any] = {}
        if self.request.sheet is not None and thumbnails:
            write_sheet(self.request.sheet, thumbnails, self.request.force, self.report)
            sheet = {"sheet": self.request.sheet}
        if self.index is not None and self.judged:
            with Staging(self.request.force) as staging:
                Judging(self.request, self.index, self.judged).write_index(staging)
                staging.commit()
            sheet["report"] = self.index
        self._end(sheet)

    def _batch(self, material: Material, report: Report, named: set[str]) -> Batch:
        """The plan for one material; its planes go to the place in the folder that they have in their own."""
        request = replace(
            self.request, files=tuple(os.fspath(path) for path in material.files), as_set=True, several=False,
            out=None, folder=os.path.join(self.request.out or "", material.place),
            page=None if self.index is not None else self.request.page,
        )  # fmt: skip
        batch = Batch.plan(request, report, named=named)
        batch.judging.index, batch.judging.found = self.index, self.judged
        return batch

    @contextmanager
    def _minding(self, material: Material) -> Iterator[None]:
        """Tell in a line what goes wrong with a material, and go on."""
        try:
            yield
        except (CancelledError, BrokenPipeError):
            raise
        except (IntarsiaError, OSError, MemoryError) as e:
            code, said = judge(e)
            self.failed.append({"material": material.name, "error": said, "exit_code": code})
            self.report.say(one_line(f"intarsia: {material.name}: {said}"))

    def _end(self, more: dict[str, Any]) -> None:
        """Print the result, and leave with the exit code of the first failure."""
        failed = {"failed": self.failed} if self.failed else {}
        self.report.result({**more, "results": self.results, **failed})
        if self.failed:
            names = [str(f["material"]) for f in self.failed]
            of = f"{len(names)} of {len(self.found)}"
            self.report.say(one_line(f"intarsia: {of} materials failed: {', '.join(names)}"))
            raise click.exceptions.Exit(int(self.failed[0]["exit_code"]))


def materials_of(paths: tuple[str, ...], how: str) -> list[Material]:
    """Return the materials of folders, and of files that are named beside them."""
    loose = [path for path in paths if not os.path.isdir(path)]
    found = [m for path in paths if os.path.isdir(path) for m in files.materials(path, how)]
    for one in files.group(loose, how):
        known = {name: os.fspath(path) for name, path in one.items()}
        found.append(Material(stem_of(known), "", list(one.values())))
    return found


def left_out(paths: tuple[str, ...], found: list[Material]) -> list[str]:
    """Name the pictures of folders that are in no material."""
    used = {os.fspath(path) for material in found for path in material.files}
    every = [os.fspath(f) for p in paths if os.path.isdir(p) for m in files.materials(p, "several") for f in m.files]
    return [printable(path) for path in every if path not in used]


def _check(request: Request) -> None:
    """Refuse what can be said of one exemplar only."""
    masks = "--usable" if request.holes else "--mask"
    for option, given in (("--map", request.maps), (masks, request.masks)):
        if given:
            raise ParameterError(f"{option} names a file of one material; with -o FOLDER/ put it beside its planes.")
    if request.as_set:
        raise ParameterError("--set does not go with -o FOLDER/; the names of files and folders tell what is a set.")
    if len(request.holes) > 1:
        raise ParameterError("--mask: one hole can be given for a folder, which then goes for all of its pictures.")
    if "-" in request.read:
        raise ParameterError("the standard input (-) can be read once; name files where -o is a folder.")


def _check_folder(out: str, sources: tuple[str, ...]) -> None:
    """Refuse a folder that cannot be made, and one that is read: the next run would take results for materials."""
    inner = os.path.realpath(out)
    if os.path.dirname(inner) == inner:
        raise ParameterError(f"-o {printable(out)} is the root of all folders; name a folder in it.")
    for folder in filter(os.path.isdir, sources):
        if os.path.commonpath([inner, outer := os.path.realpath(folder)]) == outer:
            raise ParameterError(f"-o {printable(out)} lies in {printable(folder)}, which is read; name another place.")
    if "{" not in out:
        check_place(os.path.join(out, "o"), True, True)
