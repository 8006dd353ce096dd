"""Grow textures from an example: a small picture goes in, a larger one made of its pieces comes out.

    import intarsia as ia
    wall = ia.synthesize("brick.png", (1024, 1024), ia.ImageQuilting(patch=96), seed=7, wrap="both")
    ia.write("wall.png", wall.render())

Everything is imported at its first use, so that ``import intarsia`` costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .version import VERSION

__version__ = VERSION

_HOMES = {
    "Ashikhmin": "published.pixels.ashikhmin",
    "Auto": "choosing.auto",
    "BestTile": "methods.best_tile",
    "Blend": "blend",
    "Box": "geometry",
    "Canvas": "canvas",
    "CancelledError": "errors",
    "EfrosLeung": "published.pixels.efros_leung",
    "Exemplar": "exemplar",
    "Field": "field",
    "Findings": "tasks.inspection",
    "GapFilling": "published.lopez_recas2011.gap_filling",
    "Graphcut": "methods.graphcut",
    "Guide": "guide",
    "ImageQuilting": "methods.image_quilting",
    "InputError": "errors",
    "IntarsiaError": "errors",
    "Kind": "image",
    "Levelling": "blend",
    "Margins": "tasks.completion",
    "MethodError": "errors",
    "Mixing": "blend",
    "NearRegular": "methods.near_regular",
    "ParameterError": "errors",
    "ParallelControllable": "methods.parallel_controllable",
    "PatchSampling": "published.multrus2003.patch_sampling",
    "Plane": "image",
    "RandomTiling": "methods.random_tiling",
    "RasterQuilting": "published.robinson2004.raster_quilting",
    "Repeat": "methods.repeat",
    "Run": "run",
    "Score": "judging.score",
    "SegmentBased": "published.segments.segment_based",
    "SourceMap": "sourcemap",
    "Synthesis": "synthesis",
    "Weave": "giant",
    "WeiLevoy": "published.pixels.wei_levoy",
    "Wrap": "geometry",
    "advect": "tasks.advection",
    "analyze": "tasks.inspection",
    "extend": "tasks.completion",
    "flattened": "analysis.light",
    "heal": "tasks.completion",
    "magnified": "rendering.magnification",
    "read": "files",
    "repair": "tasks.repair",
    "report": "tasks.report",
    "score": "tasks.scoring",
    "synthesize": "synthesis",
    "tile": "tasks.tileable",
    "warm": "tasks.warming",
    "weave": "giant",
    "write": "files",
}

__all__ = [
    "Ashikhmin",
    "Auto",
    "BestTile",
    "Blend",
    "Box",
    "CancelledError",
    "Canvas",
    "EfrosLeung",
    "Exemplar",
    "Field",
    "Findings",
    "GapFilling",
    "Graphcut",
    "Guide",
    "ImageQuilting",
    "InputError",
    "IntarsiaError",
    "Kind",
    "Levelling",
    "Margins",
    "MethodError",
    "Mixing",
    "NearRegular",
    "ParallelControllable",
    "ParameterError",
    "PatchSampling",
    "Plane",
    "RandomTiling",
    "RasterQuilting",
    "Repeat",
    "Run",
    "Score",
    "SegmentBased",
    "SourceMap",
    "Synthesis",
    "Weave",
    "WeiLevoy",
    "Wrap",
    "advect",
    "analyze",
    "extend",
    "flattened",
    "heal",
    "magnified",
    "read",
    "repair",
    "report",
    "score",
    "synthesize",
    "tile",
    "warm",
    "weave",
    "write",
]

if TYPE_CHECKING:
    from .analysis.light import flattened
    from .blend import Blend, Levelling, Mixing
    from .canvas import Canvas
    from .choosing.auto import Auto
    from .errors import CancelledError, InputError, IntarsiaError, MethodError, ParameterError
    from .exemplar import Exemplar
    from .field import Field
    from .files import read, write
    from .geometry import Box, Wrap
    from .giant import Weave, weave
    from .guide import Guide
    from .image import Kind, Plane
    from .judging.score import Score
    from .methods.best_tile import BestTile
    from .methods.graphcut import Graphcut
    from .methods.image_quilting import ImageQuilting
    from .methods.near_regular import NearRegular
    from .methods.parallel_controllable import ParallelControllable
    from .methods.random_tiling import RandomTiling
    from .methods.repeat import Repeat
    from .published.lopez_recas2011.gap_filling import GapFilling
    from .published.multrus2003.patch_sampling import PatchSampling
    from .published.pixels.ashikhmin import Ashikhmin
    from .published.pixels.efros_leung import EfrosLeung
    from .published.pixels.wei_levoy import WeiLevoy
    from .published.robinson2004.raster_quilting import RasterQuilting
    from .published.segments.segment_based import SegmentBased
    from .rendering.magnification import magnified
    from .run import Run
    from .sourcemap import SourceMap
    from .synthesis import Synthesis, synthesize
    from .tasks.advection import advect
    from .tasks.completion import Margins, extend, heal
    from .tasks.inspection import Findings, analyze
    from .tasks.repair import repair
    from .tasks.report import report
    from .tasks.scoring import score
    from .tasks.tileable import tile
    from .tasks.warming import warm


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'intarsia' has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
