"""The preferences of the plug-in: where the program is, what it says of itself, and a button that installs it."""

import os
import threading

import bpy
from bpy.props import StringProperty

from . import calling
from .calling import Trouble

ONLINE = "Edit > Preferences > System > Network > Allow Online Access is off; switch it on to install intarsia."
STEP = 0.2  # s between two looks at an installation

_answered = {}
"""The words that start a program, and the time of its file -> what it said of itself."""
_lines = {}
"""Chosen path -> a line about the program there, for the preferences; empty while it is being asked."""


def preferences(context):
    """Return the preferences of this plug-in."""
    return context.preferences.addons[__package__].preferences


def program(context):
    """Return the words that start the program; Trouble if it is not there or does not belong to this plug-in."""
    words = calling.command(preferences(context).program)
    _about(words)
    return words


def _about(words):
    key = (*words, os.stat(words[0]).st_mtime)
    if key not in _answered:
        _answered[key] = calling.checked(words)
    return _answered[key]


def _ask(chosen):
    """Ask the program about itself, in a thread, as preferences are drawn anew at each movement of the mouse."""
    try:
        words = calling.command(chosen)
        _lines[chosen] = f"intarsia {_about(words)['version']}: {' '.join(words)}"
    except (Trouble, OSError) as e:
        _lines[chosen] = str(e)


def _wrapped(layout, line, width=80):
    """Draw a line of text; labels of Blender do not wrap it."""
    column = layout.column(align=True)
    while line:
        cut = len(line) if len(line) <= width else (line.rfind(" ", 0, width) + 1 or width)
        column.label(text=line[:cut].strip())
        line = line[cut:]


class IntarsiaPreferences(bpy.types.AddonPreferences):
    """Where the program is, what it says of itself, and a button that installs it."""

    bl_idname = __package__
    PROGRAM = StringProperty(
        name="Program", subtype="FILE_PATH",
        description="Path of the program intarsia; if this is empty, it is looked for",
    )  # fmt: skip
    program: PROGRAM

    def draw(self, context):
        """Draw the preferences."""
        self.layout.prop(self, "program")
        if self.program not in _lines:
            _lines[self.program] = ""
            threading.Thread(target=_ask, args=(self.program,), daemon=True).start()
            bpy.app.timers.register(_redraw, first_interval=STEP)
        _wrapped(self.layout, _lines[self.program] or "Looking for intarsia")
        self.layout.operator(Install.bl_idname)


def _redraw():
    """Draw the preferences anew once the program has answered."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PREFERENCES":
                area.tag_redraw()
    return None if all(_lines.values()) else STEP


def forget():
    """Have the program asked again."""
    _lines.clear()


class Install(bpy.types.Operator):
    """Install the program intarsia, in an environment of its own"""

    bl_idname, bl_label = "preferences.intarsia_install", "Install or Update intarsia..."
    bl_options = {"INTERNAL"}  # noqa: RUF012 - as Blender wants it

    def invoke(self, context, event):
        """Say what would be run, and ask."""
        return context.window_manager.invoke_props_dialog(self, width=420, confirm_text="Install")

    def draw(self, context):
        """Say what would be run."""
        steps, line = calling.installation()
        _wrapped(self.layout, f"Install {line}?", 60)
        for step in steps:
            _wrapped(self.layout.box(), " ".join(step), 60)

    def execute(self, context):
        """Install; blocks without a window."""
        if not bpy.app.online_access:
            self.report({"ERROR"}, ONLINE)
            return {"CANCELLED"}
        self._said, self._trouble = "Installing intarsia", None
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()
        if bpy.app.background:
            self._thread.join()
            return self._end()
        self._timer = context.window_manager.event_timer_add(STEP, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def _work(self):
        try:
            calling.install(told=self._hear)
        except (Trouble, OSError) as e:
            self._trouble = str(e)

    def _hear(self, line):
        self._said = f"Installing intarsia: {line}"

    def modal(self, context, event):
        """Wait for the installation."""
        context.workspace.status_text_set(self._said if self._thread.is_alive() else None)
        if self._thread.is_alive():
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self._timer)
        return self._end()

    def _end(self):
        forget()
        if self._trouble is not None:
            self.report({"ERROR"}, self._trouble)
            return {"CANCELLED"}
        self.report({"INFO"}, "intarsia is installed; it compiles in the background for a minute.")
        return {"FINISHED"}


CLASSES = (IntarsiaPreferences, Install)
