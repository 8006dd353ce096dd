"""Tests that every method has to pass; a new one is tested by naming it.

    from intarsia.testing import MethodContract

    class TestMyMethod(MethodContract):
        method = MyMethod(patch=12)

pytest then runs every law of the package that the method's ``supports`` claims, on small exemplars of all kinds
that hypothesis draws. What it does not claim must be refused.

Needs pytest and hypothesis; a line ``pytest.register_assert_rewrite("intarsia.testing")`` in conftest.py makes failures
tell more.
"""

from .cases import (
    Case,
    as_depth,
    cases,
    exemplars,
    looked_up,
    noise,
    same_map,
    same_pixels,
    texture,
)
from .contract import MethodContract

__all__ = [
    "Case",
    "MethodContract",
    "as_depth",
    "cases",
    "exemplars",
    "looked_up",
    "noise",
    "same_map",
    "same_pixels",
    "texture",
]
