"""Empty graph-cut maps to lay patches in."""

from __future__ import annotations

from typing import Any

import intarsia as ia
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.patches.patch_synthesis import PatchSettings, PatchSynthesis
from intarsia.seams.graphcut_synthesis import settings_of, stitch_of
from intarsia.seams.graphcut_textures import GraphcutMap, GraphcutSettings


def empty(exemplars: list[Exemplar], canvas: Canvas, settings: GraphcutSettings | None = None, patch: int | Any = 16,
          overlap: int = 6, **more: Any) -> GraphcutMap:  # fmt: skip
    """A map for patches of so many px, by default without settings of its own."""
    sides = (patch, patch) if isinstance(patch, int) else patch
    growth = PatchSynthesis(PatchSettings(sides, (overlap, overlap), **more), exemplars, canvas)
    return GraphcutMap(growth, settings or GraphcutSettings())


def empty_of(exemplars: list[Exemplar], canvas: Canvas, **given: Any) -> GraphcutMap:
    """The map that `graphcut` begins with, of patches of 16 px unless said otherwise."""
    method = ia.Graphcut(**{"patch": 16, "overlap": 6, **given}).resolved(exemplars, canvas)
    return GraphcutMap(PatchSynthesis(settings_of(method), exemplars, canvas), stitch_of(method))
