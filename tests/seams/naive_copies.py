"""What repeats cost, pixel by pixel, by looking at every sample of the canvas: the slow twin of `copies_kernels`."""

from __future__ import annotations

import numpy as np


def _step(matrix, d):
    return matrix[0] * d[0] + matrix[1] * d[1], matrix[2] * d[0] + matrix[3] * d[1]


def _back(matrix, d):
    return matrix[0] * d[0] + matrix[2] * d[1], matrix[1] * d[0] + matrix[3] * d[1]


class NaiveCopies:
    """A map as (exemplar, row, column) of every pixel with the pose in which it lies, and what is wanted of repeats."""

    def __init__(self, shown, poses, wraps, cells, weights, js, tiles, terms):
        self.shown, self.poses, self.wraps, self.js, self.terms = shown, poses, wraps, js, terms
        self.cells, self.weights, self.tiles = cells, weights, tiles
        self.size = shown.shape[:2]

    def at(self, y, x):
        """What is shown at a place, or None."""
        place = []
        for n, length, wrap in zip((y, x), self.size, self.wraps, strict=True):
            if not 0 <= n < length and not wrap:
                return None
            place.append(n % length)
        return tuple(int(n) for n in self.shown[place[0], place[1]])

    def gap(self, a, b, axis):
        length = self.size[axis]
        return (a - b + length // 2) % length - length // 2 if self.wraps[axis] else a - b

    def near(self, place, sample):
        """Whether a sample lies in the tile of a place or one beside it."""
        for axis in (0, 1):
            count, side = self.tiles[axis], self.tiles[2 + axis]
            mine, other = place[axis] // side, sample[axis] // side
            apart = abs(mine - other)
            apart = min(apart, count - apart) if self.wraps[axis] or count < 3 else apart
            if apart > 1:
                return False
        return True

    def price(self, box, i, j, patch=None):
        """What the pixel (i, j) of a box costs; `patch` (pose, function of i, j): what would be shown there."""
        y, x = ((b + n) % length if wrap else b + n
                for b, n, length, wrap in zip(box[:2], (i, j), self.size, self.wraps, strict=True))  # fmt: skip
        pixel = self.at(y, x) if patch is None else patch[1](i, j)
        if pixel is None:
            return 0
        pose = int(self.poses[y, x]) if patch is None else patch[0]
        mine, a = [], self.terms["around"]
        b = a * 181 // 256
        offsets = [(a, 0), (-a, 0), (0, a), (0, -a), (b, b), (b, -b), (-b, b), (-b, -b)]
        for d in offsets:
            inside = patch is not None and 0 <= i + d[0] < box[2] and 0 <= j + d[1] < box[3]
            mine.append(patch[1](i + d[0], j + d[1]) if inside else self.at(box[0] + i + d[0], box[1] + j + d[1]))
        total, close, far_away, reach = 0, 0, 0, self.terms["reach"] ** 2
        for qy in range(0, self.size[0], 4):
            for qx in range(0, self.size[1], 4):
                other = self.at(qy, qx)
                if self.cells(*other) != self.cells(*pixel):
                    continue
                if not self.near((y, x), (qy, qx)):
                    far_away += 1
                    continue
                inside = []
                for n, begin, length, wrap in zip((qy, qx), box[:2], self.size, self.wraps, strict=True):
                    inside.append((n - begin) % length if wrap else n - begin)
                if patch is not None and 0 <= inside[0] < box[2] and 0 <= inside[1] < box[3]:
                    continue
                theirs = self.js[int(self.poses[qy, qx])]
                d = _back(theirs, (pixel[1] - other[1], pixel[2] - other[2]))
                cy, cx = qy + d[0], qx + d[1]
                gap = self.gap(cy, y, 0), self.gap(cx, x, 1)
                if max(abs(gap[0]), abs(gap[1])) < 3:
                    continue
                same = known = 0
                for d, own in zip(offsets, mine, strict=True):
                    e = _back(theirs, _step(self.js[pose], d))
                    there = self.at(cy + e[0], cx + e[1])
                    known += there is not None and own is not None
                    same += there is not None and there == own
                g = 77 + 179 * same // known if known else 77
                total += g
                far = gap[0] ** 2 + gap[1] ** 2
                if far < reach:
                    close += g * (16 - 16 * far // reach) ** 2 // 256
        total = max(total + 128 * far_away - self.terms["spare"], 0) + close * self.terms["near"] // 256
        return total * int(self.weights[pixel[0]][pixel[1], pixel[2]]) * self.terms["unit"] >> 24


def distances(feats, known, patches):
    """Squared differences over what is known of a window."""
    return [int((((feats - p).astype(np.int64) ** 2) * known[:, :, None]).sum()) for p in patches]
