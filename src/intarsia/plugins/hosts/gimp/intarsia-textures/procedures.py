"""What the menus offer: labels, fields, and what each does with its layers."""

from __future__ import annotations

from dataclasses import dataclass, field

import pictures
from gi.repository import Gimp, GObject
from pictures import Refused, bounds_of, common, place_of


@dataclass(frozen=True)
class Field:
    """A field of a dialog, and an argument of GIMP of this kind; `more` are its range and default."""

    name: str
    label: str
    tip: str
    kind: str = "int"
    more: tuple = ()
    values: dict = field(default_factory=dict)

    def add_to(self, made):
        more = self.more
        if self.values:
            choice, default = Gimp.Choice.new(), next(iter(self.values))
            for n, (value, text) in enumerate(self.values.items()):
                choice.add(value, n, text, "")
            more = (choice, default)
        add = getattr(made, f"add_{self.kind}_argument")
        add(self.name, self.label, self.tip, *more, GObject.ParamFlags.READWRITE)


def whole(name, label, tip, low, high, default):
    return Field(name, label, tip, more=(low, high, default))


def one_of(name, label, tip, values):
    """Return a field with these values and their texts; the first is the default."""
    return Field(name, label, tip, "choice", values=values)


def other_layer(label, tip):
    may_be_none = True
    return Field("source", label, tip, "layer", (may_be_none,))


@dataclass(frozen=True)
class Wanted:
    """An entry of a menu. `check(image, layers)` refuses before the dialog; `work(task)` may return a new image."""

    label: str
    menu: str
    blurb: str
    sections: list
    work: object
    check: object = lambda image, layers: pictures.maps_of(layers)
    only_with: dict = field(default_factory=dict)

    @property
    def title(self):
        return self.label.replace("_", "").rstrip(".")


def around(bounds, reach, place):
    """Return bounds grown by so many px, within a place; with 0 the whole place."""
    x, y, width, height = bounds
    return common((x - reach, y - reach, width + 2 * reach, height + 2 * reach), place) if reach else place


def met(image, layer):
    """Return the bounds of the selection, or of the layer without one, within the layer; Refused if there are none."""
    box = common(bounds_of(image) or place_of(layer), place_of(layer))
    if min(box[2:]) < 1:
        raise Refused(f"The selection lies outside of {layer.get_name()}.")
    return box


def check_selection(image, layers):
    if bounds_of(image) is None:
        raise Refused("Select what is to be healed first.")
    met(image, pictures.maps_of(layers)[0][2])


def heal(task):
    """Fill the selection from what is around it."""
    image, maps, by = task.image, task.maps, task.value("enlarge")
    layer, take = maps[0][2], task.value("take")
    with pictures.grown(image, by) as copy:
        bounds = common(bounds_of(copy), place_of(layer))
        box = around(bounds, task.value("reach"), place_of(layer))
        bits = pictures.selected(copy, box)
    if 0 not in bits:
        raise Refused("The selection covers all; select less, or choose Edit > Fill Selection from Layer.")
    given, hole = task.given(box), task.file("hole1.tif", "selection")
    pictures.save_mask(bits, box[2:], hole)
    words = ["heal", *given, "--mask", hole, "--grow", 0]
    if take == "other":
        words += ["--from", source_of(task)]
    elif take != "around":
        usable = task.file("usable1.tif", "what may be taken")
        pictures.save_mask(beside(bounds, box, take), box[2:], usable)
        words += ["--usable", usable]
    made, _ = task.run(*words)
    with pictures.one_step(image):
        if not by:
            put_all(made, maps, box)
            return
        with pictures.other_selection(image, lambda image: Gimp.Selection.grow(image, by)):
            put_all(made, maps, box)


def beside(bounds, box, take):
    """Return bytes that are 255 left and right of the bounds, or above and below, at least 64 px wide; else 0."""
    across = 1 if take == "sides" else 0
    wide = max(bounds[2 + across], min(64, box[2 + across]))
    start = bounds[across] - box[across] - (wide - bounds[2 + across]) // 2
    first, end = max(start, 0), min(start + wide, box[2 + across])
    width, height = box[2:]
    if across:
        return bytes(first * width) + b"\xff" * ((end - first) * width) + bytes((height - end) * width)
    return (bytes(first) + b"\xff" * (end - first) + bytes(width - end)) * height


def source_of(task):
    """Write the other layer in the type of this image; return its file."""
    source = task.value("source")
    if source is None:
        raise Refused("Choose the layer that pixels are taken from.")
    if len(task.maps) > 1:
        raise Refused("Maps of a material take pixels from themselves; select one layer.")
    path = task.file("source1.tif", source.get_name())
    pictures.save(source, place_of(source), path, task.image)
    return path


