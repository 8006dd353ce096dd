"""Grow textures from an example: a small picture goes in, a larger one made of its pieces comes out.

    import intarsia as ia
    wall = ia.synthesize("brick.png", (1024, 1024), ia.ImageQuilting(patch=96), seed=7, wrap="both")
    ia.write("wall.png", wall.render())

Everything is imported at its first use, so that ``import intarsia`` costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import Any

from .version import VERSION

__version__ = VERSION

_NAMES = {
    "analysis.illumination": "flattened",
    "choosing.auto": "Auto",
    "files": "read write",
    "foundation": "CancelledError InputError IntarsiaError MethodError ParameterError",
    "foundation.blend": "Blend Levelling Mixing",
    "foundation.field": "Field",
    "foundation.geometry": "Box Wrap",
    "foundation.run": "Run",
    "giant": "Weave weave",
    "judging": "Score",
    "materials.engines": "for_engine",
    "materials.maps": "height_of normal_of proposed",
    "methods.best_tile": "BestTile",
    "methods.graphcut": "Graphcut",
    "methods.image_quilting": "ImageQuilting",
    "methods.near_regular": "NearRegular",
    "methods.parallel_controllable": "ParallelControllable",
    "methods.random_tiling": "RandomTiling",
    "methods.repeat": "Repeat",
    "model": "Exemplar",
    "model.canvas": "Canvas Guide",
    "model.image": "Kind Plane",
    "model.sourcemap": "SourceMap",
    "published.correction2008.correction_2008": "Correction2008",
    "published.lopez_recas2011.gap_filling": "GapFilling",
    "published.multrus2003.patch_sampling": "PatchSampling",
    "published.pixels.ashikhmin": "Ashikhmin",
    "published.pixels.efros_leung": "EfrosLeung",
    "published.pixels.wei_levoy": "WeiLevoy",
    "published.robinson2004.raster_quilting": "RasterQuilting",
    "published.segments.segment_based": "SegmentBased",
    "rendering.magnification": "magnified",
    "synthesis": "Synthesis synthesize",
    "tasks.advection": "advect",
    "tasks.completion": "Margins extend heal",
    "tasks.exemplar_analysis": "Analysis analyze",
    "tasks.repair": "repair",
    "tasks.report": "report",
    "tasks.scoring": "score",
    "tasks.tileable": "tile",
    "tasks.tileset": "TileSet tileset",
    "tasks.precompile": "warm",
}
"""Module -> its public names; __init__.pyi repeats them for type checkers."""

_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'intarsia' has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
