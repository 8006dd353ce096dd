"""Carrying images of ComfyUI into intarsia, one by one, and its results back.

ComfyUI's images are floats (N, H, W, C) of stored colour, 0 to 1; intarsia takes floats for linear light. Therefore
pictures go there as integers: 8 bit where they hold no more, else 16.
"""

from __future__ import annotations

import importlib
import logging
import re
import sys
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import torch
from comfy.model_management import processing_interrupted, throw_exception_if_processing_interrupted
from comfy.utils import ProgressBar
from comfy_execution.graph_utils import ExecutionBlocker

NEEDED = "0.2.0"  # the first intarsia that these nodes work with
CONTRACT = 1  # what it promises to plug-ins; the nodes belong to one with the same number
MAPS = ("normal", "roughness", "metallic", "height", "ao")
INPUTS = {"albedo": "image", **{name: f"{name}_map" for name in MAPS}}  # plane of intarsia -> name in the node


def library():
    """Return intarsia; RuntimeError with the command that helps if it is missing, or belongs to other nodes.

    Asked when a node runs, so that the node itself says what is amiss.
    """
    help_ = f'"{sys.executable}" -m pip install --upgrade "intarsia>={NEEDED}", and start ComfyUI again'
    try:
        ia = importlib.import_module("intarsia")
    except ImportError:
        raise RuntimeError(f"intarsia is missing in the Python of ComfyUI; run {help_}.") from None
    try:
        contract = importlib.import_module("intarsia.plugins").CONTRACT
    except (ImportError, AttributeError):
        contract = None
    if contract == CONTRACT:
        return ia
    if _numbers(ia.__version__) < _numbers(NEEDED):
        raise RuntimeError(f"intarsia {ia.__version__} is too old for these nodes; run {help_}.")
    raise RuntimeError(
        f"intarsia {ia.__version__} and these nodes do not belong together; install the nodes that come with it, or "
        f"run {help_}."
    )


def _numbers(version):
    return [int(number) for number in re.findall(r"\d+", version)[:3]]


def array_of(name, tensor):
    """Return an image or a mask as a float array; ValueError if it holds nothing, or what is no number."""
    array = np.asarray(tensor.cpu(), np.float32)
    if not array.size:
        raise ValueError(f"{name} holds no image; link one that does.")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds pixels that are no numbers (NaN); look at what the node before it makes.")
    return array


def integers(picture):
    """Return a picture of floats as 8 bit if it holds no more than these, else as 16 bit."""
    eight = np.rint(picture * 255)
    if np.abs(eight - picture * 255).max() < 1e-3:  # the next of 16 bits is 4e-3 away
        return eight.clip(0, 255).astype(np.uint8)
    return np.rint(picture.clip(0, 1) * 65535).astype(np.uint16)


def images_of(pictures):
    """Return pictures (H, W, C) of integers as an image of ComfyUI; gray ones get three channels, as nodes expect."""
    floats = [p.astype(np.float32) / np.iinfo(p.dtype).max for p in pictures]
    floats = [f if f.shape[2] > 1 else f.repeat(3, axis=2) for f in floats]
    sizes = sorted({f"{f.shape[1]}x{f.shape[0]}" for f in floats})
    if len(sizes) > 1:
        raise ValueError(
            f"the images of the batch repeat after other lengths and become {' and '.join(sizes)} px; set crop to no."
        )
    return torch.from_numpy(np.stack(floats))


def marked(name, mask, image):
    """Return a mask as a bool array (N, H, W), True where it is white.

    A black one of any size marks nothing: Load Image gives one of 64 px for pictures without transparency.
    """
    array = array_of(name, mask)
    white = array.reshape(-1, *array.shape[-2:]) >= 0.5
    if not white.any():
        return np.zeros((1, *image.shape[1:3]), bool)
    if white.shape[1:] != image.shape[1:3]:
        raise ValueError(
            f"{name} is {white.shape[2]}x{white.shape[1]} px, image {image.shape[2]}x{image.shape[1]}; make them equal."
        )
    return white


def count_of(arrays):
    """Return how many images a batch holds; ValueError unless each input holds one, or as many as the others."""
    largest = max(arrays, key=lambda name: len(arrays[name]))
    count = len(arrays[largest])
    for name, array in arrays.items():
        if len(array) not in (1, count):
            raise ValueError(f"{name} holds {len(array)} images, {largest} {count}; link 1 or {count}.")
    return count


def at(array, place):
    """Return what a batch holds at a place; a batch of one holds the same everywhere."""
    return array[place if len(array) > 1 else 0]


def told(line, place, count, mask="mask"):
    """Return a line of intarsia in the words of the node, and of a batch with the number of the image."""
    line = re.sub(r"the plane (\w+)", lambda found: INPUTS.get(found[1], found[0]), line)
    line = re.sub(r"the (base|exemplar)\b", "image", line).replace("the mask", mask)
    line = re.sub(r"--size \d+x\d+ keeps", "crop = no keeps", line)
    return f"image {place + 1} of {count}: {line}" if count > 1 else line


@contextmanager
def saying(ia, place, count, mask="mask"):
    """Turn errors of intarsia into a line that names the node's inputs, and a cancelled run into ComfyUI's own."""
    try:
        yield
    except ia.CancelledError:
        throw_exception_if_processing_interrupted()
        raise
    except ia.IntarsiaError as error:
        raise ValueError(told(str(error), place, count, mask)) from None


def carried_out(title, call, image, maps, **masks):
    """Make a picture of each image of a batch, with its maps; return them in the order of the outputs, and remarks.

    `call(exemplar planes, run, **masks at that place)` returns a Synthesis, or None if nothing is to be changed.
    Progress goes to the node's bar; ComfyUI's interrupt ends the work at its next step.
    """
    ia = library()
    given = {name: array_of(INPUTS[name], t) for name, t in {"albedo": image, **maps}.items() if t is not None}
    whites = {name: marked(name, mask, given["albedo"]) for name, mask in masks.items() if mask is not None}
    count = count_of({INPUTS[name]: array for name, array in given.items()} | whites)
    bar, quiet = ProgressBar(100 * count), ia.Run(cancel=SimpleNamespace(is_set=processing_interrupted))
    made, remarks = {name: [] for name in given}, []
    for place in range(count):

        def step(done, total, draft, place=place):
            bar.update_absolute(int(100 * (place + done / max(total, 1))))

        planes = {name: integers(at(array, place)) for name, array in given.items()}
        run = ia.Run(step=step, cancel=quiet.cancel)
        with saying(ia, place, count, *whites):
            run.check()
            found = call(ia, planes, run, **{name: at(white, place) for name, white in whites.items()})
            for name, plane in planes.items():
                made[name].append(plane if found is None else found.render(name, run=quiet).samples)
        remarks += [told(note, place, count) for note in dict.fromkeys(run.notes)]
        bar.update_absolute(100 * (place + 1))
    for remark in remarks:
        logging.info("%s: %s", title, remark)
    return [*in_order({name: images_of(pictures) for name, pictures in made.items()}), "\n".join(remarks)]


def in_order(images):
    """Return images by plane in the order of the outputs; what is linked to a map that is not there is not run."""
    return [images[name] if name in images else ExecutionBlocker(None) for name in INPUTS]
