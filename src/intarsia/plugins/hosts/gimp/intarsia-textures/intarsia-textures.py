#!/usr/bin/env python3
"""GIMP 3: heals, fills, grows, extends and tiles layers by the program intarsia, which runs in a Python of its own.

Nothing but GIMP's own Python is needed here.
"""

from __future__ import annotations

import sys
from pathlib import Path

import gi

for module, version in (("Gimp", "3.0"), ("GimpUi", "3.0"), ("Gegl", "0.4"), ("Gtk", "3.0")):
    gi.require_version(module, version)

import calling  # noqa: E402 - GIMP's modules want their versions first
import finding  # noqa: E402
import pictures  # noqa: E402
import procedures  # noqa: E402
from gi.repository import Gimp, GimpUi, GLib, GObject, Gtk  # noqa: E402
from pictures import Refused  # noqa: E402
from procedures import PROCEDURES  # noqa: E402


class Task:
    """One call: the image, the layers, the values of the dialog, the program, and a folder for its files."""

    def __init__(self, image, layers, config, program, folder):
        self.image, self.maps, self.program, self.folder = image, pictures.maps_of(layers), program, Path(folder)
        self.value = config.get_property
        self.names = {}

    def file(self, name, called):
        """Return the path of a file, and have messages call it so; a stem with a digit is no word of theirs."""
        path = str(self.folder / name)
        self.names[path] = called
        return path

    def given(self, box):
        """Write a part of the maps; return their files, the picture first."""
        files = []
        for what, ending, layer in self.maps:
            name = "layer1.tif" if what == "albedo" else f"layer1_{ending}.tif"
            files.append(self.file(name, layer.get_name()))
            pictures.save(layer, box, files[-1])
        return files

    def run(self, *words):
        """Run the program; return its files by map, and the size of what it made."""
        shown = [0.0, ""]

        def tell(fraction, line):
            if line != shown[1]:
                shown[:] = fraction, line
                Gimp.progress_set_text(line)
                Gimp.progress_update(fraction)

        most = max(1 << 26, *(layer.get_width() * layer.get_height() for _, _, layer in self.maps))
        more = ["--max-pixels", most] if most > 1 << 26 else []
        out = self.file("made1.tif", "the result")
        told = calling.run(self.program, [*words, "-o", out, "--seed", self.value("seed"), *more], self.names, tell)
        for line in told["warnings"]:
            Gimp.message(line.split("; --")[0])
        made = {file["holds"]: file["path"] for file in told["files"]}
        if len(made) == 1:  # whatever the program takes it for
            made = {self.maps[0][0]: told["files"][0]["path"]}
        return made, tuple(told["size"])


def layers_of(image, drawables):
    """Return the layers to work on; Refused if they are none."""
    if image.get_base_type() == Gimp.ImageBaseType.INDEXED:
        raise Refused("Indexed pictures have too few colours to be grown; choose Image > Mode > RGB first.")
    for item in drawables:
        if not isinstance(item, Gimp.Layer) or item.is_group():
            raise Refused(f"{item.get_name()} is no layer with pixels of its own; select a layer.")
        if item.get_lock_content():
            raise Refused(f"The pixels of {item.get_name()} are locked; unlock them first.")
    if not drawables:
        raise Refused("Select a layer first.")
    return list(drawables)


def asked(procedure, config, wanted):
    """Show the dialog; return whether it was accepted."""
    window = GimpUi.ProcedureDialog(procedure=procedure, config=config, title=wanted.title)
    for n, (heading, fields) in enumerate(wanted.sections):
        window.get_label(f"heading-{n}", heading, False, False)
        window.fill_box(f"fields-{n}", [field.name for field in fields])
        window.fill_frame(f"section-{n}", f"heading-{n}", False, f"fields-{n}")
    for name, (by, value) in wanted.only_with.items():
        values = Gimp.ValueArray.new(1)
        values.append(GObject.Value(str, value))
        window.set_sensitive_if_in(name, None, by, values, True)
    window.fill([f"section-{n}" for n in range(len(wanted.sections))])
    window.get_widget_for_response(Gtk.ResponseType.HELP).hide()  # GIMP's manual knows nothing of this
    accepted = window.run()
    window.destroy()
    return accepted


def carry_out(procedure, mode, image, drawables, config, data):
    wanted = PROCEDURES[procedure.get_name()]

    def done(status, line=None):
        error = GLib.Error() if line is None else GLib.Error.new_literal(Gimp.PlugIn.error_quark(), line, 0)
        return procedure.new_return_values(status, error)

    interactive = mode == Gimp.RunMode.INTERACTIVE
    try:
        layers = layers_of(image, drawables)
        wanted.check(image, layers)
        if interactive:
            GimpUi.init("intarsia-textures")
        program = finding.program(interactive)
        if interactive and not asked(procedure, config, wanted):
            return done(Gimp.PDBStatusType.CANCEL)
        Gimp.progress_init(wanted.title)
        with calling.Folder() as folder:
            made = wanted.work(Task(image, layers, config, program, folder))
    except calling.Stopped:
        return done(Gimp.PDBStatusType.CANCEL)
    except (Refused, calling.Trouble) as trouble:
        return done(Gimp.PDBStatusType.EXECUTION_ERROR, str(trouble))
    except (OSError, GLib.Error) as e:
        reason = e.message if isinstance(e, GLib.Error) else e.strerror
        return done(Gimp.PDBStatusType.EXECUTION_ERROR, f"The files for intarsia cannot be written or read: {reason}.")
    values = done(Gimp.PDBStatusType.SUCCESS)
    if made is not None:
        values.remove(1)
        values.insert(1, GObject.Value(Gimp.Image, made))
        if mode != Gimp.RunMode.NONINTERACTIVE:
            Gimp.Display.new(made)
    return values


class IntarsiaTextures(Gimp.PlugIn):
    def do_set_i18n(self, name):
        return False

    def do_query_procedures(self):
        return list(PROCEDURES)

    def do_create_procedure(self, name):
        wanted = PROCEDURES[name]
        made = Gimp.ImageProcedure.new(self, name, Gimp.PDBProcType.PLUGIN, carry_out, None)
        made.set_image_types("RGB*, GRAY*")
        made.set_sensitivity_mask(
            Gimp.ProcedureSensitivityMask.DRAWABLE | Gimp.ProcedureSensitivityMask.DRAWABLES
        )
        made.set_documentation(wanted.blurb, f"{wanted.blurb} Pieces of the picture are put together anew.", name)
        made.set_menu_label(wanted.label)
        made.add_menu_path(wanted.menu)
        made.set_attribution("intarsia", "MIT", "2026")
        for _, fields in wanted.sections:
            for field in fields:
                field.add_to(made)
        if wanted.work is procedures.grow:
            made.add_image_return_value("new-image", "Image", "What was grown", False, GObject.ParamFlags.READWRITE)
        return made


Gimp.main(IntarsiaTextures.__gtype__, sys.argv)
