"""Blender: textures and materials grown from an example by the program intarsia, which runs beside Blender."""

import bpy

from . import operators, settings

CLASSES = (*settings.CLASSES, *operators.CLASSES)


def _in_image(self, context):
    column = self.layout.column()
    column.separator()
    column.enabled = context.space_data.image is not None
    for operator in operators.OF_IMAGES:
        column.operator(operator.bl_idname, text=f"{operator.bl_label}...")


def _in_material(self, context):
    self.layout.separator()
    name = operators.GrowMaterial.bl_idname
    self.layout.operator(name, text="Grow Material...").verb = "grow"
    self.layout.operator(name, text="Make Material Tileable...").verb = "tile"


def _in_nodes(self, context):
    if context.space_data.tree_type == "ShaderNodeTree" and context.space_data.shader_type == "OBJECT":
        _in_material(self, context)


MENUS = (("IMAGE_MT_image", _in_image), ("NODE_MT_node", _in_nodes), ("MATERIAL_MT_context_menu", _in_material))


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)
    for menu, draw in MENUS:
        getattr(bpy.types, menu).append(draw)


def unregister():
    for menu, draw in MENUS:
        getattr(bpy.types, menu).remove(draw)
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
