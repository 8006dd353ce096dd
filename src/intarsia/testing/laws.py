"""What all laws share: the method, the requests that it is tested on, and what a subclass may replace."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, TypeVar

from hypothesis import HealthCheck, given, settings
from hypothesis.strategies import SearchStrategy

from ..canvas import Canvas
from ..exemplar import Exemplar
from ..geometry import Box
from ..methods.base import Ability, Method
from ..params import extent
from ..run import Run
from ..sourcemap import SourceMap
from .cases import Case, cases, chosen

L = TypeVar("L", bound=Callable[..., None])


def of_those_that_claim(*abilities: Ability) -> Callable[[L], L]:
    """Make a law one of methods that claim these abilities: for others there is no such test."""

    def mark(law: L) -> L:
        law.__dict__["abilities"] = frozenset(abilities)
        return law

    return mark


class Laws:
    """A method under test.

    Attributes
    ----------
    method : Method
        With parameters that suit exemplars of 20 px a side; a patch of about 12.
    examples : int
        How many requests hypothesis draws for each law.
    least : int
        Shortest side, px, of the exemplars drawn.
    few : bool
        Whether the laws are tested on two of four chosen requests, the first on all, at a few steps, in place of what
        hypothesis draws.
    """

    method: ClassVar[Method]
    examples: ClassVar[int] = 10
    least: ClassVar[int] = 20
    few: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        """Leave out the laws of abilities that the method does not claim."""
        super().__init_subclass__()
        if not hasattr(cls, "method"):
            return
        laws = {n: law for base in reversed(cls.__mro__) for n, law in vars(base).items() if hasattr(law, "abilities")}
        for name, law in laws.items():
            if getattr(cls, name) in (law, None):
                setattr(cls, name, law if law.abilities <= cls.method.supports else None)

    def cases(self) -> SearchStrategy[Case]:
        """Return the requests on which the laws are tested."""
        return (chosen if self.few else cases)(self.method, least=self.least)

    def rim(self, exemplars: Sequence[Exemplar], size: tuple[int, int]) -> int:
        """Return how deep, in px, a start map may be changed: the method's overlap or border, 0 if it has none."""
        resolved = self.method.resolved(exemplars, Canvas(*size))
        return max(extent(getattr(resolved, "overlap", getattr(resolved, "border", 0))))

    def map_of_window(self, case: Case, box: Box) -> SourceMap:
        """Compute the map of a window of the endless plane, alone."""
        method: Any = self.method
        smap: SourceMap = method.window(case.exemplars, box, case.seed, Run(1))
        return smap

    def for_all(self, law: Callable[[Case], None], examples: int | None = None) -> None:
        """Test a law on requests that hypothesis draws, or on chosen ones."""

        @settings(
            max_examples=max(examples or self.examples, 10) // 5 if self.few else examples or self.examples,
            deadline=None,
            derandomize=True,
            database=None,
            suppress_health_check=[HealthCheck.too_slow],
        )
        @given(self.cases())
        def check(case: Case) -> None:
            law(case)

        check()
