"""Multrus 2003 from its text alone: numbers of pixels in, coordinates out; nothing of the package but its draws.

One gray picture of whole numbers; sections are named where a line follows one. Squares stand for roots, which keep
their order. What the text leaves open is marked `open`.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from intarsia.foundation.run import below, draw

STAGE = 2003
UNKNOWN, OUTSIDE = -1, -2
AROUND = 8  # px around a block that filters see


class Multrus:
    """3.2: blocks of w_b px and seams of w_e px, row by row; `epsilon` stands for the n best if given."""

    def __init__(
        self, sample: NDArray, size: tuple[int, int], sides: tuple[int, int], n: int = 1, seed: int = 0,
        epsilon: float | None = None, counter: bool = False, pyramid: bool = False,
    ) -> None:  # fmt: skip
        self.sample, self.size, (self.wb, self.we), self.n, self.seed = sample.astype(np.int64), size, sides, n, seed
        self.epsilon, self.counter, self.pyramid = epsilon, counter, pyramid
        self.block = self.wb + 2 * self.we
        self.places = np.argwhere(np.ones(np.array(sample.shape) - self.block + 1))  # 3.2.1: wholly inside the sample
        self.marks = np.zeros(np.array(sample.shape) - self.block + 1, np.int64)
        self.image = np.full(size, UNKNOWN, np.int64)
        self.yx = np.full((*size, 2), -1)
        self.passed: list[int] = []  # how many blocks were within the tolerance

    def run(self) -> NDArray:
        """Return the sample's row and column that each pixel shows."""
        step = self.wb + self.we
        for r in range(-(-self.size[0] // step)):
            for c in range(-(-self.size[1] // step)):  # 3.2.2: from top to bottom and from left to right
                y, x, bits = r * step - self.we, c * step - self.we, draw(self.seed, STAGE, 0, r, c)
                if r == c == 0:
                    u, s = self.places[below(len(self.places), bits)].tolist()
                elif self.pyramid:
                    u, s = self.from_coarse_to_fine(y, x)
                else:
                    window = self.around(y, x)[AROUND:-AROUND, AROUND:-AROUND]
                    u, s = self.chosen(self.sample, window, 0, self.places, bits)
                self.lay(y, x, u, s)
        return self.yx

    def chosen(self, sample: NDArray, window: NDArray, level: int, places: NDArray, bits: int) -> tuple[int, int]:
        """3.3.4 and 4.2.1: draw among the blocks within the tolerance, else take the best."""
        known = window >= 0
        blocks = sliding_window_view(sample, window.shape)[tuple(places.T)]
        d = ((blocks - window)[:, known] ** 2).sum(axis=1)  # A d**2 of 3.3.3
        if self.counter:  # d + c d
            at = np.minimum(places << level, np.array(self.marks.shape) - 1)
            d = d * (1 + self.marks[tuple(at.T)]) ** 2
        order = np.argsort(d, kind="stable")  # open: equal ones in their order
        within = order[: self.n]
        if self.epsilon is not None:
            within = order[d[order] < self.epsilon**2 * (window[known] ** 2).sum()]
        self.passed.append(len(within))
        u, s = places[within[below(len(within), bits)] if len(within) else order[0]].tolist()
        return u, s

    def from_coarse_to_fine(self, y: int, x: int) -> tuple[int, int]:
        """4.3.1: choose at level 2, project, cut out an area of twice the block's side, choose again."""
        samples, images = [self.sample], [self.around(y, x)]
        for pictures in (samples, images) * 2:
            pictures.append(halved(pictures[-1]))
        last = (0, 0)
        for level in (2, 1, 0):
            sample, side = samples[level], (self.wb >> level) + 2 * (self.we >> level)
            inside = slice(AROUND >> level, (AROUND >> level) + side)
            window = images[level][inside, inside]
            every = np.argwhere(np.ones(np.array(sample.shape) - side + 1))
            if level < 2:
                centre = np.minimum(2 * np.array(last), np.array(sample.shape) - side)
                every = every[(np.abs(every - centre) <= side // 2 + 1).all(axis=1)]  # open: 1 px more on each side
            last = self.chosen(sample, window, level, every, draw(self.seed, STAGE, 1 + level, y, x))
        return last

    def around(self, y: int, x: int) -> NDArray:
        """The image from some px above and to the left of a block; OUTSIDE where there is none."""
        window = np.full(2 * [self.block + 2 * AROUND], OUTSIDE)
        for i, j in np.ndindex(window.shape):
            a, b = y + i - AROUND, x + j - AROUND
            if 0 <= a < self.size[0] and 0 <= b < self.size[1]:
                window[i, j] = self.image[a, b]
        return window

    def lay(self, y: int, x: int, u: int, s: int) -> None:
        """B.1.4: copy the block without blending; open: of an odd seam the larger half stays."""
        keep = (self.we + 1) // 2
        for i in range(keep if y > 0 else 0, self.block):
            for j in range(keep if x > 0 else 0, self.block):
                if 0 <= y + i < self.size[0] and 0 <= x + j < self.size[1]:
                    self.image[y + i, x + j], self.yx[y + i, x + j] = self.sample[u + i, s + j], (u + i, s + j)
        near = self.block - 1  # 4.2.1: all blocks within w_b + 2 w_e - 1 px
        self.marks[max(u - near, 0) : u + near + 1, max(s - near, 0) : s + near + 1] += 1


def halved(picture: NDArray) -> NDArray:
    """4.3.1: the mean of 3x3 px, then every second pixel; UNKNOWN unless all nine are known.

    Open: what lies outside is left out, and means are rounded, halves up.
    """
    out = np.empty((picture.shape[0] // 2, picture.shape[1] // 2), np.int64)
    for i, j in np.ndindex(out.shape):
        nine = picture[max(2 * i - 1, 0) : 2 * i + 2, max(2 * j - 1, 0) : 2 * j + 2]
        there = nine[nine >= 0]
        out[i, j] = UNKNOWN if (nine == UNKNOWN).any() else (2 * there.sum() + len(there)) // max(2 * len(there), 1)
        if picture[2 * i, 2 * j] == OUTSIDE:
            out[i, j] = OUTSIDE
    return out
