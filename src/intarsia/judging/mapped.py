"""What a map tells beyond its picture: copies, seams and places that are shown, exactly; and whether borders meet.

Source: seams, Kwatra et al. 2003, section 3.1; the other measures are our own.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..analysis.features import features
from ..arrays import Array
from ..exemplar import Exemplar
from ..geometry import Wrap
from ..seams.cost import seam_total
from ..sourcemap import SourceMap
from .parts import Part, mean_step

MAPPED = (
    Part("seams", "%", "what the cuts of the map cost, of the mean step between neighbours", 0.0, 0.0, 100.0),
    Part("copied", "%", "of the output lies in one copy with what is an element away", 0.0, 0.0, 100.0),
    Part("unshown", "%", "of the exemplar's pixels are shown nowhere", 0.0, 0.0, 100.0),
)
WRAPPED = Part("wrap", "%", "of inner lines have smaller steps than the line where borders meet", 0.0, 98.0, 100.0)


def mapped(exemplars: Sequence[Exemplar], smap: SourceMap, element: int) -> dict[str, float]:
    """Measure a map without holes, of whole pixels, whose exemplars have elements of `element` px."""
    feats = features(exemplars)
    usable = tuple(e.usable for e in exemplars)
    usual = mean_step(feats.pictures, usable)
    seams = seam_total(feats, exemplars, smap) / (smap.height * smap.width) / max(usual, 1e-9) / 2
    counts = [c if e.usable is None else c[e.usable] for c, e in zip(smap.usage(), exemplars, strict=True)]
    unshown = sum(int((c == 0).sum()) for c in counts) / max(sum(c.size for c in counts), 1)
    return {"seams": 100 * seams, "copied": 100 * _copied(smap, max(element, 1)), "unshown": 100 * unshown}


def _copied(smap: SourceMap, away: int) -> float:
    """The share of pixels that show what lies `away` px before them, moved by just that, over both axes."""
    shares = []
    for axis, length in ((0, smap.height), (1, smap.width)):
        if length > away:
            ahead = np.take(smap.yx, range(away, length), axis) - np.take(smap.yx, range(length - away), axis)
            same = (ahead == ((away, 0) if axis == 0 else (0, away))).all(axis=2)
            shares.append(float(same.mean()))
    return sum(shares) / len(shares) if shares else 0.0


def meeting(picture: Array, wrap: Wrap) -> float | None:
    """Return where the step across the borders stands among those between inner lines, in percent; the worse axis.

    None where the output does not wrap.
    """
    found = []
    for axis, closed in ((0, wrap.y), (1, wrap.x)):
        if closed and picture.shape[axis] > 2:
            p = np.moveaxis(picture.astype(np.int32), axis, 0)
            inner = np.abs(np.diff(p, axis=0)).sum(axis=(1, 2))
            across = int(np.abs(p[0] - p[-1]).sum())
            found.append(100 * float((inner < across).mean()))
    return max(found) if found else None
