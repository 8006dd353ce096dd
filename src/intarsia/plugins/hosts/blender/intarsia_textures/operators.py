"""The operators: Grow Texture, Make Tileable and Heal by Mask for an image, Grow Material for a material."""


import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, IntVectorProperty, StringProperty

from . import materials, pictures, settings
from .calling import Trouble
from .running import Running

ENDING = {"grow": "grown", "tile": "tiled", "heal": "healed"}
"""Command -> ending of the names of what it makes."""

_AXES = (
    ("both", "Both Ways", "It continues in itself to all sides"),
    ("x", "Left and Right", "Its left border continues in its right one"),
    ("y", "Top and Bottom", "Its upper border continues in its lower one"),
)
SIZE = IntVectorProperty(
    name="Size", size=2, default=(1024, 1024), min=1, soft_max=8192, max=1 << 20,
    description="Pixels of the result; all elements keep their size. At first twice the example",
)  # fmt: skip
WRAP = EnumProperty(
    name="Tileable", items=(*_AXES, ("none", "No", "The borders are as they come")),
    description="Directions in which the result can be repeated without a seam",
)  # fmt: skip
AXES = EnumProperty(
    name="Tileable", items=_AXES, description="Directions in which the image can be repeated without a seam"
)
KEEP_SIZE = BoolProperty(
    name="Keep the Size",
    description="Otherwise bricks, tiles and weaves may be cut to the largest size in which their pattern closes",
)
METHOD = EnumProperty(
    name="Method", description="How the result is made",
    items=(
        ("auto", "Automatic", "Chosen by what the example is like"),
        ("graphcut", "Free Shapes", "Pieces of any outline: stones, plants, most natural surfaces"),
        ("image-quilting", "Square Pieces", "Squares joined along the least visible cut: fine grain, quick"),
        ("near-regular", "Bricks and Tiles", "Whole periods of a repeating grid: walls, floors, weaves"),
        ("patch-sampling", "Soft Squares", "Squares that fade into each other: clouds, water, soft patterns"),
    ),
)  # fmt: skip
SEED = IntProperty(name="Seed", min=0, description="Another number makes another result; the same one the same")
MASK = StringProperty(
    name="Mask",
    description="An image as large as this one, white where it is to be healed. Empty: where this one is transparent",
)
VERB = EnumProperty(
    name="Make", items=(
        ("grow", "Larger", "A larger material from its example"),
        ("tile", "Tileable", "Only bands along the borders are grown anew"),
    ),
)  # fmt: skip
ASSET = BoolProperty(name="Mark as Asset", description="Show the new material in the Asset Browser")
INPUT = StringProperty(name="Input", options={"HIDDEN", "SKIP_SAVE"})


class Asking(Running):
    """An operator with a dialog. `shown` are its fields; `input` is the name of what is worked on, for the redo."""

    shown = ()
    input: INPUT
    seed: SEED

    def invoke(self, context, event):
        """Open the dialog."""
        try:
            settings.program(context)
            self.prepare(context)
        except Trouble as trouble:
            return self._failed(trouble)
        self._asked = True
        return context.window_manager.invoke_props_dialog(self, width=320, title=self.title, confirm_text="Start")

    @property
    def title(self):
        """What stands above the dialog."""
        return self.bl_label

    def draw(self, context):
        """Draw the dialog and the redo panel."""
        layout = self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        for name in self.shown:
            self.draw_field(layout, name)

    def draw_field(self, layout, name):
        """Draw one field."""
        if name == "size":
            column = layout.column(align=True)
            column.prop(self, "size", index=0, text="Width")
            column.prop(self, "size", index=1, text="Height")
        elif name == "mask":
            layout.prop_search(self, "mask", bpy.data, "images")
        else:
            layout.prop(self, name)

    def set_size(self, image):
        """Set the size to twice that of an image if nobody has set it."""
        if "size" in self.shown and not self.properties.is_property_set("size"):
            self.size = [2 * side for side in image.size]


class OfImage(Asking):
    """An operator that makes a new image of one."""

    def prepare(self, context):
        """Find the image, and return it."""
        if not self.input:
            image = getattr(context.space_data, "image", None)
            if image is None:
                raise Trouble("There is no image; open one in the Image Editor.")
            self.input = image.name
        image = bpy.data.images.get((self.input, None)) or bpy.data.images.get(self.input)
        if image is None:
            raise Trouble(f"There is no image {self.input}.")
        pictures.check(image)
        self.set_size(image)
        return image

    def take(self, context, folder):
        """Write the image."""
        image = self.prepare(context)
        self.old = tuple(image.size)
        return {"image": pictures.write(image, folder, pictures.file_stem(image))}

    def put(self, context, made):
        """Take in the new image, and show it in the editor."""
        new = pictures.read(made["image"], self._given["image"], ENDING[self.verb])
        new.use_fake_user = True  # else a file that is saved does not hold what no material uses
        if getattr(context.space_data, "type", "") == "IMAGE_EDITOR":
            context.space_data.image = new
        return new.name


class GrowTexture(OfImage, bpy.types.Operator):
    """Make a new, larger image from this one as an example"""

    bl_idname, bl_label, verb = "image.intarsia_grow", "Grow Texture", "grow"
    shown = ("size", "wrap", "method", "seed")
    size: SIZE
    wrap: WRAP
    method: METHOD

    def wishes(self):
        """Return what the dialog says, in words of the command."""
        return ["--size", f"{self.size[0]}x{self.size[1]}", "--wrap", self.wrap, "--method", self.method]


