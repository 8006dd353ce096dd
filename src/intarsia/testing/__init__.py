"""Tests that every method, search and store has to pass; a new one is tested by naming it.

    from intarsia.testing import MethodContract

    class TestMyMethod(MethodContract):
        method = MyMethod(patch=12)

pytest then runs every law of the package that the method's ``supports`` claims, on small exemplars of all kinds
that hypothesis draws. What it does not claim must be refused. A way to find patches and a kind of store are tested
alike, by saying how one is made:

    class TestMySearch(SearchContract):
        def make(self, scene):
            return MySearch(scene.variants, scene.patch)

    class TestMyStore(StoreContract):
        def make(self, picture, path, force=False):
            return MyStore(picture, path, self.sides, self.origin, force)

        def read(self, path):
            return pixels_of(path)

(`StorePromises` for one that does not go on where it was stopped.)

Needs pytest and hypothesis; a line ``pytest.register_assert_rewrite("intarsia.testing")`` in conftest.py makes failures
tell more.
"""

from .cases import Case, as_depth, cases, exemplars, noise, texture
from .contract import MethodContract
from .maps import looked_up, replayed, same_map, same_pixels, unbroken
from .search import SearchContract, SearchScene
from .store import StoreContract, StorePromises

__all__ = [
    "Case",
    "MethodContract",
    "SearchContract",
    "SearchScene",
    "StoreContract",
    "StorePromises",
    "as_depth",
    "cases",
    "exemplars",
    "looked_up",
    "noise",
    "replayed",
    "same_map",
    "same_pixels",
    "texture",
    "unbroken",
]
