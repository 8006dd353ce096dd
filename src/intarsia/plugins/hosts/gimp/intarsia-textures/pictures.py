"""Layers of GIMP as files of the program, and back: the same numbers in the same depth, whatever profile they wear.

A file is a TIFF without compression. Its numbers are read from a copy of the layer that is relabelled as sRGB, so that
nothing is converted; linear integers, halves and doubles go as floats.
"""

from __future__ import annotations

import re
import struct
import sys
from contextlib import contextmanager

from gi.repository import Gegl, Gimp, Gio

INTEGERS = {
    Gimp.Precision.U8_NON_LINEAR: "u8",
    Gimp.Precision.U8_PERCEPTUAL: "u8",
    Gimp.Precision.U16_NON_LINEAR: "u16",
    Gimp.Precision.U16_PERCEPTUAL: "u16",
}
BYTES = {"u8": 1, "u16": 2, "float": 4}

WORDS = {
    "albedo": "basecolor basecolour base_color base_colour albedo diff diffuse col color colour",
    "normal": "normal normals nrm norm nor_gl normalgl normal_gl normal_ogl normal_opengl nrm_gl "
    "nor_dx normaldx normal_dx normal_directx nrm_dx",
    "roughness": "roughness rough",
    "metallic": "metallic metalness metal",
    "height": "height disp displacement bump",
    "ao": "ao ambientocclusion ambient_occlusion occlusion",
    "orm": "orm occlusionroughnessmetallic",
    "arm": "arm",
    "rma": "rma",
    "packed": "packed",
    "opacity": "opacity alpha",
    "emission": "emission emissive",
    "specular": "specular spec gloss",
}
"""The maps of a material, and the endings of names that mean them: those of the program's files."""


class Refused(Exception):
    """One line for the person: this picture cannot be worked on."""


def map_of(name):
    """Return what map a layer is by its name, and the ending that says so; albedo without one."""
    tokens = [t for t in re.split(r"[^0-9A-Za-z]+", re.sub(r"\.\w{2,4}$| copy( #?\d+)?$| ?#\d+$", "", name)) if t]
    while tokens and re.fullmatch(r"\d+k?|\d+x\d+", tokens[-1].lower()):
        tokens.pop()
    for length in (2, 1):
        word = "_".join(tokens[-length:]).lower()
        for what, words in WORDS.items():
            if len(tokens) >= length and word in words.split():
                return what, word
    return "albedo", "albedo"


def maps_of(layers):
    """Return the layers as maps of one material, the picture first: (map, ending, layer)."""
    found = [(*map_of(layer.get_name()), layer) for layer in layers]
    if len(found) == 1:
        return found
    known = {}
    for what, _, layer in found:
        if what in known:
            both = f"{known[what].get_name()} and {layer.get_name()} both are the {what}"
            raise Refused(f"{both}; select one, or let names end in normal, roughness, height...")
        known[what] = layer
    if "albedo" not in known:
        raise Refused("Select the picture, too, not only its maps; all but one of the names end in that of a map.")
    first = known["albedo"]
    for layer in layers:
        if place_of(layer) != place_of(first):
            raise Refused(f"{layer.get_name()} and {first.get_name()} must have one size, and lie at one place.")
    return sorted(found, key=lambda one: list(WORDS).index(one[0]))


def place_of(layer):
    """Return the rectangle of a layer in its image: x, y, width, height."""
    _, x, y = layer.get_offsets()
    return x, y, layer.get_width(), layer.get_height()


def common(one, other):
    """Return what two rectangles have in common; a width or height below 1: nothing."""
    x, y = max(one[0], other[0]), max(one[1], other[1])
    right, bottom = min(one[0] + one[2], other[0] + other[2]), min(one[1] + one[3], other[1] + other[3])
    return x, y, right - x, bottom - y


def bounds_of(image):
    """Return the bounds of the selection in the image, or None where nothing is selected."""
    _, some, x, y, right, bottom = Gimp.Selection.bounds(image)
    return (x, y, right - x, bottom - y) if some else None


def kind_of(image):
    """Return the type of the numbers that the program gets."""
    return INTEGERS.get(image.get_precision(), "float")


