"""Krita: grow textures from a layer, make it tileable, heal what is selected. The program intarsia does the work."""

from krita import Krita

from .extension import Textures

Krita.instance().addExtension(Textures(Krita.instance()))
