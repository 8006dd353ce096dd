"""Nodes for ComfyUI that grow, tile, heal and judge textures by the library intarsia, in the same process."""

from __future__ import annotations

from comfy_api.latest import ComfyExtension

from .nodes import NODES


class IntarsiaTextures(ComfyExtension):
    """The nodes of the category image/texture."""

    async def get_node_list(self):
        return NODES


async def comfy_entrypoint():
    """Return what ComfyUI loads."""
    return IntarsiaTextures()