def format_of(kind, gray, alpha):
    """Return the name of a pixel format; floats are linear."""
    sign = "" if kind == "float" else "'"
    return f"{'Y' if gray else 'R{0}G{0}B'}{{0}}{'A' * alpha} {kind}".format(sign)


def fresh(like, width, height):
    """Return an empty image with the type, depth and profile of another; floats are linear."""
    precision = like.get_precision() if kind_of(like) != "float" else Gimp.Precision.FLOAT_LINEAR
    image = Gimp.Image.new_with_precision(width, height, like.get_base_type(), precision)
    image.undo_disable()
    label(image, like.get_color_profile())
    return image


def label(image, profile):
    """Give an image a profile; its numbers stay."""
    if profile is not None:
        image.set_color_profile(profile)


def plain(image):
    """Label an image as sRGB, so that pixel formats without a space hold its own numbers."""
    gray, linear = image.get_base_type() == Gimp.ImageBaseType.GRAY, kind_of(image) == "float"
    made = Gimp.ColorProfile
    if gray:
        label(image, made.new_d65_gray_linear() if linear else made.new_d65_gray_srgb_trc())
    else:
        label(image, made.new_rgb_srgb_linear() if linear else made.new_rgb_srgb())


def save(layer, box, path, like=None):
    """Write a part of a layer, x, y, width, height in the image, in the type of its image, or of `like`."""
    like = like or layer.get_image()
    x, y, width, height = box
    left, top, *_ = place_of(layer)
    image = fresh(like, layer.get_width(), layer.get_height())
    try:
        copy = Gimp.Layer.new_from_drawable(layer, image)
        image.insert_layer(copy, None, 0)
        if image.get_color_profile() is not None:
            plain(image)
        kind, gray, alpha = kind_of(like), copy.is_gray(), copy.has_alpha()
        area = Gegl.Rectangle.new(x - left, y - top, width, height)
        bits = copy.get_buffer().get(area, 1.0, format_of(kind, gray, alpha), Gegl.AbyssPolicy.NONE)
        write_tiff(path, (width, height), kind, (1 if gray else 3) + alpha, alpha, bits)
    finally:
        image.delete()


def save_mask(bits, size, path):
    """Write a mask: white where a byte is not 0."""
    write_tiff(path, size, "u8", 1, False, bits.translate(bytes([0]) + bytes([255]) * 255))


def write_tiff(path, size, kind, channels, alpha, bits):
    """Write pixels as a TIFF without compression, in the order of bytes of this computer."""
    width, height = size
    wide = struct.pack(f"={channels}H", *[8 * BYTES[kind]] * channels).ljust(8, b"\0")
    sorts = struct.pack(f"={channels}H", *[3 if kind == "float" else 1] * channels).ljust(8, b"\0")
    start = 8 + len(bits) + len(bits) % 2
    entries = [
        (256, 4, 1, width), (257, 4, 1, height), (258, 3, channels, wide), (259, 3, 1, 1),
        (262, 3, 1, 2 if channels > 2 else 1), (273, 4, 1, 8), (277, 3, 1, channels), (278, 4, 1, height),
        (279, 4, 1, len(bits)), (284, 3, 1, 1), *[(338, 3, 1, 2)] * alpha, (339, 3, channels, sorts),
    ]  # fmt: skip
    table, more = struct.pack("=H", len(entries)), b""
    for tag, form, count, value in entries:
        table += struct.pack("=HHI", tag, form, count)
        if not isinstance(value, bytes):
            table += struct.pack("=I" if form == 4 else "=HH", *([value] if form == 4 else [value, 0]))
        elif count <= 2:
            table += value[:4]
        else:
            table += struct.pack("=I", start + 2 + 12 * len(entries) + 4 + len(more))
            more += value
    with open(path, "wb") as file:
        file.write((b"II*\0" if sys.byteorder == "little" else b"MM\0*") + struct.pack("=I", start))
        file.write(bits + b"\0" * (len(bits) % 2) + table + struct.pack("=I", 0) + more)


def load(path, like):
    """Return an image with one layer: what the program made, with the profile of another image."""
    image = Gimp.file_load(Gimp.RunMode.NONINTERACTIVE, Gio.File.new_for_path(str(path)))
    image.undo_disable()
    if kind_of(like) == "float":
        image = _linear(image)
    label(image, like.get_color_profile())
    return image


