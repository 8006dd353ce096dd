"""The procedural exemplars are what they say: always the same, of the stated kind and lattice."""

import numpy as np
import pytest
from scipy.ndimage import shift
from torture import LATTICES, TORTURE

LOOSE = {  # how well the picture agrees with itself, moved by a lattice vector, where it is no exact copy
    "brick_subpixel": 0.9,
    "brick_colours": 0.3,
    "brick_warped": 0.35,
    "text_lines": 0.25,
}


def agreement(picture: np.ndarray, dy: float, dx: float) -> float:
    """Correlation of a picture with itself moved by a vector, over the px that overlap."""
    gray = picture.reshape(*picture.shape[:2], -1).astype(float)
    gray = gray - gray.mean(axis=(0, 1))
    moved = shift(gray, (dy, dx, 0), order=1)
    top, left = int(np.ceil(abs(dy))), int(np.ceil(abs(dx)))
    box = np.s_[top:, left:] if dx >= 0 else np.s_[top:, :-left]
    a, b = gray[box], moved[box]
    a, b = a - a.mean(axis=(0, 1)), b - b.mean(axis=(0, 1))
    return float((a * b).sum() / np.sqrt((a * a).sum() * (b * b).sum()))


def test_they_are_always_the_same_and_fresh():
    assert len(TORTURE) == 38
    for make in TORTURE.values():
        first, second = make(), make()
        assert first.tobytes() == second.tobytes()
        assert not np.shares_memory(first, second)


@pytest.mark.parametrize("name", LATTICES)
def test_lattice_vectors_move_the_texture_onto_itself(name):
    picture = TORTURE[name]()
    for dy, dx in LATTICES[name]:
        here = agreement(picture, dy, dx)
        assert here > LOOSE.get(name, 0.85), (dy, dx, here)
        # a true vector is a peak: two px beside it across the pattern it is worse
        beside = [agreement(picture, dy + 2, dx), agreement(picture, dy, dx + 2)]
        assert min(beside) < here - 0.1
        assert here >= max(beside) - 0.02


def test_special_values():
    assert set(np.unique(TORTURE["labels"]())) == {0, 1, 2}
    assert np.count_nonzero(TORTURE["one_pixel"]() != 128) == 1
    vectors = TORTURE["normals"]().astype(float) / 127.5 - 1
    assert np.allclose(np.linalg.norm(vectors, axis=2), 1, atol=0.02)
    alpha = TORTURE["alpha_islands"]()[..., 3]
    assert min((alpha == 0).mean(), (alpha == 255).mean()) > 0.2
    ramp = TORTURE["ramp_16bit"]()
    assert len(np.unique(ramp >> 8)) < 5
    assert len(np.unique(ramp)) > 200
    step = np.abs(np.diff(TORTURE["jpeg_blocky"]().astype(float), axis=1)).mean(axis=0)
    seam = np.arange(1, len(step) + 1) % 8 == 0
    assert step[seam].mean() > 1.3 * step[~seam].mean()
