"""Pixels of Krita's layers: to files that the program reads, and from files that it wrote, bit by bit the same."""

import struct
import sys
import zlib
from array import array
from operator import ne, or_

from krita import InfoObject, Krita

from .calling import Trouble

SIZES = {"U8": 1, "U16": 2, "F16": 2, "F32": 4}  # depth -> bytes of a channel
OPAQUE = {"U8": b"\xff", "U16": b"\xff\xff", "F16": b"\x00\x3c", "F32": b"\x00\x00\x80\x3f"}
ORDER = {("GRAYA", False): (0,), ("GRAYA", True): (0, 1), ("RGBA", False): (2, 1, 0), ("RGBA", True): (2, 1, 0, 3)}
"""(model, with alpha) -> which of Krita's whole-number channels is each channel of a PNG."""
COLOUR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}  # of a PNG, by its number of channels
YES = bytes([0] + [255] * 255)
HALF = bytes([0] * 128 + [255] * 128)


class Space:
    """Model, depth and profile of a layer, which its results keep."""

    def __init__(self, node):
        self.model, self.depth, self.profile = node.colorModel(), node.colorDepth(), node.colorProfile()
        if self.model not in ("GRAYA", "RGBA") or self.depth not in SIZES:
            line = f'"{node.name()}" is {self.model} {self.depth}; intarsia reads gray and RGB: '
            raise Trouble(line + "use Image > Convert Image Color Space first.")
        self.channels = len(self.model.replace("GRAYA", "YA"))
        self.size = SIZES[self.depth]
        self.step = self.channels * self.size

    @property
    def words(self):
        """What Krita's functions take."""
        return self.model, self.depth, self.profile

    @property
    def suffix(self):
        """The ending of files that hold this depth."""
        return ".exr" if self.depth.startswith("F") else ".png"

    @property
    def kind(self):
        """The letter of whole numbers that are as wide as a channel."""
        return "BHI"[self.size // 2]

    def alpha(self, pixels):
        """Return the bytes of the opacity alone."""
        return memoryview(pixels).cast(self.kind)[self.channels - 1 :: self.channels].tobytes()

    def is_opaque(self, pixels):
        """Return whether nothing is transparent."""
        return self.alpha(pixels) == OPAQUE[self.depth] * (len(pixels) // self.step)

    def is_empty(self, pixels):
        """Return whether nothing is there."""
        return not self.alpha(pixels).strip(b"\0")


def pixels_of(node, box):
    """Return the bytes of a layer in a box (x, y, width, height)."""
    return bytes(node.pixelData(*box))


def save(space, pixels, width, height, path, resolution=72.0):
    """Write pixels as a PNG, or floats as an EXR; without alpha where nothing is transparent."""
    clear = not space.is_opaque(pixels)
    if space.suffix == ".png":
        order = ORDER[space.model, clear]
        given = memoryview(pixels).cast(space.kind)
        out = array(space.kind, bytes(space.size * len(order) * width * height))
        for here, there in enumerate(order):
            memoryview(out)[here :: len(order)] = given[there :: space.channels]
        if sys.byteorder == "little":
            out.byteswap()
        _write_png(path, width, height, 8 * space.size, len(order), out.tobytes())
        return
    if not clear:  # Krita's own export always has an alpha, which would be grown like a colour
        _write_exr(space, pixels, width, height, path)
        return
    one = document_of(space, pixels, width, height, "intarsia", resolution)
    one.setBatchmode(True)
    options = InfoObject()
    options.setProperty("flatten", True)
    saved = one.exportImage(str(path), options)
    one.setModified(False)
    one.close()
    if not saved:
        raise Trouble(f"Krita could not write {path}; make room there.")


def save_mask(values, width, height, path):
    """Write a mask of 8 bits."""
    _write_png(path, width, height, 8, 1, values)


def _write_png(path, width, height, bits, channels, pixels):
    """Write a PNG, not packed: it lives for a moment, and packing takes longer than writing."""

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(body, zlib.crc32(kind)))

    row = len(pixels) // height
    rows = b"".join(b"\0" + pixels[start : start + row] for start in range(0, len(pixels), row))
    header = struct.pack(">IIBBBBB", width, height, bits, COLOUR_TYPES[channels], 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 0)) + chunk(b"IEND", b"")
    _write(path, b"\x89PNG\r\n\x1a\n" + body)


