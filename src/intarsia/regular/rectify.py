"""Exemplars whose courses slant, converge or bow, laid straight: the same pixels, moved by whole px.

Every pixel of the straight exemplar is one of the exemplar, so that copies stay exact; where courses are widened some
pixels are shown twice, where they are narrowed some are left out. Pixels move across the courses, to where the phase of
the courses puts them; along them only as much as makes the joints between bricks stand upright.

Source: Lopez Recas 2011, chapter 6 (geometry corrected before the synthesis); how is not said there.

Which course each pixel of an exemplar lies in, where courses slant, converge or bow: a smooth phase.

The strongest wave of the texture is followed from window to window, first its direction and pitch, then its phase. What
remains is a polynomial of few numbers, rounded, so that no last bit of a transform decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.fft import fft, fftfreq, fftshift, rfft

from ..analysis import factor_for, principal_axes, reduced
from ..analysis.features import features
from ..foundation.arrays import Array, Floats, Int32, Int64, Mask, Pair
from ..foundation.filters import blurred
from ..foundation.params import Steps, Weights
from ..lattice import check_lattice, find_lattice, lattice_of, lattices_of, vectors_of
from ..lattice.candidates import CorrelatedPictures, pictures
from ..lattice.verdict import Lattice
from ..model import Exemplar
from ..model.image import Plane
from .unequal import sure_masonry

TERMS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (1, 3))
"""Powers (across, along) of the polynomial: what perspective and a bow need."""
TURN = 1 << 16  # coefficients are whole numbers of 1 / TURN courses: a unit
TURNS = np.exp(2j * np.pi * np.arange(1 << 12) / (1 << 12))  # angles are looked up; as sharp as they are averaged


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
        terms = zip(self.factors, TERMS, strict=True)
        return np.asarray(sum(math.prod([across] * i + [along] * j, start=float(f)) for f, (i, j) in terms))


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
    """What colours differ by most, and edges (2, H, W), each of variance 0.5 or nothing."""
    colours = prepared.colours.reshape(-1, prepared.colours.shape[2])
    mean = colours.sum(axis=0) / len(colours)  # of whole numbers, as are the sums of their products
    axis = principal_axes(colours.T @ colours / len(colours) - np.outer(mean, mean), 1)[1][0]
    stack = np.stack([np.rint(prepared.colours @ axis), prepared.steps[..., 0]])
    deviation = stack.std(axis=(1, 2))
    if not (deviation > 0).any():
        return None
    return np.asarray(stack * (math.sqrt(0.5) / np.maximum(deviation, 1e-9))[:, None, None])


def _spectra(layers: Floats) -> Spectra:
    """Transform overlapping windows, each without its mean; columns end where no wave is looked for."""
    height, width = layers.shape[1:]
    side = max(16, min(height, width) // 2)
    n = FOLLOWING.finer * side
    most = min(n // 2, int(n * (1 + FOLLOWING.spread) / FOLLOWING.shortest) + 1) + 1
    hann = np.sin(np.pi * (np.arange(side) + 0.5) / side) ** 2
    down, right = (np.linspace(0, n - side, FOLLOWING.windows).astype(int) for n in (height, width))
    base = rfft(hann, n)[:most, None]
    # Rows are transformed once for all windows below one another: (C, frequencies, H).
    strips = [[rfft(layer[:, x : x + side] * hann, n)[:, :most].T for layer in layers] for x in right]
    powers, middles = [], []
    for y in down:
        for x, strip in zip(right, strips, strict=True):
            power = np.zeros((most, n))
            for layer, rows in zip(layers, strip, strict=True):
                mean = layer[y : y + side, x : x + side].mean()
                waves = fft((rows[:, y : y + side] - mean * base) * hann, n)
                power += waves.real**2 + waves.imag**2
            powers.append(fftshift(power.T, axes=0))
            middles.append((y + side / 2 - 0.5, x + side / 2 - 0.5))
    waves_down: Floats = np.asarray(fftshift(fftfreq(n)), np.float64)
    along = -waves_down[n // 2 :: -1][:most]
    return Spectra(np.array(powers), np.array(middles), waves_down[:, None], along)


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
        total[_near(spectra, (y, x))] = 0
    return found


def _near(spectra: Spectra, wave: tuple[float, float]) -> Mask:
    """The frequencies near a wave. The half plane ends somewhere: both ends of it may be seen."""
    most = FOLLOWING.spread * np.hypot(*wave)
    one, other = (np.hypot(spectra.rows - s * wave[0], spectra.columns - s * wave[1]) < most for s in (1, -1))
    return np.asarray(one | other)


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
        fit, strength = _advanced(layers, angle, step, fit)
    return None if fit is None else Phase(fit, upright, strength)


def _from_windows(
    spectra: Spectra, shape: Pair, wave: tuple[float, float], upright: bool
) -> tuple[int, ...]:
    """The polynomial of second degree whose slopes are the waves of the windows."""
    length = float(np.hypot(*wave))
    near = _near(spectra, wave)
    design, target, sure = [], [], []
    for power, (y, x) in zip(spectra.powers, spectra.middles, strict=True):
        part = np.where(near, power, 0)
        i, j = np.unravel_index(int(part.argmax()), part.shape)
        f = [float(spectra.rows[i, 0]), float(spectra.columns[j])]
        sign = 1 if f[0] * wave[0] + f[1] * wave[1] > 0 else -1
        place = [(2 * y + 1 - shape[0]) / shape[0], (2 * x + 1 - shape[1]) / shape[1]]
        s, t = place[upright], place[1 - upright]
        design.append([a * s ** max(a - 1, 0) * t**b for a, b in TERMS[1:SQUARES]])  # slopes across the courses,
        design.append([b * s**a * t ** max(b - 1, 0) for a, b in TERMS[1:SQUARES]])  # and along them
        target += [sign * f[k] * shape[k] / 2 for k in (upright, 1 - upright)]
        sure += 2 * [float(part[i, j]) ** 0.5]
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


def _advanced(layers: Floats, angle: Floats, step: int, fit: tuple[int, ...]) -> tuple[tuple[int, ...] | None, float]:
    """The polynomial with the phases that are left over added, and how much of the layers it explains."""
    height, width = angle.shape
    down, across = _begins(height, step), _begins(width, step)
    above, beside = _windows(height, down, step), _windows(width, across, step)
    turns = np.rint(angle * len(TURNS)).astype(np.int64) % len(TURNS)
    parts = [layers * wave[turns] for wave in (TURNS.real, TURNS.imag)]
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


def _begins(n: int, step: int) -> Int64:
    """Where windows of 2 step px begin."""
    count = max(3, round((n - 2 * step) / step * 1.5) + 1)
    return np.linspace(0, max(n - 2 * step, 0), count).astype(np.int64)


def _windows(n: int, begins: Int64, step: int) -> Floats:
    """How much each of n pixels counts in windows of 2 step px, (windows, n)."""
    x = np.arange(n) - begins[:, None]
    return np.where((x >= 0) & (x < 2 * step), np.sin(np.pi * (x + 0.5) / (2 * step)) ** 2, 0.0)


class Gain(NamedTuple):
    """When the straight exemplar is taken: of 92 textures 27 can be laid straight, one gains (docs/design/012)."""

    least: float = 1.15  # times the confidence as it is; at 1 six more are moved (1.00 to 1.13), doubled: none is
    clear: float = 2.0  # times what is asked, if it has none as it is; halved: scales and slabs get one, doubled: none
    off: float = 3.0  # px: what is straighter gives way in step, too; 1: the same, 6: boards of two lone maps are left
    level: float = 2.0  # px over the exemplar: courses that lean less are level, as 1 px at each end is rounding


GAIN = Gain()


@dataclass(frozen=True, eq=False)
class Rectified:
    """The exemplar that blocks are read from, its lattice (x, y) px, and how it was laid straight, if it was."""

    exemplar: Exemplar
    lattice: Steps
    straight: Straight | None

    def to_exemplar(self, yx: Int32) -> Int32:
        """Turn pixels of it into pixels of the exemplar as it was given."""
        return yx if self.straight is None else self.straight.to_exemplar(yx)


def rectified_for(
    exemplar: Exemplar, slug: str, lattice: Steps | None = None, choice: str = "auto", weights: Weights = None
) -> Rectified:
    """Decide whether courses are laid straight, and find the lattice; MethodError, of the method `slug`, without one.

    `choice`: auto, on or off. With given vectors, `lattice` (x, y) px, ``auto`` leaves the exemplar as it is; with
    ``on`` they are those of the straight one.
    """
    if lattice is not None:
        straight = straight_of(exemplar, weights) if choice == "on" else None
        laid = exemplar if straight is None else straight.exemplar
        check_lattice(lattice, laid)
        return Rectified(laid, lattice, straight)
    better = None
    if choice != "off":
        better = improved(exemplar, weights) if choice == "auto" else levelled(exemplar, weights)
    if better is not None:
        return Rectified(better[0].exemplar, vectors_of(better[1]), better[0])
    return Rectified(exemplar, lattice_of(exemplar, slug, weights), None)


def improved(exemplar: Exemplar, weights: Weights = None) -> tuple[Straight, Lattice] | None:
    """The exemplar laid straight and its lattice, where it is much surer than as it is; else None.

    None, too, where two vectors are known as it is: patches in step with them bend as it does.
    """
    plain = lattices_of(exemplar, weights).accepted
    if plain is not None and plain.kind == "2-D":
        return None
    if plain is None and sure_masonry(exemplar, weights) is None:
        return None  # of 199 textures and maps 138 have no lattice; two of them gain, both of bricks
    straight = straight_of(exemplar, weights)
    found = None if straight is None or straight.off < GAIN.off else levelled(exemplar, weights)
    if found is None:
        return None
    if plain is None:
        return found if found[1].share >= GAIN.clear else None
    alike = found[1].kind == plain.kind
    return found if alike and found[1].confidence >= GAIN.least * plain.confidence else None


def levelled(exemplar: Exemplar, weights: Weights = None) -> tuple[Straight, Lattice] | None:
    """The exemplar laid straight and its lattice; None where it is straight already, or has none.

    Courses stay courses; where the exemplar has no lattice as it is, that of one or two vectors is taken that is surer.
    """
    straight = straight_of(exemplar, weights)
    if straight is None:
        return None
    laid, plain = straight.exemplar, lattices_of(exemplar, weights).accepted
    two = None
    if plain is None or plain.kind == "2-D":
        two = lattices_of(laid, weights).accepted
        if two is None:  # nor one of one vector, which was looked for, too
            return None
        if two.kind == "1-D" or plain is not None:
            return straight, _level(two, laid)
    one = find_lattice(features([laid], weights).pictures[0], laid.usable, courses=True).accepted
    best = max((found for found in (one, two) if found is not None), key=lambda found: found.share, default=None)
    return None if best is None else (straight, _level(best, laid))


def _level(found: Lattice, laid: Exemplar) -> Lattice:
    """Courses that hardly lean, made level."""
    if found.kind == "2-D":
        return found
    ((y, x),) = found.vectors
    if abs(x) * laid.width < GAIN.level * abs(y):
        return replace(found, vectors=((abs(y), 0),))
    return replace(found, vectors=((0, abs(x)),)) if abs(y) * laid.height < GAIN.level * abs(x) else found


WORK_SIDE = 256  # px: larger exemplars are reduced to it, to be looked at, as waves of 6 px are the shortest followed
LEAN = 256  # joints lean by whole multiples of 1 / LEAN: a unit


class Bending(NamedTuple):
    """Which courses are laid straight; halved and doubled on the 16 pictures of `Following` (docs/design/012)."""

    move: float = 1.0  # px: less is not worth a change: pixels move by whole ones
    strength: float = 0.02  # share of an exemplar that its courses make up; halved: the same, doubled: three are lost
    narrowest: float = 0.5  # times as wide may a course become; 0.25: scales are bent, 0.7: two are lost
    widest: float = 2.0  # and that; as above with 4 and 1.4
    steepest: float = 0.35  # px down for each along: more would be sheared; halved: the same, doubled: scales are
    strong: float = 0.05  # share of the edges that count as joints; halved and doubled: joints lean by other 1 / LEAN


BENDING = Bending()


@dataclass(frozen=True, eq=False)
class Straight:
    """An exemplar laid straight."""

    exemplar: Exemplar  # its pixels where they lie now; what lay outside is not usable
    yx: Int32  # (H, W, 2): the pixel of the given exemplar that each pixel is
    slant: float  # px down per px along (or px aside per px down) by which the courses leaned
    converging: float  # how much wider the courses are at one end than at the other, as a share
    off: float  # how far courses lay from straight, parallel and equal ones at most, px

    def to_exemplar(self, yx: Int32) -> Int32:
        """Turn pixels of the straight exemplar into those of the given one."""
        return np.ascontiguousarray(self.yx[yx[..., 0], yx[..., 1]])


def straight_of(exemplar: Exemplar, weights: Weights = None) -> Straight | None:
    """Lay the courses of an exemplar straight; None where none are found, or they are straight already."""
    return exemplar.memo(("straight", weights), lambda: _straight(exemplar, weights))


def _straight(exemplar: Exemplar, weights: Weights) -> Straight | None:
    picture = features([exemplar], weights).pictures[0]
    if min(picture.shape[:2]) < 32:
        return None
    factor = factor_for(picture.shape, WORK_SIDE)
    small, mask = reduced(picture, exemplar.usable, factor)
    for phase in phases(pictures(small, mask)):
        if phase.strength < BENDING.strength:
            return None
        found = _laid(exemplar, picture, phase, factor)
        if found is not None:
            return found
    return None


def _laid(exemplar: Exemplar, picture: Array, phase: Phase, factor: int) -> Straight | None:
    """Follow a phase; None where it is no smooth change of straight courses, or no change."""
    usable = exemplar.free
    if phase.upright:
        picture, usable = picture.swapaxes(0, 1), usable.T
    height, width = usable.shape
    seen = [n // factor * factor for n in (height, width)]
    at = np.rint(phase.at(samples(height, seen[0])[:, None], samples(width, seen[1]))).astype(np.int64)
    pitch, slope, off = _flat(at)
    steps = np.diff(at, axis=0) * pitch
    if steps.min() < TURN * BENDING.narrowest or steps.max() > TURN * BENDING.widest:
        return None
    if abs(slope) > BENDING.steepest or max(off, abs(slope) * width) < BENDING.move:
        return None
    lean = _lean(picture, usable)
    yx, inside = _moved(at, round(pitch * 256), lean)
    ends = np.diff(at[[0, -1]], axis=0)[0]
    converging = float(ends.max() / ends.min() - 1)
    inside &= usable[yx[..., 0], yx[..., 1]]
    if phase.upright:
        yx, inside = yx.swapaxes(0, 1)[..., ::-1], inside.T
    whole = np.ascontiguousarray(yx, np.int32)
    return Straight(_gathered(exemplar, whole, inside), whole, slope, converging, off)


def _flat(at: Int64) -> tuple[float, float, float]:
    """The straight, parallel and equal courses next to a phase: pitch px, slope, and how far it is off at most, px."""
    height, width = at.shape
    y, x = np.arange(height) * 2 + 1 - height, np.arange(width) * 2 + 1 - width
    # Sums of whole numbers; the places sum to nothing, so that each slope is a quotient.
    down = int((at.sum(axis=1) * y).sum()) / (width * int((y * y).sum()))
    along = int((at.sum(axis=0) * x).sum()) / (height * int((x * x).sum()))
    left = at - int(at.sum()) / at.size - down * y[:, None] - along * x
    return TURN / (2 * down), -along / down, float(np.abs(left).max() / (2 * down))


def _lean(picture: Array, usable: Mask) -> int:
    """How far the joints between bricks lean, 1 / LEAN px along for each px across: the mean of the strongest edges."""
    smooth = np.rint(blurred(picture.astype(np.float64), 1.5, "symmetric") * 16).astype(np.int64)
    across, along = np.zeros(smooth.shape, np.int64), np.zeros(smooth.shape, np.int64)
    across[1:-1], along[:, 1:-1] = smooth[2:] - smooth[:-2], smooth[:, 2:] - smooth[:, :-2]
    square = (along * along).sum(axis=2)
    steep = usable & (square > 4 * (across * across).sum(axis=2))
    if steep.sum() < 100:
        return 0
    strong = steep & (square >= np.sort(square[steep])[-max(100, int(BENDING.strong * steep.sum()))])
    return int(np.rint(-LEAN * int((across * along).sum(axis=2)[strong].sum()) / max(int(square[strong].sum()), 1)))


def _moved(at: Int64, pitch: int, lean: int) -> tuple[Int64, Mask]:
    """The pixel next to each place of the straight exemplar (courses along x, `pitch` 1/256 px), and which exist."""
    width = at.shape[1]
    low, high = int(at.min()), int(at.max())
    tall = (high - low) * pitch // (TURN * 256) + 1
    wanted = low + np.arange(tall, dtype=np.int64) * TURN * 256 // pitch
    rows, known = np.empty((tall, width), np.int64), np.empty((tall, width), bool)
    half = TURN * 128 // pitch
    for k in range(width):
        column = at[:, k]
        rows[:, k] = np.searchsorted((column[1:] + column[:-1]) // 2, wanted)
        known[:, k] = (wanted >= column[0] - half) & (wanted <= column[-1] + half)
    shift = (np.arange(tall) - tall // 2) * lean // LEAN
    first, last = -int(shift.max()), width - int(shift.min())
    x = np.arange(first, last) + shift[:, None]
    inside = (x >= 0) & (x < width)
    x = np.clip(x, 0, width - 1)
    r = np.arange(tall)[:, None]
    return np.stack([rows[r, x], x], axis=2), inside & known[r, x]


def _gathered(exemplar: Exemplar, yx: Int32, usable: Mask) -> Exemplar:
    """The exemplar of other pixels, in all planes; vectors of normal maps stay as they are."""

    def moved(plane: Plane) -> Plane:
        pixels, y, x = plane.pixels, yx[..., 0], yx[..., 1]
        if plane.height < exemplar.height:
            s = exemplar.height // plane.height
            return replace(plane, pixels=pixels[y // s, x // s])
        s = plane.height // exemplar.height
        parts = pixels.reshape(exemplar.height, s, exemplar.width, s, *pixels.shape[2:])
        taken = parts[y, :, x].swapaxes(1, 2)
        return replace(plane, pixels=taken.reshape(y.shape[0] * s, y.shape[1] * s, *pixels.shape[2:]))

    planes = {name: moved(p) for name, p in exemplar.planes.items()}
    return replace(exemplar, planes=planes, usable=usable, toroidal=False)
