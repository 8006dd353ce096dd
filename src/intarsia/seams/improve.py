"""The loop that lays patches: in waves of windows that lie apart, by which empty ones are filled and bad ones improved.

The windows of a wave are searched and cut by the map as it was before; what was cut is then laid in turn, where it
still pays after what the wave laid before. So threads share a wave, and change no byte.

A patch is cut in with old seams remembered, so it may replace what lies around its window as well (Kwatra, Schoedl,
Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003, sections 3 and 4). Departure: there one patch follows
another, each chosen by what all before it show; here only repeats of the same wave are not seen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from ..foundation.run import Run, draw
from ..patches import Window, waves
from ..search import Candidates
from .graphcut import Box, Cut, GraphcutGrowth, middle
from .worst import WorstSeams

AT_ONCE = 64  # windows of a wave that are searched for and cut before progress is told; what they hold is dropped then
ROUNDS = 8  # in which the worst seams are covered anew: with more, waves are short


class Pass(Protocol):
    """What is done to the sites of a map, each of which a key names."""

    def found(self, sites: list[Any], run: Run) -> Sequence[Any]:
        """What may be laid at sites that lie apart, by the map as it is."""

    def best(self, site: Any, found: Any) -> Cut | None:
        """The best of that, cut in, where it pays; it may be asked by several threads."""

    def pays(self, cut: Cut) -> bool:
        """Whether a cut still pays after what the wave has laid before it."""

    def lay(self, cut: Cut) -> Box:
        """Write it into the map; returns where seams must be measured anew."""

    def measured(self, box: Box) -> None:
        """Measure the seams of a box anew; it may be asked by several threads."""

    def give_up(self, key: Any) -> None:
        """Leave a site at which nothing pays."""


def improve(work: Pass, wave: Mapping[Any, Any], run: Run, tick: Callable[[int], None]) -> list[Cut]:
    """Lay what pays at the sites of a wave, by their keys; returns what was laid. `tick` is told how many are done."""
    sites, cuts, laid, changed = list(wave.values()), list[Cut | None](), list[Cut](), list[Box]()
    for begin in range(0, len(sites), AT_ONCE):
        tick(begin)
        some = sites[begin : begin + AT_ONCE]
        found = work.found(some, run)
        with run.pool() as each:
            cuts += each(lambda pair: work.best(*pair), zip(some, found, strict=True))
    for key, cut in zip(wave, cuts, strict=True):
        if cut is None:
            work.give_up(key)
        elif work.pays(cut):
            changed.append(work.lay(cut))
            laid.append(cut)
    with run.pool() as each:
        each(work.measured, changed)
    return laid


class Place(NamedTuple):
    """A window, and the bits by which its placement is drawn."""

    box: Box
    bits: int


class Drawing:
    """Placements are drawn among those that fit: for empty windows, or for the worst ones of a full map."""

    def __init__(self, sewn: GraphcutGrowth, worst: WorstSeams | None = None) -> None:
        self.sewn, self.worst, self.lay, self.measured = sewn, worst, sewn.write, sewn.note

    def found(self, sites: list[Place], run: Run) -> Sequence[Candidates]:
        """The candidates; the middle of what is to be covered does not count."""
        holes = [middle(place.box) for place in sites if self.worst is not None]
        with self.sewn.opened(holes):
            return self.sewn.found([place.box for place in sites], run)

    def best(self, site: Place, found: Candidates) -> Cut | None:
        """The cheapest cut of those that are drawn."""
        return self.sewn.cheapest(site.box, found, site.bits, self.worst is None)

    def pays(self, cut: Cut) -> bool:
        """Always: seams of windows that lie apart are their own."""
        return True

    def give_up(self, key: Any) -> None:
        """Leave a window until something changes there."""
        assert self.worst is not None  # an empty window takes any patch
        self.worst.give_up(key)


def fill(sewn: GraphcutGrowth, seed: int, stage: int, run: Run, more: int = 0) -> None:
    """Fill the windows of the layout in waves; `more` units of work are still to come after them."""
    growth, work, done = sewn.growth, Drawing(sewn), 0
    order: list[list[Window]] = waves(growth.layout, growth.windows, sewn.around)
    if sewn.stitch.lattice and sewn.first is None:  # all others lie in step with the first
        order[:1] = [order[0][:1], order[0][1:]] if order else []
    total = sum(map(len, order)) + more
    for wave in order:
        boxes = {w: Place((*growth.at(w), *growth.layout.patch), draw(seed, stage, 0, *w)) for w in wave}
        improve(work, boxes, run, lambda begin: run.tick(done + begin, total, growth.draft))  # noqa: B023
        done += len(wave)
    run.tick(done, total, growth.draft)


def refine(sewn: GraphcutGrowth, seed: int, stage: int, run: Run, steps: int) -> list[int]:
    """Cover the worst seams anew, where that makes them cheaper; returns what every accepted patch saved.

    Those of them that lie apart are taken together, a part of all attempts at a time. Ends after so many attempts, or
    when no place is left that has not been tried since it last changed.
    """
    growth, patch, number, saved = sewn.growth, sewn.growth.layout.patch, 0, list[int]()
    done, worst = int(growth.windows.sum()), WorstSeams(sewn.prices, patch, sewn.wraps)
    work = Drawing(sewn, worst)
    while number < steps:
        wave = worst.apart(sewn.around, most=min(-(-steps // ROUNDS), steps - number))
        if not wave:
            break
        places = {
            cell: Place((*at, *patch), draw(seed, stage, 1, number + k)) for k, (cell, at) in enumerate(wave.items())
        }
        tick = lambda begin: run.tick(done + number + begin, done + steps, growth.draft)  # noqa: B023, E731
        laid = improve(work, places, run, tick)
        worst.renew(*(cut.box for cut in laid))
        saved += [-cut.change for cut in laid]
        number += len(wave)
    run.tick(done + steps, done + steps, growth.draft)
    return saved
