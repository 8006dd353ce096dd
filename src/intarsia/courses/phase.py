"""Which course each pixel of an exemplar lies in, where courses slant, converge or bow: a smooth phase.

The strongest wave of the texture is followed from window to window, first its direction and pitch, then its phase. What
remains is a polynomial of few numbers, rounded, so that no last bit of a transform decides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, rfft

from ..arrays import Array
from ..lattice.correlation_map import CorrelatedPictures

Floats = NDArray[np.float64]

TERMS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (1, 3))
"""Powers (across, along) of the polynomial: what perspective and a bow need."""
TURN = 1 << 16  # coefficients are whole numbers of 1 / TURN courses: a unit


class Following(NamedTuple):
    """How a wave is followed. Halved and doubled on 16 pictures, 11 of walls, tiles and stones (docs/design/012).

    "1 px": pixels of the straight exemplar move by that at most.
    """

    shortest: int = 6  # px of a wave; 3 and 12: the same
    longest: int = 3  # times the longest one fits into the shorter side; 2: the same, 6: three walls follow others
    windows: int = 5  # along each side, in which pitch and direction are measured; 3: chain mail is lost, 9: the same
    spread: float = 0.35  # of its length a window's wave may be off; halved: chain mail is lost, doubled: three bend
    waves: int = 2  # of the whole are tried; 1: cobbles follow a worse one, 4: scales a false one
    finer: int = 3  # times finer than windows need are spectra sampled; 2: chain mail is lost, 6: 1 px
    rounds: int = 5  # times that phases are measured and fitted; 3: a fan is 9 % off, 10: blue tiles are lost
    stray: float = 0.2  # courses: phases this far off count half; halved: scales follow a false wave, doubled: 1 px
    doubt: float = 0.1  # waves off by this share count half; halved and doubled: 1 px
    ridge: float = 0.02  # keeps what windows do not tell near nothing; halved and doubled: 1 px
    faint: float = 0.001  # the same for phases; halved: blue tiles are lost, doubled: a wall of 193 px is 2 px off
    fits: int = 4  # times that weights follow from what is left over; halved and doubled: 1 px


SQUARES = 6  # terms up to the second degree
FOLLOWING = Following()


@dataclass(frozen=True)
class Spectra:
    """Powers of windows (n, F, F / 4), their middles (n, 2) px, frequencies (F, 1) and (F / 4,) per px."""

    powers: Floats
    middles: Floats
    rows: Floats
    columns: Floats


@dataclass(frozen=True)
class Phase:
    """The course that each pixel lies in, as a polynomial of its place."""

    factors: tuple[int, ...]  # of TERMS, in 1 / TURN courses; places run from -1 to 1 over the exemplar
    upright: bool  # the courses run down the rows: across them is x
    strength: float  # share of what is seen that is one wave of this phase

    def at(self, across: Array, along: Array) -> Floats:
        """The phase at places from -1 to 1, in 1 / TURN courses; products one by one, the same on every machine."""
        total = np.zeros(np.broadcast_shapes(across.shape, along.shape))
        for factor, (i, j) in zip(self.factors, TERMS, strict=True):
            term = np.full_like(across, factor, np.float64)
            for place, power in ((across, i), (along, j)):
                for _ in range(power):
                    term = term * place
            total += term
        return total


def phases(prepared: CorrelatedPictures) -> list[Phase]:
    """Follow the strongest waves of an exemplar; the best first, none where no wave goes through it."""
    layers = _layers(prepared)
    if layers is None:
        return []
    spectra = _spectra(layers)
    found = [one for wave in _waves(spectra, layers.shape) if (one := _followed(layers, spectra, wave)) is not None]
    return sorted(found, key=lambda one: -one.strength)


def samples(n: int, seen: int | None = None) -> Floats:
    """The middles of n pixels, from -1 to 1 where `seen` of them are looked at."""
    seen = n if seen is None else seen
    return (2.0 * np.arange(n) + 1 - seen) / seen


def _layers(prepared: CorrelatedPictures) -> Floats | None:
    """Colours and edges (C, H, W), each of variance 1 or nothing."""
    edges = prepared.edges
    known = np.ones(edges.shape[:2], bool) if prepared.inner is None else prepared.inner
    if not known.any():
        return None
    edges = (edges - edges[known].mean()) * known[..., None]
    stack = np.moveaxis(np.concatenate([prepared.colours, edges], axis=2), 2, 0)
    deviation = stack.std(axis=(1, 2))
    if not (deviation > 0).any():
        return None
    shares = np.sqrt(np.array([0.5 / (len(stack) - 1)] * (len(stack) - 1) + [0.5]))
    return np.asarray(stack * (shares / np.maximum(deviation, 1e-9))[:, None, None])


def _spectra(layers: Floats) -> Spectra:
    """Transform overlapping windows, each without its mean; columns end where no wave is looked for."""
    height, width = layers.shape[1:]
    side = max(16, min(height, width) // 2)
    n = FOLLOWING.finer * side
    most = min(n // 2, int(n * (1 + FOLLOWING.spread) / FOLLOWING.shortest) + 1) + 1
    hann = np.sin(np.pi * (np.arange(side) + 0.5) / side) ** 2
    powers, middles = [], []
    for y in np.linspace(0, height - side, FOLLOWING.windows).astype(int):
        for x in np.linspace(0, width - side, FOLLOWING.windows).astype(int):
            part = layers[:, y : y + side, x : x + side]
            part = (part - part.mean(axis=(1, 2), keepdims=True)) * (hann[:, None] * hann)
            waves = fft(rfft(part, n)[:, :, :most], n, axis=1)
            powers.append(np.fft.fftshift((waves.real**2 + waves.imag**2).sum(axis=0), axes=0))
            middles.append((y + side / 2 - 0.5, x + side / 2 - 0.5))
    rows = np.fft.fftshift(np.fft.fftfreq(n))
    return Spectra(np.array(powers), np.array(middles), rows[:, None], -rows[len(rows) // 2 :: -1][:most])


def _waves(spectra: Spectra, shape: tuple[int, ...]) -> list[tuple[float, float]]:
    """The strongest waves of all windows together, cycles per px (y, x)."""
    rows, columns = spectra.rows, spectra.columns
    length = np.hypot(rows, columns)
    ok = (length <= 1 / FOLLOWING.shortest) & (length >= FOLLOWING.longest / min(shape[1:]))
    ok &= (columns > 0) | (rows > 0)
    total = np.where(ok, spectra.powers.mean(axis=0), 0)
    found: list[tuple[float, float]] = []
    for _ in range(FOLLOWING.waves):
        i, j = np.unravel_index(int(total.argmax()), total.shape)
        if total[i, j] <= 0:
            break
        y, x = float(rows[i, 0]), float(columns[j])
        found.append((y, x))
        for sign in (1, -1):  # the half plane ends somewhere: both ends of a wave may be seen
            total[np.hypot(rows - sign * y, columns - sign * x) < FOLLOWING.spread * length[i, j]] = 0
    return found


def _followed(layers: Floats, spectra: Spectra, wave: tuple[float, float]) -> Phase | None:
    """Fit the phase that follows one wave."""
    height, width = layers.shape[1:]
    upright = abs(wave[1]) > abs(wave[0])
    if wave[upright] < 0:
        wave = -wave[0], -wave[1]
    fit: tuple[int, ...] | None = _from_windows(spectra, (height, width), wave, upright)
    pitch = 1 / abs(wave[upright])
    if upright:
        layers = np.ascontiguousarray(layers.swapaxes(1, 2))
        height, width = width, height
    strength = 0.0
    for n in range(FOLLOWING.rounds):
        if fit is None:
            return None
        angle = Phase(fit, upright, 0.0).at(samples(height)[:, None], samples(width)) / TURN
        step = max(4, min(int(pitch * (1.5 if n < 2 else 1.0)), min(height, width) // 4))
        fit, strength = _moved(layers, angle, step, fit)
    return None if fit is None else Phase(fit, upright, strength)


def _from_windows(
    spectra: Spectra, shape: tuple[int, int], wave: tuple[float, float], upright: bool
) -> tuple[int, ...]:
    """The polynomial of second degree whose slopes are the waves of the windows."""
    length = float(np.hypot(*wave))
    near = np.zeros(spectra.powers.shape[1:], bool)
    for sign in (1, -1):
        near |= np.hypot(spectra.rows - sign * wave[0], spectra.columns - sign * wave[1]) < FOLLOWING.spread * length
    design, target, sure = [], [], []
    for power, (y, x) in zip(spectra.powers, spectra.middles, strict=True):
        part = np.where(near, power, 0)
        i, j = np.unravel_index(int(part.argmax()), part.shape)
        f = [float(spectra.rows[i, 0]), float(spectra.columns[j])]
        sign = 1 if f[0] * wave[0] + f[1] * wave[1] > 0 else -1
        place = [(2 * y + 1 - shape[0]) / shape[0], (2 * x + 1 - shape[1]) / shape[1]]
        for axis in (0, 1):  # 0: across the courses
            k = axis ^ upright
            design.append([_slope(p, place[upright], place[1 - upright], axis) for p in TERMS[1:SQUARES]])
            target.append(sign * f[k] * shape[k] / 2)
            sure.append(float(part[i, j]) ** 0.5)
    a, b, base = np.array(design), np.array(target), np.rint(1000 * np.array(sure) / max(*sure, 1e-12))
    ridge = FOLLOWING.ridge * np.array([0.0, 0.0] + [1.0] * (SQUARES - 3))
    return (0, *_fit(a, b, base, ridge, FOLLOWING.doubt * length * min(shape) / 2), *([0] * (len(TERMS) - SQUARES)))


def _fit(a: Floats, b: Floats, sure: Floats, ridge: Floats, scale: float) -> list[int]:
    """Least squares a x = b in 1 / TURN, near 0 by `ridge`; what leaves `scale` over counts half as `sure`."""
    w = sure
    for _ in range(FOLLOWING.fits):
        left = np.einsum("ki,kj,k->ij", a, a, w) + np.diag(ridge) * w.sum()
        factors = np.linalg.solve(left, np.einsum("ki,k,k->i", a, b, w))
        w = np.maximum(np.rint(sure / (1 + ((a @ factors - b) / scale) ** 2)), 1)
    return [int(v) for v in np.rint(factors * TURN)]


def _slope(powers: tuple[int, int], s: float, t: float, axis: int) -> float:
    i, j = powers
    if axis == 0:
        return i * s ** (i - 1) * t**j if i else 0.0
    return j * s**i * t ** (j - 1) if j else 0.0


def _moved(layers: Floats, angle: Floats, step: int, fit: tuple[int, ...]) -> tuple[tuple[int, ...] | None, float]:
    """The polynomial with the phases that are left over added, and how much of the layers it explains."""
    height, width = angle.shape
    down, across = _begins(height, step), _begins(width, step)
    above, beside = _windows(height, down, step), _windows(width, across, step)
    parts = [layers * f(2 * np.pi * angle) for f in (np.cos, np.sin)]
    rows = [np.einsum("ny,cyx->cnx", above, part) for part in parts]
    one, other = (np.einsum("mx,cnx->cnm", beside, part) for part in rows)
    sums = one - 1j * other
    total = parts[0].sum(axis=(1, 2)) ** 2 + parts[1].sum(axis=(1, 2)) ** 2
    whole = sums.sum(axis=(1, 2))
    energy = float((layers**2).sum())
    strength = float(total.sum()) / max(energy * height * width, 1e-9)
    local = (sums * whole.conj()[:, None, None]).sum(axis=0)
    size = np.abs(local)
    if size.max() <= 0:
        return None, 0.0
    off = np.rint(np.angle(local) / (2 * np.pi) * TURN) / TURN
    s = (2 * (down[:, None] + step) - height) / height + 0 * across
    t = (2 * (across + step) - width) / width + 0 * down[:, None]
    a = np.stack([s.ravel() ** i * t.ravel() ** j for i, j in TERMS], axis=1)
    base = np.rint(1000 * size.ravel() / size.max())
    ridge = FOLLOWING.faint * np.array([0.0] * 3 + [1.0] * (len(TERMS) - 3))
    return tuple(f + d for f, d in zip(fit, _fit(a, off.ravel(), base, ridge, FOLLOWING.stray), strict=True)), strength


def _begins(n: int, step: int) -> NDArray[np.int64]:
    """Where windows of 2 step px begin."""
    count = max(3, round((n - 2 * step) / step * 1.5) + 1)
    return np.linspace(0, max(n - 2 * step, 0), count).astype(np.int64)


def _windows(n: int, begins: NDArray[np.int64], step: int) -> Floats:
    """How much each of n pixels counts in windows of 2 step px, (windows, n)."""
    x = np.arange(n) - begins[:, None]
    return np.where((x >= 0) & (x < 2 * step), np.sin(np.pi * (x + 0.5) / (2 * step)) ** 2, 0.0)
