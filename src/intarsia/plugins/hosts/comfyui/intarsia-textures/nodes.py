"""The nodes: what they are called, what they ask for, and which task of intarsia each carries out."""

from __future__ import annotations

import numpy as np
from comfy.model_management import throw_exception_if_processing_interrupted
from comfy.utils import ProgressBar
from comfy_api.latest import io, ui

from .carrying import INPUTS, MAPS, array_of, at, carried_out, count_of, images_of, in_order, integers, library, saying

CATEGORY = "image/texture"
WRAPS = {"both": "both", "left-right": "x", "top-bottom": "y", "no": "none"}
METHODS = ["auto", "graphcut", "image-quilting", "near-regular", "parallel-controllable"]
LARGEST = 16384  # px a side, as in ComfyUI's own nodes


def seed():
    tooltip = "Another number gives another result; the same number the same one, pixel for pixel."
    return io.Int.Input("seed", default=0, min=0, max=2**64 - 1, control_after_generate=True, tooltip=tooltip)


def maps_in():
    """The maps of the same surface, none of which must be given."""
    told = {
        "normal": "Normal map of the same surface; its directions turn with the pieces.",
        "roughness": "Roughness of the same surface.",
        "metallic": "Metallic map of the same surface.",
        "height": "Height, displacement or depth of the same surface.",
        "ao": "Ambient occlusion of the same surface.",
    }
    more = "It is cut together with the image, so that they still fit. It is as large, or a whole multiple."
    return [io.Image.Input(INPUTS[name], optional=True, tooltip=f"{told[name]} {more}") for name in MAPS]


def images_out(first):
    """The outputs in the order of the inputs; their ids differ from those of all inputs."""
    tips = [first, *(f"The {name} map that belongs to it; without one as input, what is linked here is not run."
                     for name in MAPS)]  # fmt: skip
    names = INPUTS.values()
    return [io.Image.Output(f"made_{n}", display_name=n, tooltip=tip) for n, tip in zip(names, tips, strict=True)]


def remarks():
    return io.String.Output("remarks", tooltip="What is worth knowing, such as a size that fits better; else empty.")


def maps_of(inputs):
    """The maps by the names of intarsia's planes."""
    return {name: inputs.get(INPUTS[name]) for name in MAPS}


class GrowTexture(io.ComfyNode):
    @classmethod
    def define_schema(cls):
        return io.Schema(
            node_id="IntarsiaGrow", display_name="Grow Texture", category=CATEGORY,
            description="Grows a texture from the image, of any size and tileable, out of pieces of it. Maps follow.",
            inputs=[
                io.Image.Input("image", tooltip="The example. Each image of a batch is grown by itself."),
                io.Int.Input("width", default=1024, min=16, max=LARGEST, tooltip="Width of the result in px."),
                io.Int.Input("height", default=1024, min=16, max=LARGEST, tooltip="Height of the result in px."),
                io.Combo.Input("tileable", options=list(WRAPS), default="both",
                               tooltip="Across which borders the result continues in itself."),
                io.Combo.Input("method", options=METHODS, default="auto",
                               tooltip="auto: by what the image shows. graphcut: stones, leaves, most photographs. "
                               "image-quilting: quick, for very large results. near-regular: tiles and walls. "
                               "parallel-controllable: pixel by pixel, from coarse to fine."),
                seed(),
                io.Mask.Input("unusable", optional=True,
                              tooltip="White: nothing is taken from here (a logo, a stain, a blurred corner)."),
                *maps_in(),
            ],
            outputs=[*images_out("The grown texture."), remarks()],
        )  # fmt: skip

    @classmethod
    def execute(cls, image, width, height, tileable, method, seed, unusable=None, **maps):
        def call(ia, planes, run, unusable=None):
            exemplar = ia.Exemplar.of(planes, usable=None if unusable is None else ~unusable, name="image")
            return ia.synthesize(exemplar, (height, width), method, seed=seed, wrap=WRAPS[tileable], run=run)

        return io.NodeOutput(*carried_out("Grow Texture", call, image, maps_of(maps), unusable=unusable))


class MakeTileable(io.ComfyNode):
    @classmethod
    def define_schema(cls):
        return io.Schema(
            node_id="IntarsiaTile", display_name="Make Tileable", category=CATEGORY,
            description="Makes the image continue in itself; only a band along its borders changes. Maps follow.",
            inputs=[
                io.Image.Input("image", tooltip="The picture. Each image of a batch is made tileable by itself."),
                io.Combo.Input("tileable", options=[name for name in WRAPS if name != "no"], default="both",
                               tooltip="Across which borders the result continues in itself."),
                io.Combo.Input("crop", options=["to whole periods", "no"], default="to whole periods",
                               tooltip="Walls, tiles and weaves are cut first to as much as repeats. "
                               "no: the result is as large as the image."),
                io.Int.Input("band", default=0, min=0, max=4096,
                             tooltip="Width in px of the band that changes; 0: by the size of what the image shows."),
                seed(),
                *maps_in(),
            ],
            outputs=[*images_out("The tileable image."), remarks()],
        )  # fmt: skip

    @classmethod
    def execute(cls, image, tileable, crop, band, seed, **maps):
        def call(ia, planes, run):
            size = planes["albedo"].shape[:2] if crop == "no" else None
            exemplar = ia.Exemplar.of(planes, name="image")
            return ia.tile(exemplar, axes=WRAPS[tileable], band=band or None, size=size, seed=seed, run=run)

        return io.NodeOutput(*carried_out("Make Tileable", call, image, maps_of(maps)))


