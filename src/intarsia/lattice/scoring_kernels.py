"""Kernels of lattice scoring: sums of a correlation map over lattice points, in whole numbers.

A map holds the correlation at every offset in millionths, offset 0 in its middle; its weights are 0 where too few
pixels overlap. Positions are in 1/2048 px, an eighth of 1/256 px, so that eighths of vectors are whole numbers, too.
"""

from __future__ import annotations

import numpy as np

from ..foundation.arrays import Floats, Int16, Int32, Int64, Mask, Pair
from ..kernels.jit import kernel


@kernel
def top_of(before: float, here: float, after: float) -> float:
    """Return where the parabola through three neighbours has its maximum, px from the middle one; 0 if it has none."""
    bend = 2.0 * here - before - after
    return 0.5 * (after - before) / bend if bend > 0 else 0.0


WINDOW = 512  # px: largest side of the compared region, equal to the side above which exemplars are reduced
SPARSE = 128  # px: if the shorter side of the region is longer, every second px of each axis is compared


@kernel
def best_shift(
    picture: Int16,
    usable: Mask,
    near: Int64,
    radius: int,
    found: Floats,
) -> bool:
    """Find the shift near `near`, (dy, dx) px, at which a picture differs least from itself; write it to `found`.

    The cost of a shift is the variance of the differences, summed over channels. For all shifts within `radius` px per
    axis the same px are compared, at most WINDOW x WINDOW around the middle of the overlap. The minimum is refined by a
    parabola per axis. False if it lies on the border of the search, or fewer than 8 px a side or 64 pixels can be
    compared. `usable` of one px: all px are usable.
    """
    height, width, channels = picture.shape
    top, left = max(0, radius - near[0]), max(0, radius - near[1])
    bottom, right = min(height, height - near[0] - radius), min(width, width - near[1] - radius)
    if bottom - top > WINDOW:
        top = (top + bottom - WINDOW) // 2
        bottom = top + WINDOW
    if right - left > WINDOW:
        left = (left + right - WINDOW) // 2
        right = left + WINDOW
    if bottom - top < 8 or right - left < 8:
        return False
    masked, step = usable.size > 1, 2 if min(bottom - top, right - left) > SPARSE else 1
    side = 2 * radius + 1
    cost = np.zeros((side, side))
    for i in range(side):
        for j in range(side):
            dy, dx = near[0] + i - radius, near[1] + j - radius
            total = 0.0
            for c in range(channels):
                square, plain, count = 0, 0, 0
                for y in range(top, bottom, step):
                    for x in range(left, right, step):
                        if masked and not (usable[y, x] and usable[y + dy, x + dx]):
                            continue
                        d = np.int64(picture[y + dy, x + dx, c]) - picture[y, x, c]
                        square += d * d
                        plain += d
                        count += 1
                if count < 64:
                    return False
                total += (square - plain * plain / count) / count
            cost[i, j] = total
    bi, bj = divmod(cost.argmin(), side)
    if bi == 0 or bj == 0 or bi == side - 1 or bj == side - 1:
        return False
    here = cost[bi, bj]
    found[0] = near[0] + bi - radius + top_of(-cost[bi - 1, bj], -here, -cost[bi + 1, bj])
    found[1] = near[1] + bj - radius + top_of(-cost[bi, bj - 1], -here, -cost[bi, bj + 1])
    return True


NOTHING = -(1 << 40)  # returned in place of a mean if no point counts


@kernel
def sample_at(values: Int32, y: int, x: int) -> int:
    """Return the map at (y, x), in 1/2048 px from its first pixel; bilinear interpolation, rounded down."""
    i, j = y >> 11, x >> 11
    fy, fx = y & 2047, x & 2047
    a, b = np.uint64(i), np.uint64(j)  # unsigned: spares numba the check for negative indices
    k, m = np.uint64(min(i + 1, values.shape[0] - 1)), np.uint64(min(j + 1, values.shape[1] - 1))
    above = np.int64(values[a, b]) * (2048 - fx) + np.int64(values[a, m]) * fx
    below = np.int64(values[k, b]) * (2048 - fx) + np.int64(values[k, m]) * fx
    return int((above * (2048 - fy) + below * fy) >> 22)


