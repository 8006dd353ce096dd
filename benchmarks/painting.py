"""What each switch of painting with labels is worth: label agreement and seam cost, on and off.

    python benchmarks/painting.py EXEMPLAR.png LABELS.png

Grows a disc, stripes and a coast of two labels, and prints for every switch: the share of output pixels with the
label that was asked for, the same within 24 px of a boundary, and the mean difference (0 to 1 of the range, in
hundredths) of neighbours across seams there, counted over all pixels of that band.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt

import intarsia as ia
from intarsia import files
from intarsia.foundation.geometry import ISOMETRIES

SIDE, BAND = 384, 24

FAR = 10_000
PLAIN = ia.ImageQuilting(boundary_patch=0, boundary_isometries="none", boundary_tolerance=FAR)
SWITCHES: dict[str, tuple[Any, float, int]] = {
    "weight 0": (PLAIN, 0.0, 0),
    "weight 0.5": (PLAIN, 0.5, 0),
    "weight 2, as the source": (PLAIN, 2.0, 0),
    "weight 5": (PLAIN, 5.0, 0),
    "+ half patches": (replace(PLAIN, boundary_patch=None), 2.0, 0),
    "+ turned patches": (replace(PLAIN, boundary_isometries=None), 2.0, 0),
    "+ strays replaced": (replace(PLAIN, boundary_tolerance=None), 2.0, 0),
    "+ half, turned": (ia.ImageQuilting(boundary_tolerance=FAR), 2.0, 0),
    "+ all three (default)": (ia.ImageQuilting(), 2.0, 0),
    "default, reach 12": (ia.ImageQuilting(), 2.0, 12),
    "sampling, join same": (ia.PatchSampling(boundary_join="same"), 2.0, 0),
    "sampling, join cut": (ia.PatchSampling(), 2.0, 0),
}


def targets(first: int, second: int) -> list[np.ndarray]:
    """A disc, stripes and a coast."""
    y, x = np.mgrid[:SIDE, :SIDE]
    masks = (
        (y - SIDE / 2) ** 2 + (x - SIDE / 2) ** 2 < (SIDE / 3) ** 2,
        (x + y) // 70 % 2 == 0,
        np.sin(x / 40) * 30 + SIDE / 2 + 20 * np.sin(x / 17 + 1) < y,
    )
    return [np.where(m, first, second).astype(np.uint8) for m in masks]


def seam_cost(out: ia.Synthesis, band: np.ndarray) -> float:
    """Mean difference of neighbours across seams, over all pixels of the band, in hundredths of the range."""
    pixels = out.exemplars[0].base.samples.astype(float) / 255
    yx, shown, total = out.map.yx.astype(int), out.render(feather=0).samples.astype(float) / 255, np.zeros(band.shape)
    pose = np.zeros(band.shape, int) if out.map.pose is None else out.map.pose.astype(int)
    j = np.array([i.j for i in ISOMETRIES])
    for axis in (0, 1):
        there = tuple(slice(1, None) if a == axis else slice(None) for a in (0, 1))
        here = tuple(slice(None, -1) if a == axis else slice(None) for a in (0, 1))
        step = j[pose[here]][:, :, :, axis]
        on = np.clip(yx[here] + step, 0, np.array(pixels.shape[:2]) - 1)
        jump = (on != yx[there]).any(axis=2)
        apart = np.abs(pixels[on[:, :, 0], on[:, :, 1]] - shown[there]).mean(axis=2)
        total[there] += np.where(jump, apart, 0)
    return 100 * float(total[band].mean())


def main(picture: str, labels: str) -> None:
    """Print the table."""
    exemplar = ia.read(picture)
    marks = files.read_plane(labels, ia.Kind.LABEL)
    first, second = np.unique(marks.pixels).tolist()
    print(f"{'':28}{'agree %':>9}{'band %':>9}{'seam':>8}{'s':>7}")
    for name, (method, weight, reach) in SWITCHES.items():
        rows = []
        for target in targets(first, second):
            began = time.perf_counter()
            guide = ia.Guide(marks, ia.Plane(target, ia.Kind.LABEL), weight, reach)
            out = ia.synthesize(exemplar, None, method, guide=guide, seed=1)
            took = time.perf_counter() - began
            same = marks.pixels[out.map.yx[:, :, 0], out.map.yx[:, :, 1]].reshape(SIDE, SIDE) == target
            inner = target == first
            band = np.maximum(distance_transform_edt(inner), distance_transform_edt(~inner)) <= BAND
            rows.append((100 * same.mean(), 100 * same[band].mean(), seam_cost(out, band), took))
        agree, near, seam, took = np.mean(rows, axis=0)
        print(f"{name:28}{agree:9.2f}{near:9.2f}{seam:8.3f}{took:7.1f}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:3])
