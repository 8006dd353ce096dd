"""Modules that are imported at their first use, so that listings, help and usage errors stay quick.

The command line reads the parameters of every method; the files of the methods therefore import nothing heavy
at the top. They write::

    if TYPE_CHECKING:
        import numpy as np
    else:
        np = lazy("numpy")
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scipy import ndimage as ndimage


class lazy:
    """Stand for the module `name`; the first attribute asked of it imports it."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        value = getattr(importlib.import_module(self._name), attribute)
        self.__dict__[attribute] = value
        return value


if not TYPE_CHECKING:  # what many files ask for, and few commands
    ndimage = lazy("scipy.ndimage")
