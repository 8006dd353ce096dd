"""Worker process: labels proposed for an exemplar, so many things, told apart by what their surroundings hold.

Pixels are sorted into kinds by colour and roughness; surroundings that hold kinds in the same shares get one label.
Then every label learns its shares, and every pixel takes the label that explains its surroundings best, in turns.
"""

from __future__ import annotations

import numpy as np
from scipy.cluster.vq import kmeans2

from ...analysis import enlarged, factor_for, reduced
from ...analysis.features import features
from ...foundation import ndimage
from ...foundation.arrays import Array
from ...model import Exemplar
from ...segments.felzenszwalb import DEVIATION, even_colours
from .decoding import exemplar_of, png
from .worker import Answer, Json, Tell

SIDE = 256  # px: longest side of the reduced copy that is looked at
KINDS = 24
TRIES = (16, 16, 6, 6, 2)  # px of surroundings; of all tries the one is taken that explains most
ROUNDS = 12
PRICE = 5.0  # nats a px of border; 3: stones of one wall are two things, 8: bricks and mortar are one
LEAST = 200  # regions of less than one part in so many belong to what is around them


def propose(said: Json, tell: Tell) -> Answer:
    """Return `count` labels as PNG of one channel, of the exemplar's size."""
    return {}, png(labels_of(exemplar_of(said["paths"]), said["count"])[:, :, None])


def labels_of(exemplar: Exemplar, count: int) -> Array:
    """Return labels (H, W), uint8, from 0, the largest, to `count` - 1; a constant exemplar has one."""
    feats = features([exemplar])
    picture = feats.pictures[0][:, :, : feats.base]
    factor = factor_for(picture.shape, SIDE)
    even = even_colours(*reduced(picture, exemplar.usable, factor))
    if even is None:
        return np.zeros(picture.shape[:2], np.uint8)
    colours = even / DEVIATION
    rough = _blurred(np.linalg.norm(colours - _blurred(colours, 3), axis=2, keepdims=True), 2)
    kinds = _clusters(np.dstack([_blurred(colours, 1), rough]), KINDS, 0)
    tries = [_labelled(kinds, count, reach, seed) for seed, reach in enumerate(TRIES)]
    labels = min(tries, key=lambda found: found[0])[1]
    order = np.argsort(-np.bincount(labels.ravel(), minlength=count))
    return enlarged(np.argsort(order).astype(np.uint8)[labels], picture.shape[:2], factor)


def _blurred(picture: Array, reach: float) -> Array:
    return ndimage.gaussian_filter(picture, (reach, reach, 0))


def _clusters(picture: Array, count: int, seed: int) -> Array:
    """Return to which cluster each pixel of a picture (H, W, C) belongs."""
    return kmeans2(picture.reshape(-1, picture.shape[2]), count, minit="++", seed=seed)[1].reshape(picture.shape[:2])


def _labelled(kinds: Array, count: int, reach: int, seed: int) -> tuple[tuple[int, float], Array]:
    """Return labels, and before them how many are missing, and what their borders cost less what they explain."""
    labels = _clusters(np.sqrt(_blurred(np.eye(KINDS, dtype=np.float32)[kinds], reach)), count, seed)
    for _ in range(ROUNDS):
        within = np.bincount((labels * KINDS + kinds).ravel(), minlength=count * KINDS).reshape(count, KINDS) + 1
        told = np.log(within / within.sum(axis=1, keepdims=True)).T[kinds]
        labels = _blurred(told, reach / 2).argmax(axis=2)
    apart = np.zeros(labels.shape, bool)
    for n in range(count):
        regions, _ = ndimage.label(labels == n)
        apart |= (np.bincount(regions.ravel()) * LEAST < labels.size)[regions]
    if not apart.all():
        labels = labels[tuple(ndimage.distance_transform_edt(apart, return_distances=False, return_indices=True))]
    borders = np.count_nonzero(np.diff(labels)) + np.count_nonzero(np.diff(labels, axis=0))
    explained = np.take_along_axis(told, labels[:, :, None], 2).sum()
    return (count - len(np.unique(labels)), PRICE * borders - explained), labels
