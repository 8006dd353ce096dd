"""Let a texture flow, twice, as animated PNG files: python examples/flowing_water.py [SIZE] [FRAMES].

``flowing_sway.png`` loops: each frame is the first one, moved by a displacement that is periodic in time.
``flowing_channel.png`` goes on: each frame is the one before, moved by a current that is fastest in the middle.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import intarsia as ia
from intarsia.synthesis import Synthesis


def sway(first: Synthesis, frames: int) -> list[Synthesis]:
    """A wave that runs through the texture, up to 3 px to either side; after the last frame comes the first."""
    size = first.map.width

    def at(frame: int) -> Synthesis:
        def flow(y: Any, x: Any) -> Any:
            return 0 * y, 3 * np.sin(2 * np.pi * (frame / frames + (x + y) / size))

        return ia.advect(first, flow, coarsest=1)  # nothing adds up, so small tears are all there is to mend

    return [at(frame) for frame in range(frames)]


def channel(first: Synthesis, frames: int) -> list[Synthesis]:
    """A current to the right, 3 px a frame in the middle and none at the banks."""
    height = first.map.height

    def current(y: Any, x: Any) -> Any:
        return 0 * y, 3 * np.sin(np.pi * (y + 0.5) / height) ** 2

    made = [first]
    for frame in range(1, frames):
        made.append(ia.advect(made[-1], current, frame=frame))
    return made


def main(size: int = 256, folder: Path = Path("demo"), frames: int = 8) -> list[Path]:
    """Grow the first frame, and write both animations."""
    folder.mkdir(exist_ok=True)
    first = ia.synthesize("sample:pebbles", size, ia.ParallelControllable(), seed=3, wrap="both")
    written = []
    for move in (sway, channel):
        pictures = [Image.fromarray(np.asarray(made.render())) for made in move(first, frames)]
        written.append(folder / f"flowing_{move.__name__}.png")
        pictures[0].save(written[-1], save_all=True, append_images=pictures[1:], duration=80, loop=0)
    return written


if __name__ == "__main__":
    numbers = [int(a) for a in sys.argv[1:]]
    print(*main(*numbers[:1], **({"frames": numbers[1]} if numbers[1:] else {})), sep="\n")