def put_all(made, maps, box):
    for what, _, layer in maps:
        pictures.put(made[what], layer, box)


def check_transparent(image, layers):
    layer = pictures.maps_of(layers)[0][2]
    if not layer.has_alpha():
        raise Refused(f"{layer.get_name()} has no transparency; select what is to be healed, and use Heal Selection.")
    met(image, layer)


def heal_transparent(task):
    """Fill what is transparent."""
    image, maps = task.image, task.maps
    layer = maps[0][2]
    box = around(met(image, layer), task.value("reach") if bounds_of(image) else 0, place_of(layer))
    made, _ = task.run("heal", *task.given(box), "--mask", "alpha", "--grow", task.value("enlarge"))
    with pictures.one_step(image):
        put_all(made, maps, box)


def extend(task):
    """Continue layers beyond their borders; the canvas grows where they reach beyond it."""
    image, maps = task.image, task.maps
    left, right, top, bottom = sides = [task.value(side) for side in ("left", "right", "top", "bottom")]
    if not any(sides):
        raise Refused("Give the width of at least one side.")
    x, y, width, height = place_of(maps[0][2])
    options = ["--left", left, "--right", right, "--top", top, "--bottom", bottom]
    made, (wide, high) = task.run("extend", *task.given((x, y, width, height)), *options, *alpha_of(maps))
    new_x, new_y = min(0, x - left), min(0, y - top)
    right_end, bottom_end = max(image.get_width(), x - left + wide), max(image.get_height(), y - top + high)
    with pictures.one_step(image):
        if (new_x, new_y, right_end, bottom_end) != (0, 0, image.get_width(), image.get_height()):
            image.resize(right_end - new_x, bottom_end - new_y, -new_x, -new_y)
        with pictures.other_selection(image, Gimp.Selection.none):
            for what, _, layer in maps:
                layer.resize(wide, high, left, top)
                pictures.put(made[what], layer, place_of(layer))


def alpha_of(maps):
    """Opacity is a channel to be made like the colours, so that it stays."""
    return ["--alpha", "channel"] if maps[0][2].has_alpha() else []


