"""Remake the pictures of docs/methods/patch-sampling.md from built-in procedural exemplars."""

from __future__ import annotations

import numpy as np
from make_pictures import FOLDER, beside, grown, rgb, sample
from PIL import Image

import intarsia as ia
from intarsia.foundation.run import Probe


def joins() -> np.ndarray:
    """The same map with hard cuts, feathered seams, and cut along the cheapest seam."""
    methods = [ia.PatchSampling(patch=25, overlap=7, join=j) for j in ("middle", "feather", "cut")]
    return beside(*(rgb(grown("stones", 256, m, seed=2)) for m in methods))


def searches() -> np.ndarray:
    """Bricks by the full search, and by the pyramid with 1 place kept and with 8."""
    methods = [
        ia.PatchSampling(patch=40, overlap=8, search="exact"),
        *(ia.PatchSampling(patch=40, overlap=8, pyramid="mean", pyramid_kept=k) for k in (1, 8)),
    ]
    return beside(*(rgb(grown("tiles", 256, m, seed=1)) for m in methods))


def turned() -> np.ndarray:
    """Pebbles lit from one side: all isometries, and those that `auto` allows."""
    methods = [ia.PatchSampling(patch=30, overlap=6, isometries=k) for k in ("both", "auto")]
    return beside(*(rgb(grown("pebbles", 256, m, seed=1)) for m in methods))


def distances() -> np.ndarray:
    """An exemplar, and how well each of its patches fitted at one place of the output; dark is near."""
    probe = Probe(80, 120)
    ia.synthesize("sample:planks", 200, ia.PatchSampling(patch=25, overlap=5), run=ia.Run(1, probe=probe))
    found = probe.maps[0] if probe.maps else np.zeros((1, 1))
    gray = np.rint(255 * (found - found.min()) / max(float(np.ptp(found)), 1e-9)).astype(np.uint8)
    return beside(sample("planks"), rgb(gray))


if __name__ == "__main__":
    for name, make in (("joins", joins), ("searches", searches), ("turned", turned), ("distances", distances)):
        path = FOLDER / f"patch-sampling-{name}.jpg"
        Image.fromarray(make()).save(path, quality=88)
        print(path.name)