def _linear(read):
    """Return floats that GIMP takes for coded as the linear ones that they are."""
    layer = read.get_layers()[0]
    width, height, gray, alpha = layer.get_width(), layer.get_height(), layer.is_gray(), layer.has_alpha()
    coded = read.get_precision() != Gimp.Precision.FLOAT_LINEAR
    area = Gegl.Rectangle.new(0, 0, width, height)
    form = format_of("float", gray, alpha)
    bits = layer.get_buffer().get(
        area, 1.0, re.sub("([RGBY])", r"\1'", form) if coded else form, Gegl.AbyssPolicy.NONE
    )
    image = Gimp.Image.new_with_precision(width, height, read.get_base_type(), Gimp.Precision.FLOAT_LINEAR)
    image.undo_disable()
    sort = getattr(Gimp.ImageType, f"{'GRAY' if gray else 'RGB'}{'A' * alpha}_IMAGE")
    new = Gimp.Layer.new(image, layer.get_name(), width, height, sort, 100, Gimp.LayerMode.NORMAL)
    image.insert_layer(new, None, 0)
    new.get_buffer().set(area, form, bits)
    read.delete()
    return image


def put(path, layer, box):
    """Put what the program made into a part of a layer: undone in one step, obeying the selection and locked alpha."""
    made = load(path, layer.get_image())
    try:
        x, y, width, height = box
        left, top, *whole = place_of(layer)
        drawn = made.get_layers()[0]
        if (drawn.get_width(), drawn.get_height()) != (width, height):
            raise Refused(f"intarsia made {drawn.get_width()}x{drawn.get_height()} px instead of {width}x{height}.")
        shadow = layer.get_shadow_buffer()
        if [width, height] != whole:
            area = Gegl.Rectangle.new(0, 0, *whole)
            layer.get_buffer().copy(area, Gegl.AbyssPolicy.NONE, shadow, area)
        there = Gegl.Rectangle.new(x - left, y - top, width, height)
        drawn.get_buffer().copy(Gegl.Rectangle.new(0, 0, width, height), Gegl.AbyssPolicy.NONE, shadow, there)
        shadow.flush()
        layer.merge_shadow(True)
        layer.update(there.x, there.y, width, height)
    finally:
        made.delete()


def selected(image, box):
    """Return the bytes of the selection in a rectangle of the image, 0 to 255."""
    area = Gegl.Rectangle.new(*box)
    return image.get_selection().get_buffer().get(area, 1.0, "Y u8", Gegl.AbyssPolicy.NONE)


@contextmanager
def grown(image, by):
    """Give an image whose selection is that of another, grown by so many px; the other one stays as it is."""
    width, height = image.get_width(), image.get_height()
    copy = Gimp.Image.new(width, height, Gimp.ImageBaseType.GRAY)
    try:
        channel = Gimp.Channel.new(copy, "selection", width, height, 50, Gegl.Color.new("red"))
        copy.insert_channel(channel, None, 0)
        area = Gegl.Rectangle.new(0, 0, width, height)
        image.get_selection().get_buffer().copy(area, Gegl.AbyssPolicy.NONE, channel.get_buffer(), area)
        channel.update(0, 0, width, height)
        copy.select_item(Gimp.ChannelOps.REPLACE, channel)
        if by:
            Gimp.Selection.grow(copy, by)
        yield copy
    finally:
        copy.delete()


@contextmanager
def one_step(image):
    """All changes of the image within are one step of undo, also when they fail."""
    image.undo_group_start()
    try:
        yield
    finally:
        image.undo_group_end()
        Gimp.displays_flush()


@contextmanager
def other_selection(image, change):
    """Change the selection for a while, within a step of undo; ``change(image)``."""
    layers = image.get_selected_layers()
    kept = None if Gimp.Selection.is_empty(image) else Gimp.Selection.save(image)
    change(image)
    try:
        yield
    finally:
        if kept is None:
            Gimp.Selection.none(image)
        else:
            image.select_item(Gimp.ChannelOps.REPLACE, kept)
            image.remove_channel(kept)
            image.set_selected_layers(layers)
