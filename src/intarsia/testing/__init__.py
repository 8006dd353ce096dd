"""Contract tests (property-based) that every synthesis method has to pass.

    from intarsia.testing import MethodContract

    class TestMyMethod(MethodContract):
        method = MyMethod(patch=12)

Subclass :class:`MethodContract` and name the method. pytest then tests every law of the package for the abilities in
the method's ``supports``, on small exemplars of all kinds drawn by hypothesis. Other abilities must be refused.

Needs pytest and hypothesis; a line ``pytest.register_assert_rewrite("intarsia.testing")`` in conftest.py gives more
detailed failures.
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