def _write_exr(space, pixels, width, height, path):
    """Write colours without alpha as an OpenEXR file that is not packed (its File Layout: a chunk for each row)."""
    names = {"Y": 0} if space.channels == 2 else {"B": 2, "G": 1, "R": 0}  # as the file wants them, by name
    number = 1 if space.depth == "F16" else 2

    def attribute(name, kind, body):
        return f"{name}\0{kind}\0".encode() + struct.pack("<I", len(body)) + body

    channels = b"".join(n.encode() + b"\0" + struct.pack("<IIII", number, 0, 1, 1) for n in names) + b"\0"
    window, one = struct.pack("<IIII", 0, 0, width - 1, height - 1), struct.pack("<f", 1)
    head = struct.pack("<II", 20000630, 2) + attribute("channels", "chlist", channels)
    head += attribute("compression", "compression", b"\0") + attribute("dataWindow", "box2i", window)
    head += attribute("displayWindow", "box2i", window) + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", one) + attribute("screenWindowCenter", "v2f", bytes(8))
    head += attribute("screenWindowWidth", "float", one) + b"\0"
    row = width * space.size * len(names)
    starts = range(len(head) + 8 * height, len(head) + 8 * height + (row + 8) * height, row + 8)
    given, parts = memoryview(pixels).cast(space.kind), [head, struct.pack(f"<{height}Q", *starts)]
    for y in range(height):
        line = given[y * width * space.channels : (y + 1) * width * space.channels]
        parts += [struct.pack("<II", y, row), *(line[c :: space.channels].tobytes() for c in names.values())]
    _write(path, b"".join(parts))


def _write(path, body):
    try:
        with open(path, "wb") as file:
            file.write(body)
    except OSError as e:
        raise Trouble(f"{path} cannot be written ({e.strerror}); make room there.") from None


def load(space, path):
    """Return the pixels of a file in a layer's own layout, and its width and height."""
    app = Krita.instance()
    quiet = app.batchmode()
    app.setBatchmode(True)
    try:
        made = app.openDocument(str(path))
    finally:
        app.setBatchmode(quiet)
    if made is None:
        raise Trouble("Krita could not read what intarsia has made.")
    node, width, height = made.rootNode().childNodes()[0], made.width(), made.height()
    same = (node.colorModel(), node.colorDepth()) == (space.model, space.depth)
    pixels = pixels_of(node, (0, 0, width, height)) if same else b""
    made.close()
    if not same:
        raise Trouble("Krita has read what intarsia made with other channels or another depth.")
    return pixels, width, height


def document_of(space, pixels, width, height, name, resolution):
    """Return a new document of one layer with these pixels."""
    made = Krita.instance().createDocument(width, height, name, *space.words, resolution)
    layer = made.rootNode().childNodes()[0]
    layer.setPixelData(pixels, 0, 0, width, height)
    layer.setName(name)
    made.refreshProjection()
    made.waitForDone()
    made.setModified(True)  # so that Krita asks before it is closed
    return made


def add_layer(space, doc, pixels, width, height, name, above):
    """Return a new layer of a document, above another, or on top where that is gone meanwhile."""
    layer, parent = doc.createNode(name, "paintlayer"), above.parentNode()
    own = (layer.colorModel(), layer.colorDepth(), layer.colorProfile()) == space.words
    if own:
        layer.setPixelData(pixels, 0, 0, width, height)
    (parent or doc.rootNode()).addChildNode(layer, above if parent else None)
    if not own:  # a layer that differs from its picture; Krita converts layers only where they are
        layer.setColorSpace(*space.words)
        doc.waitForDone()
        layer.setPixelData(pixels, 0, 0, width, height)
    doc.refreshProjection()
    return layer


def only_changed(space, before, after, chosen, width):
    """Return the pixels of `after` with all transparent that is neither chosen nor other than before.

    `chosen` has a byte for each pixel. Rows without a change are passed over.
    """
    kind, parts = {2: ("H", 1), 4: ("I", 1), 8: ("Q", 1), 16: ("Q", 2)}[space.step]
    row, none = width * space.step, bytes(width)
    out = bytearray(len(after))
    for y in range(len(after) // row):
        part, picked = slice(y * row, (y + 1) * row), chosen[y * width : (y + 1) * width]
        if picked == none and before[part] == after[part]:
            continue
        changed = bytes(map(ne, memoryview(before)[part].cast(kind), memoryview(after)[part].cast(kind)))
        if parts == 2:
            changed = bytes(map(or_, changed[::2], changed[1::2]))
        shown = bytes(map(or_, changed, picked)).translate(YES)
        line = bytearray(after[part])
        for place in range(space.step - space.size, space.step):
            alpha = int.from_bytes(line[place :: space.step], "big") & int.from_bytes(shown, "big")
            line[place :: space.step] = alpha.to_bytes(width, "big")
        out[part] = line
    return bytes(out)
