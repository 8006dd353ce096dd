"""Tiny textures, grown with every method and every option that runs other kernels: what warming up grows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..exemplar import Exemplar
from ..guide import Guide
from ..image import Kind, Plane
from ..lattice.vectors import lattice_of
from ..levelling import Levelling
from ..methods.base import METHODS, Ability, make, method_class
from ..params import parameters
from ..run import Run
from ..synthesis import synthesize

ASKED: dict[Ability, dict[str, Any]] = {
    Ability.WRAP: {"wrap": "both"},
    Ability.SEVERAL: {"several": True},
    Ability.MASK: {"mask": True},
    Ability.GUIDE: {"guide": True},
}
"""What is asked of methods that can do it."""


def kinds() -> list[dict[str, Any]]:
    """Every method, and every option that runs other kernels."""
    return list(_kinds())


def grow_tiny(number: int, run: Run) -> None:
    """Grow the texture of one of these kinds."""
    _grow(kinds()[number], run)


def _kinds() -> Iterator[dict[str, Any]]:
    for slug in METHODS:
        cls = method_class(slug)
        yield {"method": slug}
        known = {p.name: p for p in parameters(cls)}
        options: list[dict[str, Any]] = [{n: c} for n, p in known.items() for c in p.choices if c != p.default]
        more = ("isometries", "both"), ("min_repeat_distance", 2), ("angle", 30)
        options += [{n: v} for n, v in more if n in known]
        options += [{"lattice": ((5, 0), (0, 5))}] if {"lattice", "overreach"} <= known.keys() else []
        for values in options:
            if "heights" in values:  # they need a wall, which is laid by the kernels of courses
                continue
            if values.get("pyramid"):
                values |= {"patch": 12, "overlap": 4}
            yield {"method": slug, "values": values}
        yield from ({"method": slug} | asked for ability, asked in ASKED.items() if ability in cls.supports)


def _grow(kind: dict[str, Any], run: Run) -> None:
    rows, columns = np.mgrid[:24, :24]
    noise = (rows * 73 + columns * 151 + rows * columns * 7) % 251
    colour = np.stack([noise, noise // 2, 250 - noise], axis=2).astype(np.uint8)
    normal = np.dstack([colour[:, :, :2], np.full((24, 24), 250, np.uint8)])
    planes: dict[str, Any] = {
        "albedo": colour,
        "deep": colour.astype(np.uint16) * 257,
        "light": colour.astype(np.float32) / 255,
        "clear": np.dstack([colour, colour[:, :, :1]]),
        "glow": np.dstack([colour, colour[:, :, :1]]).astype(np.float32) / 255,
        "height": noise.astype(np.uint16),
        "normal": normal,
        "normals": normal.astype(np.float32) / 255,
        "id": (noise // 90).astype(np.uint8),
    }
    usable = noise > 3 if kind.get("mask") else None
    exemplars = [Exemplar.of(planes, usable=usable)]
    if kind.get("several"):
        exemplars.append(Exemplar.of({name: plane[::-1] for name, plane in planes.items()}))
    names = {p.name for p in parameters(method_class(kind["method"]))}
    patch: dict[str, Any] = {"patch": 6} if "patch" in names else {}
    if "lattice" in names and "overreach" not in names:
        _find_lattice()
        _lay_courses(run)
        sizes: dict[str, dict[str, Any]] = {"block": {"block": 4, "border": 2}, "band": {"band": 2}}
        patch |= next((values for name, values in sizes.items() if name in names), {})
        if kind.get("values", {}).get("snap") != "off":
            patch |= {"lattice": ((5, 0), (0, 5))}
    method = make(kind["method"], patch | kind.get("values", {}))
    marks = Plane((columns > 11).astype(np.uint8), Kind.LABEL)
    guide = Guide(marks, Plane(marks.pixels[:20, 2:22], Kind.LABEL)) if kind.get("guide") else None
    grown = synthesize(exemplars, (20, 20), method, wrap=kind.get("wrap", "none"), guide=guide, run=run)
    for plane in planes:
        for feather in (0, 3):
            grown.render(plane, feather=feather, run=run)
        if grown.map.exact:
            grown.render(plane, finish=(Levelling(8),), run=run)


def _find_lattice() -> None:
    """Look for a lattice where there is one."""
    rows, columns = np.mgrid[:48, :48]
    pixels = (rows % 8 * 20 + columns % 6 * 15 + (rows * 73 + columns * 151) % 11).astype(np.uint8)
    lattice_of(Exemplar.of(pixels), "near-regular")


def _lay_courses(run: Run) -> None:
    """Grow bricks, and boards without joints, from one lattice vector."""
    rows, columns = np.mgrid[:48, :64]
    grain = (rows * 73 + columns * 151) % 31
    beds, joints = rows % 12 < 2, (columns + rows // 12 * 8) % 16 < 2
    for mortar in (beds | joints, beds):
        pixels = np.where(mortar, 10, 150 + grain).astype(np.uint8)
        synthesize(pixels, (24, 40), make("near-regular", {"lattice": ((0, 12),)}), run=run)
