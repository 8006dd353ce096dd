"""A task that kills its worker; in a file of its own, so that a worker that is started for it imports little."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass
from pathlib import Path

from intarsia.giant.picture import Cell


@dataclass(frozen=True)
class Dies:
    """A task that kills its process the first times that it comes to a cell."""

    folder: str
    number: int
    times: int

    def __call__(self, cell: Cell) -> list[bytes]:
        if cell.number == self.number:
            done = len(os.listdir(self.folder))
            if done < self.times:
                Path(self.folder, str(done)).touch()
                os.kill(os.getpid(), signal.SIGKILL)
        return [str(cell.number).encode()]
