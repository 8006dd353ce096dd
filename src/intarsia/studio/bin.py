"""What was taken away: for a while it can be brought back; then, or when the studio ends, it goes for ever.

The row alone is marked, in one write: if the studio is killed, a thing is there whole, or goes whole at the next start.
"""

from __future__ import annotations

import asyncio
import time

from .events import Events
from .refusals import Refused
from .store import OPEN, Row, Store

WHILE = 60.0  # s: the page offers it for ten, and once more for all when another thing is taken away


class Bin:
    """Jobs with what they made, and exemplars, that were taken away."""

    def __init__(self, store: Store, events: Events) -> None:
        self.store, self.events = store, events

    def take(self, kind: str, row: Row) -> None:
        """Take a job or an exemplar away, unless it is needed just now."""
        if kind == "jobs" and row["state"] in OPEN:
            raise Refused(409, f"this job is {row['state']}; cancel it first.")
        under_way = [job["exemplars"] for job in self.store.all("jobs") if job["state"] in OPEN]
        if kind == "exemplars" and any(row["id"] in names for names in under_way):
            raise Refused(409, "a job with this exemplar is under way; cancel it first.")
        gone = self.store.put(kind, row | {"gone": time.time()})
        self.events.tell("gone", {kind[:-1]: row["id"]})
        asyncio.get_running_loop().call_later(WHILE, self._forget, kind, gone)

    def back(self, kind: str, name: str) -> Row:
        """Bring back what was taken away."""
        row = self.store.get(kind, name, gone=True)
        if row is None:
            raise Refused(404, f"no such {kind[:-1]} was taken away a moment ago.")
        del row["gone"]
        return self.store.put(kind, row)

    def empty(self) -> None:
        """Let everything go that is in here."""
        for kind in ("jobs", "exemplars"):
            for row in self.store.all(kind, gone=True):
                self._forget(kind, row)

    def _forget(self, kind: str, row: Row) -> None:
        """Remove the files, and what a job made unless another one made the same; the row last."""
        name = row["id"]
        if self.store.get(kind, name, gone=True) != row:  # it was brought back, and perhaps taken away once more
            return
        if kind == "exemplars":
            self.store.drop(kind, name)
            return
        others = [j for gone in (False, True) for j in self.store.all("jobs", gone) if j["id"] != name]
        if row["result"] is not None and all(other["result"] != row["result"] for other in others):
            self.store.drop("results", row["result"])
        self.store.drop_row("jobs", name)
