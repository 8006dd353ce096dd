"""Images of Blender as files for the program, and its files as images of Blender."""

import re
import shutil
from array import array
from pathlib import Path
from typing import NamedTuple

import bpy

from .calling import Trouble

ENDINGS = {
    "PNG": ".png", "JPEG": ".jpg", "TIFF": ".tif", "OPEN_EXR": ".exr", "HDR": ".hdr", "TARGA": ".tga",
    "TARGA_RAW": ".tga", "BMP": ".bmp", "WEBP": ".webp",
}  # fmt: skip
"""Formats whose files the program reads -> their endings."""

MADE = {".tif": ".tif", ".exr": ".exr", ".hdr": ".exr"}
"""Endings of files -> those of what is made of them without loss; PNG for all others."""

REFUSED = {
    "SEQUENCE": "is a sequence of pictures; open one of them as a single image",
    "MOVIE": "is a movie; open one frame of it as a single image",
    "TILED": "has UDIM tiles; open one of them as a single image",
    "VIEWER": "is what a render or a viewer shows; save it as a picture, and open that",
}
"""Sources of images that are not worked on, and what is said of them."""


class Given(NamedTuple):
    """An image that was handed to the program. Words alone: undo can take the image itself away meanwhile."""

    name: str
    file: Path
    space: str
    alpha_mode: str


def called(name):
    """Return the name of an image as messages can show it."""
    return "".join(c for c in name if c.isprintable()).strip()[:90] or "the image"


def check(image):
    """Raise Trouble for an image that cannot be worked on."""
    if image.library is not None:
        raise Trouble(f"{image.name} is linked from another file; make it local first, in the Outliner.")
    why = REFUSED.get(image.source)
    if why is None and image.type == "MULTILAYER":
        why = "has several layers; save one of them as a picture, and open that"
    if why is None and min(image.size) < 1:
        why = "has no pixels; its file is missing, or damaged"
    if why is not None:
        raise Trouble(f"{image.name} {why}.")


def has_alpha(image):
    """Return whether an image has an alpha channel in its file, or would have in one."""
    return image.depth == (128 if image.is_float else 32)


def write(image, folder, stem):
    """Write an image to a folder for the program.

    Where a file has its pixels, they are the bytes of that file, so that depth and colours stay as they are.
    """
    check(image)
    ending, file = ENDINGS.get(image.file_format), Path(bpy.path.abspath(image.filepath))
    packed = image.packed_file
    if ending is None or image.is_dirty or image.source != "FILE" or not (packed or file.is_file()):
        return _write_pixels(image, folder, stem)
    out = folder / f"{stem}{ending}"
    try:
        if packed:
            out.write_bytes(packed.data)
        else:
            shutil.copyfile(file, out)
    except OSError as e:
        raise Trouble(f"{image.name} cannot be read or copied ({e.strerror or e}).") from None
    return Given(image.name, out, image.colorspace_settings.name, image.alpha_mode)


def _write_pixels(image, folder, stem):
    """Write the pixels that Blender holds: those that were painted, or generated, have no file.

    A second image takes them, as saving changes the first, and a copy of it has no painted pixels. That of floats is
    marked Non-Color, else they pass a view transform.
    """
    pixels = array("f", bytes(4 * len(image.pixels)))
    image.pixels.foreach_get(pixels)
    own = image.colorspace_settings
    second = bpy.data.images.new(
        "intarsia", *image.size, alpha=has_alpha(image), float_buffer=image.is_float, is_data=own.is_data
    )
    try:
        linear = second.colorspace_settings.name
        second.colorspace_settings.name = "Non-Color" if image.is_float else own.name
        second.pixels.foreach_set(pixels)
        out = folder / (f"{stem}.exr" if image.is_float else f"{stem}.png")
        second.file_format, second.filepath_raw = "OPEN_EXR" if image.is_float else "PNG", str(out)
        second.save()
    except RuntimeError as e:
        raise Trouble(f"{image.name} cannot be written ({e}).") from None
    finally:
        bpy.data.images.remove(second)
    if image.is_float:
        return Given(image.name, out, linear, "")
    return Given(image.name, out, own.name, image.alpha_mode)


def file_stem(image):
    """Return the stem of an image's file, which tells the program what it holds, such as brick_normal."""
    own = re.split(r"[/\\]", image.filepath)[-1] or image.name
    return re.sub(r"[^\w.-]", "_", re.sub(r"\.\w+$", "", own)).strip(".-") or "image"


def read(file, given, ending):
    """Return a new image that holds the pixels of a file, packed, with the colour space of what was given."""
    try:
        made = bpy.data.images.load(str(file))
    except RuntimeError as e:
        raise Trouble(f"What was made of {given.name} cannot be read ({e}).") from None
    made.name = f"{re.sub(r'[.][a-zA-Z]+$', '', given.name)}_{ending}"
    made.colorspace_settings.name = given.space
    if given.alpha_mode:
        made.alpha_mode = given.alpha_mode
    made.pack()
    made.filepath_raw = f"//textures/{made.name}{Path(file).suffix}"  # where it would be unpacked
    return made
