"""One run of the program for one layer: what goes in, what it is asked, and where its result goes."""

from pathlib import Path

from krita import Krita

from . import layers
from .calling import Call, Folder, Trouble

ENDINGS = {"tile": "tileable", "heal": "healed", "grow": "grown"}


def chosen_layer(doc):
    """Return the layer that a person works on; Trouble if it is none that holds pixels."""
    if doc is None:
        raise Trouble("No picture is open; open one first.")
    node = doc.activeNode() or next(iter(doc.rootNode().childNodes()), None)
    if node is None:
        raise Trouble("The picture has no layer; add a paint layer.")
    if node.type() != "paintlayer":
        raise Trouble(f'"{node.name()}" is no paint layer; choose one, or use Layer > Convert > to Paint Layer.')
    return node


def example_box(doc):
    """Return the box (x, y, width, height) of the selection within the canvas, or the canvas."""
    chosen, width, height = doc.selection(), doc.width(), doc.height()
    if chosen is None:
        return 0, 0, width, height
    left, top = max(chosen.x(), 0), max(chosen.y(), 0)
    right, bottom = min(chosen.x() + chosen.width(), width), min(chosen.y() + chosen.height(), height)
    if right <= left or bottom <= top:
        raise Trouble("The selection is empty, or lies outside the picture; select something, or nothing at all.")
    return left, top, right - left, bottom - top


class Work:
    """A run that has been started; `call` is to be polled, then `place` puts the result into Krita.

    `options` are words of the command line, such as ["--seed", 1]. `fresh`: the result is a new document, of any
    size; else it is a layer as large as the canvas. What is grown always is a new document.
    """

    def __init__(self, program, doc, verb, options, fresh=False):
        self.doc, self.verb, self.fresh, self.node = doc, verb, fresh or verb == "grow", chosen_layer(doc)
        self.name, self.space = self.node.name(), layers.Space(self.node)
        self.box = example_box(doc) if verb == "grow" else (0, 0, doc.width(), doc.height())
        if verb == "heal" and doc.selection() is None:
            raise Trouble("Nothing is selected; select what is to be healed.")
        example_box(doc)
        self.before = layers.pixels_of(self.node, self.box)
        if self.space.is_empty(self.before):
            raise Trouble(f'Layer "{self.name}" is empty here; paint or paste an example on it, or choose another.')
        self.chosen = b""
        self.folder = Folder()
        try:
            self.call = Call(program, *self._asked(options))
        except BaseException:
            self.folder.cleanup()
            raise

    def _asked(self, options):
        """Write the files; return the words of the command, and what a person calls the files."""
        folder, (_, _, width, height) = Path(self.folder.name), self.box
        self.given, mask = folder / f"krita_layer_1{self.space.suffix}", folder / "krita_selection_2.png"
        self.made = folder / f"krita_result_3{self.space.suffix}"
        layers.save(self.space, self.before, width, height, self.given, self.doc.resolution())
        words = [self.verb, self.given, "-o", self.made, *options]
        names = {self.given: f'layer "{self.name}"', mask: "the selection", self.made: "the result"}
        if self.verb == "tile" and not self.fresh:
            words += ["--size", f"{width}x{height}"]  # else it is cut to whole periods
        selection = self.doc.selection()
        if selection is not None and self.verb != "tile":
            values = bytes(selection.pixelData(*self.box))
            self.chosen = values.translate(layers.YES if self.verb == "heal" else layers.HALF)
            if self.verb == "heal" or 0 in self.chosen:
                layers.save_mask(self.chosen, width, height, mask)
                words += ["--mask", mask]
        return words, names

    def place(self):
        """Put the result of the ended run into Krita, as a layer above or a new document; return that."""
        try:
            self.call.result()
            pixels, width, height = layers.load(self.space, self.made)
            if self.verb == "heal":
                pixels = layers.only_changed(self.space, self._as_read(), pixels, self.chosen, width)
        finally:
            self.stop()
        name = f"{self.name} {ENDINGS[self.verb]}"
        if self.fresh:
            return layers.document_of(self.space, pixels, width, height, name, self.doc.resolution())
        if self.doc not in Krita.instance().documents():
            raise Trouble(f'The picture of "{self.name}" was closed meanwhile, so its result has no place.')
        return layers.add_layer(self.space, self.doc, pixels, width, height, name, self.node)

    def _as_read(self):
        """Return the layer as Krita reads it from a file: an EXR of what is partly transparent is rounded there."""
        if self.space.suffix == ".png" or self.space.is_opaque(self.before):
            return self.before
        return layers.load(self.space, self.given)[0]

    def stop(self):
        """End the run, and remove its files."""
        self.call.stop()
        self.folder.cleanup()