class MakeTileable(OfImage, bpy.types.Operator):
    """Make a new image of this one that can be repeated without a seam; only bands along its borders change"""

    bl_idname, bl_label, verb = "image.intarsia_tile", "Make Tileable", "tile"
    shown = ("axes", "keep_size", "seed")
    axes: AXES
    keep_size: KEEP_SIZE

    def wishes(self):
        """Return what the dialog says, in words of the command."""
        return _bands(self)


def _bands(operator):
    """Return how bands are grown anew, in words of the command."""
    size = ["--size", f"{operator.old[0]}x{operator.old[1]}"] if operator.keep_size else []
    return ["--axes", operator.axes, *size]


class HealByMask(OfImage, bpy.types.Operator):
    """Make a new image of this one whose marked places are filled with what suits there"""

    bl_idname, bl_label, verb = "image.intarsia_heal", "Heal by Mask", "heal"
    shown = ("mask", "wrap", "seed")
    mask: MASK
    wrap: EnumProperty(
        name="Tileable", items=(("none", "No", "The borders are plain ones"), *_AXES),
        description="Directions in which the image is tileable already, so that holes at its borders stay so",
    )  # fmt: skip

    def take(self, context, folder):
        """Write the image and the mask."""
        given, self._mask = super().take(context, folder), None
        if self.mask:
            mask = bpy.data.images.get(self.mask)
            if mask is None or self.mask == self.input:
                raise Trouble("Choose another image as the mask, or none: then what is transparent is healed.")
            self._mask = pictures.write(mask, folder, "the_mask")
        elif not pictures.has_alpha(bpy.data.images[self.input]):
            raise Trouble(f"{pictures.called(self.input)} has no transparency; choose an image as the mask.")
        return given

    def further_names(self):
        """Return the name of the mask."""
        return {str(self._mask.file): pictures.called(self._mask.name)} if self._mask else {}

    def wishes(self):
        """Return what the dialog says, in words of the command."""
        return ["--mask", self._mask.file if self._mask else "alpha", "--wrap", self.wrap]


class GrowMaterial(Asking, bpy.types.Operator):
    """Make a copy of this material whose images are grown together, so that they still lie on each other"""

    bl_idname, bl_label = "material.intarsia_grow", "Grow Material"
    verb: VERB
    size: SIZE
    wrap: WRAP
    axes: AXES
    keep_size: KEEP_SIZE
    asset: ASSET

    @property
    def title(self):
        """What stands above the dialog."""
        return self.bl_label if self.verb == "grow" else "Make Material Tileable"

    @property
    def shown(self):
        """The fields of the dialog."""
        return ("verb", *(("size", "wrap") if self.verb == "grow" else ("axes", "keep_size")), "seed", "asset")

    def prepare(self, context):
        """Find the material, and return its maps."""
        if not self.input:
            found = [getattr(context.space_data, "id", None), getattr(context, "material", None)]
            found = [one for one in found if isinstance(one, bpy.types.Material)]
            material = found[0] if found else getattr(context.object, "active_material", None)
            if material is None:
                raise Trouble("There is no material; select an object that has one.")
            self.input = material.name
        material = bpy.data.materials.get((self.input, None)) or bpy.data.materials.get(self.input)
        if material is None:
            raise Trouble(f"There is no material {self.input}.")
        maps = materials.maps_of(material)
        self.set_size(maps[0].image)
        return maps

    def take(self, context, folder):
        """Write the maps."""
        maps = self.prepare(context)
        self._object = context.object.name if context.object else ""
        self.old = tuple(maps[0].image.size)
        self._nodes = {one.plane: one.nodes for one in maps}
        self._packed = "".join(one.packed for one in maps)
        stems = [maps[0].plane if maps[0].plane in materials.TOLD else "albedo", *(one.plane for one in maps[1:])]
        return {one.plane: pictures.write(one.image, folder, stem) for one, stem in zip(maps, stems, strict=True)}

    def wishes(self):
        """Return what the dialog says, in words of the command."""
        packed = ["--packed", self._packed] if self._packed else []
        if self.verb == "tile":
            return [*_bands(self), *packed]
        return ["--size", f"{self.size[0]}x{self.size[1]}", "--wrap", self.wrap, *packed]

    def put(self, context, made):
        """Take in the images, and give the copy of the material to the object."""
        old = bpy.data.materials.get((self.input, None))
        if old is None:
            raise Trouble(f"The material {self.input} is gone.")
        images, ending = {}, ENDING[self.verb]
        try:
            for plane, file in made.items():
                images[plane] = pictures.read(file, self._given[plane], ending)
            new = materials.copied(old, ending, [(self._nodes[plane], image) for plane, image in images.items()])
        except (Trouble, KeyError) as e:
            for image in images.values():
                bpy.data.images.remove(image)
            raise e if isinstance(e, Trouble) else Trouble(f"The nodes of {self.input} were changed meanwhile.") from e
        materials.give(new, old, bpy.data.objects.get(self._object))
        if self.asset:
            new.asset_mark()
            if not bpy.app.background:  # a render, which waits there
                new.asset_generate_preview()
        return new.name


OF_IMAGES = (GrowTexture, MakeTileable, HealByMask)
CLASSES = (*OF_IMAGES, GrowMaterial)
