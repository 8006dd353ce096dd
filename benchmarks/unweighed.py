"""What is measured of an output beside its score: numbers that its total does not need, and that rise when it breaks.

    found = beside([exemplar], smap)["strange"]

``strange`` and ``lost`` see the picture alone, ``seams`` and ``unshown`` read the map; all are percents. How far they
agree with people stands in docs/score.md.

Sources: patches both ways, Simakov et al. 2008 (Summarizing visual data using bidirectional similarity, section 3);
seams, Kwatra et al. 2003, section 3.1; the scales are our own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from intarsia.analysis.features import Features, features
from intarsia.foundation.geometry import Wrap
from intarsia.judging import reference_scales, render_features
from intarsia.judging.parts import mean_step, sources_of
from intarsia.judging.sources import ASKED, STEP, Level
from intarsia.judging.windows import nearest
from intarsia.model import Exemplar
from intarsia.model.sourcemap import SourceMap
from intarsia.seams import seams_of

RARE = 9, 10  # nine of ten windows are nearer to their like: farther is strange
SIZES = 2  # of windows: the smallest

# Grain hides a step of tone from single differences; summed with their sign over cells of 8 px, it is seen.
CELL, TONE = 8, 2  # px; how much it counts beside them; at 0 a step as large as grain is not seen

Picture = NDArray[np.int16]


def beside(exemplars: Sequence[Exemplar], smap: SourceMap) -> dict[str, float]:
    """Measure a map without holes, of whole pixels, and the picture that it shows."""
    feats = features(exemplars)
    pictures = [p[..., : feats.base] for p in feats.pictures]
    usual = mean_step(feats.pictures, tuple(e.usable for e in exemplars))
    seams = seam_total(feats, exemplars, smap) / (smap.height * smap.width) / max(usual, 1e-9) / 2
    counts = [c if e.usable is None else c[e.usable] for c, e in zip(smap.usage(), exemplars, strict=True)]
    unshown = sum(int((c == 0).sum()) for c in counts) / max(sum(c.size for c in counts), 1)
    return far_off(pictures, exemplars, render_features(pictures, smap)) | {
        "seams": 100 * seams,
        "unshown": 100 * unshown,
    }


def seam_total(feats: Features, exemplars: Sequence[Exemplar], smap: SourceMap) -> int:
    """Return the cost of all seams of a map without holes, in units of the features; 0 where it is one piece."""
    shape = smap.height // CELL + 1, smap.width // CELL + 1, feats.pictures[0].shape[2]
    total, tone = 0, np.zeros((2, *shape), np.int64)
    for axis, seam in seams_of(exemplars, smap, [{0: p} for p in feats.pictures]):
        first, second = seam.over - seam.there, seam.here - seam.back
        total += int(np.abs(first).sum() + np.abs(second).sum())
        before = (seam.back != seam.there).any(axis=1)  # whether anything comes before the next ones
        np.add.at(tone[axis], (seam.y // CELL, seam.x // CELL), first + np.where(before[:, None], second, 0))
    return total + TONE * int(np.abs(tone).sum())


def of_picture(exemplar: Exemplar, output: Exemplar) -> dict[str, float]:
    """Measure a picture of at most 512 px a side."""
    mine, shown = features([exemplar, output]).pictures
    return far_off([mine], [exemplar], shown)


def far_off(pictures: Sequence[Picture], exemplars: Sequence[Exemplar], output: Picture) -> dict[str, float]:
    """How many windows are farther from the exemplar than nine of ten of its own, and of it from the output."""
    known = reference_scales(pictures, exemplars)
    held = known.reduced(output)
    strange, lost = list[float](), list[float]()
    for found in sources_of(known.reference, held)[:SIZES]:
        asked, own = found.level.windows.own(ASKED)
        most = np.sort(own)[len(own) * RARE[0] // RARE[1]]
        strange.append(float((found.distance > most).mean()))
        lost.append(float((_missing(found.level, held, asked) > most).mean()))
    return {"strange": 100 * _mean(strange), "lost": 100 * _mean(lost)}


def _missing(level: Level, picture: Picture, asked: NDArray[Any]) -> NDArray[Any]:
    """How far windows of the exemplar are from the nearest of the output."""
    waves = level.windows.cut(picture, STEP // 2)
    waves = waves.reshape(-1, waves.shape[2])
    return nearest(level.windows.waves[asked], waves, (waves * waves).sum(axis=1))[0]


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else 0.0


def meeting(picture: NDArray[Any], wrap: Wrap) -> float:
    """Return where the step across the borders stands among those between inner lines, in percent; the worse axis."""
    found = []
    for axis, closed in ((0, wrap.y), (1, wrap.x)):
        if closed:
            p = np.moveaxis(picture.astype(np.int32), axis, 0)
            inner = np.abs(np.diff(p, axis=0)).sum(axis=(1, 2))
            found.append(100 * float((inner < np.abs(p[0] - p[-1]).sum()).mean()))
    return max(found)