def tile(task):
    """Make layers tileable, or the rectangle around the selection."""
    image, maps = task.image, task.maps
    box = met(image, maps[0][2])
    whole = (0, 0, image.get_width(), image.get_height())
    crops = task.value("crop") and bounds_of(image) is None and box == whole
    words = ["tile", *task.given(box), "--axes", task.value("axes"), *alpha_of(maps)]
    if not crops:
        words += ["--size", f"{box[2]}x{box[3]}"]
    if task.value("band"):
        words += ["--band", task.value("band")]
    made, size = task.run(*words)
    with pictures.one_step(image):
        if size != box[2:]:
            image.crop(*size, (box[2] - size[0]) // 2, (box[3] - size[1]) // 2)
        put_all(made, maps, (*box[:2], *size))


def grow(task):
    """Grow a new image from the selection, or from the layer."""
    image, maps = task.image, task.maps
    box = met(image, maps[0][2])
    words = ["grow", *task.given(box), "--wrap", task.value("wrap"), "--method", task.value("method")]
    words += ["--size", f"{task.value('width')}x{task.value('height')}"]
    if bounds_of(image) and 0 in (bits := pictures.selected(image, box)):
        usable = task.file("usable1.tif", "selection")
        pictures.save_mask(bits, box[2:], usable)
        words += ["--mask", usable]
    made, _ = task.run(*words)
    new = pictures.load(made[maps[0][0]], image)
    for n, (what, _, layer) in enumerate(maps):
        if n:
            other = pictures.load(made[what], image)
            new.insert_layer(Gimp.Layer.new_from_drawable(other.get_layers()[0], new), None, n)
            other.delete()
        new.get_layers()[n].set_name(layer.get_name())
    if new.get_precision() != image.get_precision():
        new.convert_precision(image.get_precision())
    _, across, down = image.get_resolution()
    new.set_resolution(across, down)
    new.set_selected_layers([new.get_layers()[0]])
    new.undo_enable()
    return new


def check_single(image, layers):
    if len(layers) > 1:
        raise Refused("Select one layer, which is filled.")
    met(image, layers[0])


def fill(task):
    """Fill the selection, or the layer, with a texture grown from another layer."""
    image, maps = task.image, task.maps
    box = met(image, maps[0][2])
    words = ["grow", source_of(task), "--size", f"{box[2]}x{box[3]}", "--wrap", task.value("wrap")]
    made, _ = task.run(*words, "--method", task.value("method"))
    with pictures.one_step(image):
        put_all(made, maps, box)


SEED = whole("seed", "S_eed", "Another number gives another picture, the same number the same one.", 0, 2**31 - 1, 0)
METHOD = one_of(
    "method", "_Method", "How it is put together. Automatic measures the picture, and chooses.",
    {
        "auto": "Automatic", "image-quilting": "Square pieces", "patch-sampling": "Soft squares",
        "graphcut": "Free shapes", "near-regular": "Bricks and tiles",
    },
)  # fmt: skip
DIRECTIONS = {"both": "In both directions", "x": "Left to right", "y": "Top to bottom"}
WRAP = one_of(
    "wrap", "_Tileable", "Where it continues in itself, so that copies can be laid side by side.",
    DIRECTIONS | {"none": "No"},
)  # fmt: skip
UNWRAPPED = one_of("wrap", WRAP.label, WRAP.tip, {"none": "No"} | DIRECTIONS)
ENLARGE = whole(
    "enlarge", "E_nlarge by (px)", "It is grown so much first, so that soft edges and shadows go, too.", 0, 200, 2
)
REACH = whole(
    "reach", "_Within (px)", "How far around it pixels may come from. 0: from the whole layer, slow in photographs.",
    0, 10_000, 300,
)  # fmt: skip
ENHANCE, RENDER, MAP = (f"<Image>/Filters/{menu}" for menu in ("Enhance", "Render", "Map"))
EDIT = "<Image>/Edit"


def _side(label):
    name = label.replace("_", "").lower()
    return whole(name, f"{label} (px)", "What is added on this side", 0, 65_536, 100)


SIDES = [_side(label) for label in ("Le_ft", "Ri_ght", "_Top", "_Bottom")]


PROCEDURES = {
    "plug-in-intarsia-heal": Wanted(
        "_Heal Selection...", ENHANCE, "Fills the selection with what suits there.",
        [
            ("What is healed", [ENLARGE]),
            (
                "Where pixels come from",
                [
                    one_of(
                        "take", "_Take pixels from", "Where what is filled in may come from.",
                        {
                            "around": "All around", "sides": "Left and right of it",
                            "above-below": "Above and below it", "other": "Another layer",
                        },
                    ),
                    other_layer("Other la_yer", "The layer, of any open image, that pixels are taken from."),
                    REACH,
                ],
            ),
            ("Variant", [SEED]),
        ],
        heal, check_selection, {"source": ("take", "other")},
    ),
    "plug-in-intarsia-heal-transparency": Wanted(
        "Heal _Transparency...", ENHANCE, "Fills what is transparent with what suits there.",
        [("What is healed", [ENLARGE]), ("Where pixels come from", [REACH]), ("Variant", [SEED])],
        heal_transparent, check_transparent,
    ),
    "plug-in-intarsia-uncrop": Wanted(
        "_Uncrop...", ENHANCE, "Continues the layer beyond its borders.",
        [("What is added", SIDES), ("Variant", [SEED])],
        extend,
    ),
    "plug-in-intarsia-grow": Wanted(
        "_Grow Texture...", RENDER, "Grows a new image from the selection, or from the layer.",
        [
            (
                "The new image",
                [
                    whole("width", "_Width (px)", "Width of the new image", 1, 65_536, 1024),
                    whole("height", "Hei_ght (px)", "Height of the new image", 1, 65_536, 1024),
                    WRAP,
                ],
            ),
            ("Look", [METHOD, SEED]),
        ],
        grow, lambda image, layers: met(image, pictures.maps_of(layers)[0][2]),
    ),
    "plug-in-intarsia-tile": Wanted(
        "Make Ti_leable...", MAP, "Changes a band along the borders, so that the layer continues in itself.",
        [
            (
                "What changes",
                [
                    one_of("axes", "_Directions", "Where it is to continue in itself.", DIRECTIONS),
                    whole("band", "_Band (px)", "How much is made anew along the borders. 0: automatic.", 0, 4096, 0),
                    Field(
                        "crop", "Crop to _whole rows", "Where rows or a grid repeat, keep as many as fit, so that "
                        "they close. Only with nothing selected, and a layer as large as the image.",
                        "boolean", (True,),
                    ),
                ],
            ),
            ("Variant", [SEED]),
        ],
        tile, lambda image, layers: met(image, pictures.maps_of(layers)[0][2]),
    ),
    "plug-in-intarsia-fill": Wanted(
        "Fill Selection from La_yer...", EDIT, "Fills the selection with a texture grown from another layer.",
        [
            (
                "What it is made of",
                [other_layer("Te_xture", "The layer, of any open image, that the texture is grown from.")],
            ),
            ("Look", [METHOD, UNWRAPPED, SEED]),
        ],
        fill, check_single,
    ),
}  # fmt: skip