class HealTexture(io.ComfyNode):
    @classmethod
    def define_schema(cls):
        return io.Schema(
            node_id="IntarsiaHeal", display_name="Heal Texture", category=CATEGORY,
            description="Fills what the mask marks with pieces of the rest; all else stays. Maps follow.",
            inputs=[
                io.Image.Input("image", tooltip="The picture. Each image of a batch is healed by itself."),
                io.Mask.Input("mask", tooltip="White: what is to be healed. An image without any is left as it is."),
                io.Int.Input("grow_mask", default=-1, min=-1, max=256,
                             tooltip="By how many px the mask is enlarged first; -1: as far as its rim is seen."),
                seed(),
                *maps_in(),
            ],
            outputs=[*images_out("The healed image."), remarks()],
        )  # fmt: skip

    @classmethod
    def execute(cls, image, mask, grow_mask, seed, **maps):
        if not (array_of("mask", mask) >= 0.5).any():
            raise ValueError("mask is all black; paint white what is to be healed.")

        def call(ia, planes, run, mask):
            grow = None if grow_mask < 0 else grow_mask
            exemplar = ia.Exemplar.of(planes, name="image")
            return ia.heal(exemplar, mask, grow=grow, seed=seed, run=run) if mask.any() else None

        return io.NodeOutput(*carried_out("Heal Texture", call, image, maps_of(maps), mask=mask))


class ScoreTexture(io.ComfyNode):
    @classmethod
    def define_schema(cls):
        return io.Schema(
            node_id="IntarsiaScore", display_name="Score Texture", category=CATEGORY,
            description="Judges grown or generated textures against the example: 0 to 100. Lets good ones pass.",
            inputs=[
                io.Image.Input("example", tooltip="What the texture should look like: what it was grown from."),
                io.Image.Input("image", tooltip="The texture to judge; each image of a batch by itself."),
                io.Combo.Input("tileable", options=list(WRAPS), default="both",
                               tooltip="Across which borders it should continue in itself; a step there costs."),
                io.Float.Input("least", default=0.0, min=0.0, max=100.0, step=1.0,
                               tooltip="Images below this score do not pass. 90 and more: clean. 65: some flaws."),
                *maps_in(),
            ],
            outputs=[
                io.Float.Output("score", tooltip="0 to 100, of a batch the lowest."),
                io.String.Output("verdict", tooltip="Score and largest flaw in words, a line for each image."),
                *images_out("The images that reach the least score; if none does, what is linked here is not run."),
            ],
        )  # fmt: skip

    @classmethod
    def execute(cls, example, image, tileable, least, **maps):
        ia = library()
        given = {"albedo": image} | {name: tensor for name, tensor in maps_of(maps).items() if tensor is not None}
        arrays = {INPUTS[name]: array_of(INPUTS[name], tensor) for name, tensor in given.items()}
        arrays["example"] = array_of("example", example)
        count = count_of(arrays)
        bar, scores = ProgressBar(count), []
        for place in range(count):
            throw_exception_if_processing_interrupted()
            with saying(ia, place, count):
                before, after = (ia.Exemplar.of(integers(at(arrays[n], place)), name=n) for n in ("example", "image"))
                scores.append(ia.score(before, after, wrap=WRAPS[tileable]))
            bar.update_absolute(place + 1)
        lines = [f"{found.total:.0f} of 100, {found.verdict}" for found in scores]
        passing = [place for place, found in enumerate(scores) if found.total >= least]
        kept = {n: t[[p if len(t) > 1 else 0 for p in passing]] for n, t in given.items()} if passing else {}
        return io.NodeOutput(float(min(found.total for found in scores)), "\n".join(lines), *in_order(kept))


class TilePreview(io.ComfyNode):
    @classmethod
    def define_schema(cls):
        return io.Schema(
            node_id="IntarsiaTilePreview", display_name="Tile Preview", category=CATEGORY, is_output_node=True,
            description="Shows the image many times side by side, as on a floor: seams and repeats show.",
            inputs=[
                io.Image.Input("image", tooltip="A tileable image."),
                io.Int.Input("times", default=3, min=2, max=8, tooltip="How many times across, and down."),
            ],
            outputs=[io.Image.Output("made_image", display_name="image", tooltip="The image, repeated.")],
        )  # fmt: skip

    @classmethod
    def execute(cls, image, times):
        array = array_of("image", image)
        height, width = (side * times for side in array.shape[1:3])
        if max(height, width) > LARGEST:
            raise ValueError(f"{times} times image is {width}x{height} px, over {LARGEST} a side; choose fewer times.")
        many = images_of([np.tile(integers(picture), (times, times, 1)) for picture in array])
        return io.NodeOutput(many, ui=ui.PreviewImage(many, cls=cls))


NODES = [GrowTexture, MakeTileable, HealTexture, ScoreTexture, TilePreview]
