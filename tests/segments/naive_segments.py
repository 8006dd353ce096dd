"""The slow and obvious way to cut a picture into segments, to split colours, and to measure elements."""

from __future__ import annotations

import math

import numpy as np


def naive_segments(colours, usable, slack, least):
    """Felzenszwalb and Huttenlocher with sets of pixels: segment of every pixel as the set's first pixel, or -1."""
    height, width = colours.shape[:2]
    edges = []
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        for y in range(height):
            for x in range(width):
                v, u = y + dy, x + dx
                if 0 <= v < height and 0 <= u < width and usable[y, x] and usable[v, u]:
                    step = colours[y, x].astype(int) - colours[v, u].astype(int)
                    a, b = sorted((y * width + x, v * width + u)) if dx >= 0 else (y * width + x, v * width + u)
                    edges.append((min(math.isqrt(int((step * step).sum())), 65535), len(edges), a, b))
    # Edges of one weight keep the order of directions, and pixels of a direction that of the raster.
    edges.sort(key=lambda e: e[:2])
    segment = {p: {p} for p in range(height * width)}
    inner = dict.fromkeys(range(height * width), 0)

    def join(a, b, weight):
        both = segment[a] | segment[b]
        for p in both:
            segment[p] = both
        inner[min(both)] = weight

    for weight, _, a, b in edges:
        one, two = segment[a], segment[b]
        if one is not two and all(weight <= inner[min(s)] + slack / len(s) for s in (one, two)):
            join(a, b, weight)
    for _, _, a, b in edges:
        if segment[a] is not segment[b] and min(len(segment[a]), len(segment[b])) < least:
            join(a, b, inner[min(segment[a] | segment[b])])
    names = np.array([min(segment[p]) for p in range(height * width)]).reshape(height, width)
    return np.where(usable, names, -1)


def naive_split_error(colours, areas, low):
    """Area-weighted squared deviation along each channel, summed over both parts, as exact as floats are."""
    total = np.zeros(colours.shape[1])
    for part in (low, ~low):
        mean = np.average(colours[part], axis=0, weights=areas[part])
        total += (areas[part][:, None] * (colours[part] - mean) ** 2).sum(axis=0)
    return total


def naive_elements(elements, crumb):
    """Element by element: (height, width, area, edge pixels, centroid in whole 16ths, at the border)."""
    rows = []
    for k in range(1, elements.max() + 1):
        pixels = [(int(y), int(x)) for y, x in zip(*np.nonzero(elements == k), strict=True)]
        if len(pixels) < crumb:
            continue
        ys, xs = zip(*pixels, strict=True)
        edge = 0
        for y, x in pixels:
            around = ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1))
            inside = [(v, u) for v, u in around if 0 <= v < elements.shape[0] and 0 <= u < elements.shape[1]]
            edge += any(elements[v, u] != k for v, u in inside)
        centre = 16 * sum(ys) // len(ys), 16 * sum(xs) // len(xs)
        border = min(ys) == 0 or min(xs) == 0 or max(ys) == elements.shape[0] - 1 or max(xs) == elements.shape[1] - 1
        rows.append((max(ys) - min(ys) + 1, max(xs) - min(xs) + 1, len(pixels), edge, centre, border))
    return rows


def naive_zone_counts(groups, kinds, patch, zone, sides, y, x):
    """Pixels of every group in some sides of the zone of the patch at (y, x), corners once for each side."""
    (h, w), (b, c) = patch, zone
    strips = ((0, b, 0, w), (0, h, 0, c), (h - b, h, 0, w), (0, h, w - c, w))
    counts = [0] * kinds
    for (top, bottom, left, right), wanted in zip(strips, sides, strict=True):
        for i in range(top, bottom if wanted else top):
            for j in range(left, right):
                counts[groups[(y + i) % groups.shape[0], (x + j) % groups.shape[1]]] += 1
    return counts


def naive_histogram(counts, levels):
    return tuple(math.floor(math.sqrt(n / max(sum(counts), 1)) * levels + 0.5) for n in counts)
