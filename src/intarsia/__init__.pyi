"""Names of the package, as type checkers read them."""

from .analysis.illumination import flattened as flattened
from .choosing.auto import Auto as Auto
from .files import read as read
from .files import write as write
from .foundation import CancelledError as CancelledError
from .foundation import InputError as InputError
from .foundation import IntarsiaError as IntarsiaError
from .foundation import MethodError as MethodError
from .foundation import ParameterError as ParameterError
from .foundation.blend import Blend as Blend
from .foundation.blend import Levelling as Levelling
from .foundation.blend import Mixing as Mixing
from .foundation.field import Field as Field
from .foundation.geometry import Box as Box
from .foundation.geometry import Wrap as Wrap
from .foundation.run import Run as Run
from .giant import Weave as Weave
from .giant import weave as weave
from .judging import Score as Score
from .materials.engines import for_engine as for_engine
from .materials.maps import height_of as height_of
from .materials.maps import normal_of as normal_of
from .materials.maps import proposed as proposed
from .methods.best_tile import BestTile as BestTile
from .methods.graphcut import Graphcut as Graphcut
from .methods.image_quilting import ImageQuilting as ImageQuilting
from .methods.near_regular import NearRegular as NearRegular
from .methods.parallel_controllable import ParallelControllable as ParallelControllable
from .methods.random_tiling import RandomTiling as RandomTiling
from .methods.repeat import Repeat as Repeat
from .model import Exemplar as Exemplar
from .model.canvas import Canvas as Canvas
from .model.canvas import Guide as Guide
from .model.image import Kind as Kind
from .model.image import Plane as Plane
from .model.sourcemap import SourceMap as SourceMap
from .published.correction2008.correction_2008 import Correction2008 as Correction2008
from .published.lopez_recas2011.gap_filling import GapFilling as GapFilling
from .published.multrus2003.patch_sampling import PatchSampling as PatchSampling
from .published.pixels.ashikhmin import Ashikhmin as Ashikhmin
from .published.pixels.efros_leung import EfrosLeung as EfrosLeung
from .published.pixels.wei_levoy import WeiLevoy as WeiLevoy
from .published.robinson2004.raster_quilting import RasterQuilting as RasterQuilting
from .published.segments.segment_based import SegmentBased as SegmentBased
from .rendering.magnification import magnified as magnified
from .synthesis import Synthesis as Synthesis
from .synthesis import synthesize as synthesize
from .tasks.advection import advect as advect
from .tasks.completion import Margins as Margins
from .tasks.completion import extend as extend
from .tasks.completion import heal as heal
from .tasks.exemplar_analysis import Analysis as Analysis
from .tasks.exemplar_analysis import analyze as analyze
from .tasks.precompile import warm as warm
from .tasks.repair import repair as repair
from .tasks.report import report as report
from .tasks.scoring import score as score
from .tasks.tileable import tile as tile
from .tasks.tileset import TileSet as TileSet
from .tasks.tileset import tileset as tileset

__version__: str
__all__: list[str]
_HOMES: dict[str, str]
