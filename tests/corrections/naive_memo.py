"""The correction operation in the words of the memorandum of 2008 alone: its mask, distance, sets and penalty.

Nothing of the package is read but what the memo takes as given: the source image, the coordinate image, and for each
source pixel the similar ones. The source is a torus, on the finest level.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

Pixel = tuple[int, int]


@dataclass
class Memo:
    """A source image (H, W, C), a d x d neighbourhood mask in [0, 1], the penalty K, and similar pixels of each."""

    source: Any
    mask: Any
    penalty: float
    similar: dict[Pixel, list[Pixel]]

    def at(self, y: int, x: int) -> Pixel:
        return y % self.source.shape[0], x % self.source.shape[1]

    def neighbourhood(self, pixels: list[list[Pixel]]) -> list[list[Any]]:
        return [[self.source[u].astype(float) for u in row] for row in pixels]

    def around(self, u: Pixel) -> list[list[Any]]:
        """N(u, d) of a source pixel."""
        half = len(self.mask) // 2
        steps = range(-half, half + 1)
        return self.neighbourhood([[self.at(u[0] + dy, u[1] + dx) for dx in steps] for dy in steps])

    def distance(self, first: list[list[Any]], second: list[list[Any]]) -> float:
        """Perceptual distance: "weights are applied to the terms of the sum of squares before the square root"."""
        total = 0.0
        for weights, a, b in zip(self.mask, first, second, strict=True):
            for weight, p, q in zip(weights, a, b, strict=True):
                total += float(weight) * float(((p - q) ** 2).sum())
        return math.sqrt(total)

    def proximity(self, shown: list[list[Pixel]]) -> set[Pixel]:
        """For each pixel around what lies there in the source, shifted as p is from it."""
        half = len(shown) // 2
        return {self.at(u[0] - dy + half, u[1] - dx + half) for dy, row in enumerate(shown) for dx, u in enumerate(row)}

    def prices(self, shown: list[list[Pixel]]) -> dict[Pixel, float]:
        """What every candidate of the pixel in the middle of `shown` (d x d coordinates) costs."""
        here, near = self.neighbourhood(shown), self.proximity(shown)
        found = {u: self.distance(self.around(u), here) for u in near}
        if math.isinf(self.penalty):
            return found
        jumps = {v for u in near for v in self.similar[u]} - near
        return found | {u: self.penalty * self.distance(self.around(u), here) for u in jumps}
