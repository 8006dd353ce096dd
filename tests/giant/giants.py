"""What the tests of endless textures share: small textures, and stores read back."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import intarsia as ia
from intarsia.testing import texture

SMALL = ia.NearRegular(lattice=((20, 0), (0, 17)), block=16, border=4, lattice_tolerance=1)


def small(feather: int = 0, **planes: np.ndarray) -> ia.Weave:
    """A texture of rows and columns, 80 x 77 px; quick to weave."""
    pixels = {"albedo": texture(80, 77, 3, 1)} | planes
    return ia.weave(pixels, SMALL, 5, blend=ia.Blend(feather))


def files_below(path: Path) -> dict[str, bytes]:
    """Every file that a weave made, by its name."""
    beside = [p for p in path.parent.glob(f"{path.name}*") if p.is_file()]
    inside = [p for p in path.rglob("*") if p.is_file()]
    return {str(p)[len(str(path)) :]: p.read_bytes() for p in (*beside, *inside)}


def needs(module: str) -> Any:
    """Import a module of the extra `giant`; skip the test where it is missing. Pytest counts what is skipped here."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError:
        pytest.skip(f"{module} is not installed: pip install 'intarsia[giant]'")
