"""Endless canvases: any window alone, and pictures too large for memory, streamed to the disk."""

from __future__ import annotations

from .texture import Weave, weave

__all__ = ["Weave", "weave"]