@kernel
def weight_at(weights: Int32, y: int, x: int) -> int:
    """Return the weight of the offset nearest to (y, x), in 1/2048 px; 0 outside of the map."""
    high, wide = weights.shape[0] >> 1, weights.shape[1] >> 1
    if abs(y) > high << 11 or abs(x) > wide << 11:
        return 0
    return int(weights[((y + 1024) >> 11) + high, ((x + 1024) >> 11) + wide])


@kernel
def lattice_mean(
    values: Int32, weights: Int32, lattice: Int64, i: int, j: int
) -> Pair:
    """Return the weighted mean of the map over all points (a + i/8) v1 + (b + j/8) v2, and the number of points.

    `lattice` holds v1 and v2 as rows (dy, dx) in 1/256 px. At phase (0, 0) only one half plane without the origin
    is read, as the map is symmetric.
    """
    p, q, r, s = lattice[0, 0], lattice[0, 1], lattice[1, 0], lattice[1, 1]
    determinant = abs(p * s - q * r)
    high, wide = (values.shape[0] >> 1) << 8, (values.shape[1] >> 1) << 8
    most = (high * abs(s) + wide * abs(r)) // determinant + 2
    whole = i == 0 and j == 0
    total, mass, count = 0, 0, 0
    for a in range(0 if whole else -most, most + 1):
        y0, x0 = (8 * a + i) * p + j * r, (8 * a + i) * q + j * s
        # The range of b for which y0 + 8 b r stays in the map, or x0 + 8 b s if v2 is nearly horizontal.
        if abs(r) * wide >= abs(s) * high:
            step, start, reach = 8 * r, y0, 8 * high
        else:
            step, start, reach = 8 * s, x0, 8 * wide
        if step < 0:
            step, start = -step, -start
        first, last = -((reach + start) // step), (reach - start) // step
        if whole and a == 0:
            first = 1
        for b in range(first, last + 1):
            y, x = y0 + 8 * b * r, x0 + 8 * b * s
            w = weight_at(weights, y, x)
            if w > 0:
                total += w * int(sample_at(values, y + (high << 3), x + (wide << 3)))
                mass += w
                count += 1
    return (total // mass if mass > 0 else NOTHING), count


@kernel
def means(values: Int32, weights: Int32, lattices: Int64, phases: Int64) -> Int64:
    """Return the highest mean of each lattice over phases (m, 2), in eighths of its vectors, and its points: (2, n).

    `lattices`: (n, 2, 2) in 1/256 px. NOTHING and 0 for a lattice no point of which counts.
    """
    best = np.zeros((2, len(lattices)), np.int64)
    for k in range(len(lattices)):
        best[0, k] = NOTHING
        for m in range(len(phases)):
            mean, count = lattice_mean(values, weights, lattices[k], phases[m, 0], phases[m, 1])
            if count > 0 and mean > best[0, k]:
                best[0, k], best[1, k] = mean, count
    return best


@kernel
def course_profile(values: Int32, weights: Int32, direction: Int64, count: int) -> Int64:
    """Return the weighted mean of the map along parallel lines, and the sum of weights of each: (2, count).

    Entry s is the line s/2 px from the middle; 0 if no point of it counts. `direction` (dy, dx) is perpendicular to the
    lines and has length 65536; lines are sampled every 2 px.
    """
    p, q = direction[0], direction[1]
    high, wide = (values.shape[0] >> 1) << 17, (values.shape[1] >> 1) << 17
    along = abs(p) * high >= abs(q) * wide
    lines = np.zeros((2, count), np.int64)
    for s in range(count):
        total, weight = 0, 0
        y0, x0 = s * p, s * q
        first, last = -(1 << 40), 1 << 40
        for axis in range(2):  # the range of t for which the line stays in the map
            step, start, reach = (2 * p, x0, wide) if axis == 1 else (-2 * q, y0, high)
            low, top = -reach, reach + (0 if (axis == 1) == along else 63)
            if step < 0:
                step, start, low, top = -step, -start, -top, -low
            if step > 0:
                first, last = max(first, -((start - low) // step)), min(last, (top - start) // step)
            elif start < low or start > top:
                last = first - 1
        for t in range(first + (first & 1), last + 1, 2):
            y, x = ((y0 - 2 * t * q) >> 6) + (high >> 6), ((x0 + 2 * t * p) >> 6) + (wide >> 6)
            w = int(weights[np.uint64((y + 1024) >> 11), np.uint64((x + 1024) >> 11)])
            if w > 0:
                total += w * int(sample_at(values, y, x))
                weight += w
        if weight > 0:
            lines[0, s], lines[1, s] = total // weight, weight
    return lines


@kernel
def peak_near(
    smooth: Int32, y: float, x: float, radius: float, found: Floats
) -> bool:
    """Find the peak of a map near (y, x), px from its middle; write its position (y, x) and height to `found`.

    It is the highest px within `radius` px, refined by a parabola along each axis. False if one of its eight neighbours
    is higher, as it then is no peak.
    """
    height, width = smooth.shape
    cy, cx = y + (height >> 1), x + (width >> 1)
    reach = int(np.ceil(radius))
    best, bi, bj = -(1 << 31), -1, -1
    for i in range(max(1, int(cy) - reach), min(height - 1, int(cy) + reach + 2)):
        for j in range(max(1, int(cx) - reach), min(width - 1, int(cx) + reach + 2)):
            if smooth[i, j] > best and (i - cy) ** 2 + (j - cx) ** 2 <= radius * radius:
                best, bi, bj = smooth[i, j], i, j
    if bi < 0:
        return False
    for i in range(bi - 1, bi + 2):
        for j in range(bj - 1, bj + 2):
            if smooth[i, j] > best:
                return False
    here = float(best)
    found[0] = bi - (height >> 1) + top_of(float(smooth[bi - 1, bj]), here, float(smooth[bi + 1, bj]))
    found[1] = bj - (width >> 1) + top_of(float(smooth[bi, bj - 1]), here, float(smooth[bi, bj + 1]))
    found[2] = here
    return True


@kernel
def fit_step(
    smooth: Int32,
    weights: Int32,
    vectors: Floats,
    most: int,
    radius: float,
    sums: Floats,
) -> Pair:
    """Accumulate the normal equations of v1 and v2 over the peaks near their points up to index `most`.

    `vectors`: px; `sums`: w aa, w ab, w bb, w a y, w a x, w b y, w b x, w residual^2, w, for peaks (y, x) of points of
    index (a, b). Return how many points had a peak within `radius` px, and how many were tried. The weight w is that of
    the offset times the height of the peak; peaks not above 0 are ignored.
    """
    sums[:] = 0.0
    found = np.empty(3)
    used, tried = 0, 0
    high, wide = smooth.shape[0] >> 1, smooth.shape[1] >> 1
    p, q, r, s = vectors[0, 0], vectors[0, 1], vectors[1, 0], vectors[1, 1]
    determinant = abs(p * s - q * r)
    top_a = min(most, int((high * abs(s) + wide * abs(r)) / determinant) + 1)
    top_b = min(most, int((high * abs(q) + wide * abs(p)) / determinant) + 1)
    for a in range(top_a + 1):
        for b in range(-top_b if a > 0 else 1, top_b + 1):
            y, x = a * p + b * r, a * q + b * s
            w = float(weight_at(weights, int(np.floor(2048 * y)), int(np.floor(2048 * x))))
            if w <= 0:
                continue
            tried += 1
            if not peak_near(smooth, y, x, radius, found) or found[2] <= 0:
                continue
            used += 1
            w *= found[2]
            sums[0] += w * a * a
            sums[1] += w * a * b
            sums[2] += w * b * b
            sums[3] += w * a * found[0]
            sums[4] += w * a * found[1]
            sums[5] += w * b * found[0]
            sums[6] += w * b * found[1]
            sums[7] += w * ((found[0] - y) ** 2 + (found[1] - x) ** 2)
            sums[8] += w
    return used, tried
