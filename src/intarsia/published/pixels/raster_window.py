"""The window parameter of raster-scan methods: rows from the pixel up, columns to both sides."""

from __future__ import annotations

from dataclasses import dataclass

from ...foundation import ParameterError
from ...foundation.params import AUTO, extent, param, words
from ...methods import MethodBase


@dataclass(frozen=True)
class RasterWindow(MethodBase):
    """Base of raster-scan methods.

    `stage`: of a method's random draws, different from that of others; `widest`: most columns of automatic windows;
    `at_once`: pixels filled between two progress reports.
    """

    window: int | tuple[int, int] | None = param(
        AUTO, "extent", "neighbourhood that is compared: w_e columns, odd, and h_e rows from the pixel up; automatic: "
        "as wide as the texture's elements (up to 13 px, of ashikhmin 9), and half as high",
        low=1, high=255, unit="px",
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.window is not AUTO and (extent(self.window)[1] % 2 == 0 or extent(self.window) == (1, 1)):
            raise ParameterError(f"window={words(self.window)} is not allowed; choose an odd width, and not 1x1.")
