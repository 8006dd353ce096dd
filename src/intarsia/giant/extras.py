"""Packages of the extra ``giant``: imported when they are needed, missed in one line."""

from __future__ import annotations

import importlib
from typing import Any

from ..errors import MissingExtraError


def extra(module: str) -> Any:
    """Import a module of the extra; MissingExtraError names what installs it."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as e:
        name = (e.name or module).partition(".")[0]
        raise MissingExtraError(f"{name} is not installed; run: pip install 'intarsia[giant]'") from None
