"""Principal axes are the same on every machine: signs are fixed, and equal variances have an order."""

from __future__ import annotations

import numpy as np
import pytest

from intarsia.analysis import principal_axes


def turned(values: list[float], seed: int) -> np.ndarray:
    """A covariance with these variances along axes that lie anyhow."""
    axes = np.linalg.qr(np.random.default_rng(seed).standard_normal((len(values),) * 2))[0]
    return np.asarray(axes @ np.diag(values) @ axes.T)


@pytest.mark.parametrize("seed", range(20))
def test_the_largest_entry_of_every_axis_is_positive(seed: int) -> None:
    variance, axes = principal_axes(turned([9.0, 5.0, 2.0, 1.0, 0.5], seed), 3)
    assert variance == pytest.approx(16, rel=1e-3)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)
    assert (axes[np.arange(3), np.abs(axes).argmax(axis=1)] > 0).all()


@pytest.mark.parametrize("seed", range(20))
def test_equal_variances_have_axes_that_no_rounding_turns(seed: int) -> None:
    """What another library rounds otherwise changes a covariance in its last digits; the axes stay where they are."""
    whole = turned([4.0, 4.0, 4.0, 1.0, 1.0], seed)
    rounded = whole + 1e-14 * turned([1.0, -1.0, 2.0, 0.5, -2.0], seed + 100)
    one, two = (principal_axes(c, 4)[1] for c in (whole, rounded))
    np.testing.assert_allclose(one, two, atol=1e-6)
