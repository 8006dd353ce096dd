"""What ``--report`` and ``--gate`` ask for: outputs judged, told of on pages, and refused where they fall short."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ..errors import ParameterError, QualityError
from ..files import write, write_bytes
from ..lazy import lazy
from ..request.request import Request
from .outputs import FIELDS, Staging

if TYPE_CHECKING:
    from ..image import Plane
    from ..synthesis import Synthesis
    from ..tasks import report, scoring
else:  # only --report and --gate need them
    report, scoring = lazy("intarsia.tasks.report"), lazy("intarsia.tasks.scoring")

LIBRARIES, EACH = 64 << 20, 80
"""Bytes that judging an output and drawing its report take at all, and for each of its pixels."""


def index_name(request: Request, many: bool) -> str | None:
    """Return the name of the one report on several outputs; None where each has its own, or none is asked for."""
    page = request.page
    if page is None or not many or "{stem}" in page or "{seed}" in page:
        return None
    if any("{" + name + "}" in page for name in FIELDS):
        raise ParameterError(
            f"--report {page}: it tells of several outputs; put {{stem}} or {{seed}} into its name, or no field."
        )
    return page


def memory_of(size: tuple[int, int]) -> int:
    """Bytes that judging an output of this size takes, and drawing its report."""
    return LIBRARIES + EACH * size[0] * size[1]


@dataclass
class Judging:
    """The outputs of a batch, judged one after another; `index` is the one report on all of them."""

    request: Request
    index: str | None = None
    found: list[Any] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)

    @property
    def wanted(self) -> bool:
        """Whether anything is to be judged."""
        return self.request.page is not None or self.index is not None or bool(self.request.gates)

    @property
    def together(self) -> bool:
        """Whether all outputs appear together or not at all: what one misses keeps the others from being written."""
        return bool(self.request.gates) or self.index is not None

    @property
    def refused(self) -> bool:
        """Whether nothing is to be written."""
        return bool(self.missed) and not self.request.keep

    def of(self, made: Synthesis, name: str, drawn: Plane, command: str) -> scoring.Outcome:
        """Judge an output whose base plane is `drawn`, and remember what it misses."""
        found = scoring.Outcome.of(made, name, drawn)
        missed = scoring.misses(found.score, self.request.gates)
        if missed:
            self.missed.append(f"{name} falls short: {', '.join(missed)}")
        found = found.but(command=command, missed=missed)
        if self.index is not None and not self.refused:
            self.found.append(report.thumbnailed(found))
        return found

    def write_index(self, staging: Staging) -> None:
        """Write the report on all outputs, if there is one."""
        if self.index is None:
            return
        if self.index.lower().endswith(".png"):
            write(staging.place(self.index), report.index_sheet(self.found))
        else:
            write_bytes(staging.place(self.index), report.index_of(self.found).encode("utf-8", "replace"))

    def check(self) -> None:
        """Raise QualityError where a gate was missed."""
        if self.missed:
            said = "all was kept" if self.request.keep else "nothing was written; --keep writes it all the same"
            raise QualityError(f"{'; '.join(self.missed)}; {said}.")


def write_page(staging: Staging, path: str, found: scoring.Outcome) -> None:
    """Write the report on one output."""
    if path.lower().endswith(".png"):
        write(staging.place(path), report.sheet_of(found))
    else:
        write_bytes(staging.place(path), report.page_of(found).encode("utf-8", "replace"))
