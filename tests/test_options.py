"""Options of every method, drawn together: what meets is refused in a line, or gives a whole map."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st

import intarsia as ia
from intarsia.foundation.params import AUTO, Parameter, parameters
from intarsia.methods import METHODS, Ability, method_class
from intarsia.tasks.completion import with_hole
from intarsia.testing import texture

SIZE = 36, 45  # px; whole periods of LATTICE
LATTICE = ((9, 0), (0, 6))
POSES = ("none", "180", "both", "auto", (0, 1, 6))
VALUES = {
    "angle": (0, 20), "band": (4, 8), "block": (8, 18), "boundary_isometries": (AUTO, *POSES),
    "boundary_patch": (AUTO, 0, 4), "boundary_tolerance": (AUTO, 0, 3), "border": (4, 6), "candidates": (1, 5),
    "channel_weights": (AUTO, (1, 0, 2)), "evenness": (0, 0.25, 2), "feature": (AUTO, "edges"), "hits": (3, 256),
    "isometries": POSES, "jitter": (AUTO, 0, 0.6, (0, 0.3, 1)), "k": (1, 3), "kappa": (1, 3, "inf"),
    "lattice": (LATTICE,), "levels": (1, 2), "overlap": (2, 3, (2, 4)),
    "overreach": (AUTO, 0, 5), "passes": (1, 2), "patch": (8, 11, (7, 12)), "pin": (AUTO, ((5, 5, 20, 20, 4),)),
    "points": (1, 8), "pyramid_kept": (1, 8), "refinements": (0, 2), "lattice_tolerance": (0, 2), "edge_weight": (0, 1),
    "subpasses": (1, 4, 9), "threshold": (AUTO, 0, 0.5), "tolerance": (0, 0.3), "repeat_penalty": (0, 0.3),
    "window": (3, (3, 5), (2, 7)), "zoom": (1, 1.5),
}  # fmt: skip
"""Name of a parameter -> values that suit a small exemplar; others keep to their choices, or to what is usual."""


def options(slug: str) -> st.SearchStrategy[dict[str, Any]]:
    def values(p: Parameter) -> tuple[Any, ...]:
        return VALUES.get(p.name, p.choices if p.kind == "choice" else (p.default,))

    return st.fixed_dictionaries({p.name: st.sampled_from(values(p)) for p in parameters(method_class(slug))})


USABLE = np.ones((30, 34), bool)
USABLE[20:23, 14:17] = False
EXEMPLAR = ia.Exemplar.of(texture(30, 34, 3, 5), usable=USABLE)
HALVES = [ia.Plane((np.mgrid[:h, :w][0] * 2 // h).astype(np.uint8), "label") for h, w in ((30, 34), SIZE)]


@pytest.mark.parametrize("slug", METHODS)
def test_whatever_meets_is_refused_or_gives_a_whole_map(slug: str) -> None:
    """With pixels that may not be used, a map that is begun, and labels, where a method has them; on two threads."""
    cls = method_class(slug)

    def either(ability: Ability) -> st.SearchStrategy[bool]:
        return st.booleans() if ability in cls.supports else st.just(False)

    @settings(max_examples=16, deadline=None, database=None, derandomize=True, suppress_health_check=list(HealthCheck))
    @given(
        options(slug), st.sampled_from(("none", "x", "both") if Ability.WRAP in cls.supports else ("none",)),
        either(Ability.MASK), either(Ability.START), either(Ability.GUIDE),
    )  # fmt: skip
    def law(given: dict[str, Any], wrap: str, masked: bool, begun: bool, guided: bool) -> None:
        exemplar = EXEMPLAR if masked else ia.Exemplar.of(EXEMPLAR.base)
        start = guide = None
        if begun:
            whole = ia.synthesize(exemplar, SIZE, ia.RandomTiling(patch=8), seed=9, wrap=wrap).map
            start = with_hole(whole, np.arange(SIZE[1]) * np.ones((SIZE[0], 1)) >= 30)
        if guided:
            guide = ia.Guide(*HALVES)
        try:
            method = cls(**given)
            one, two = (
                ia.synthesize(exemplar, SIZE, method, seed=3, wrap=wrap, start=start, guide=guide, run=ia.Run(n)).map
                for n in (1, 2)
            )
        except (ia.ParameterError, ia.InputError, ia.MethodError) as e:
            reject() if "\n" not in str(e) else pytest.fail(f"not one line: {e}")
        assert one.digest == two.digest
        assert not one.holes.any()
        assert (one.yx.min(), *(one.yx.reshape(-1, one.yx.shape[-1]).max(axis=0) < (30, 34))) >= (0, True, True)
        assert not masked or USABLE[one.yx[..., 0], one.yx[..., 1]].all()

    law()
