"""What all operators have in common: a run of the program, watched by a timer, or waited for."""

import re
import time
from pathlib import Path

import bpy

from . import calling, settings
from .calling import Call, Folder, Stopped, Trouble
from .pictures import MADE, called

STEP = 0.1  # s between two looks at a run


class Running:
    """An operator that runs the program.

    `take(context, folder)` writes the images and returns a dict of map -> Given, the base first; `wishes()` are words
    of the command; `put(context, made)` takes in the files, map -> path. While it runs, undo may take away all that
    Blender holds, so names alone are kept.
    """

    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012 - as Blender wants it
    busy = False
    _asked = _watched = False

    @classmethod
    def poll(cls, context):
        """Return whether nothing else runs."""
        if Running.busy:
            cls.poll_message_set("intarsia is at work; Esc stops it")
        return not Running.busy

    def execute(self, context):
        """Run the program; without a window, from a script and in the redo panel wait for it."""
        try:
            self._begin(context)
        except Trouble as trouble:
            return self._failed(trouble)
        manager = context.window_manager
        manager.progress_begin(0, 100)
        if bpy.app.background or not self._asked or self.options.is_repeat or self.options.is_repeat_last:
            while not self._call.poll():
                manager.progress_update(100 * self._call.fraction)
                time.sleep(calling.LOOK)
            return self._finish(context)
        Running.busy = self._watched = True
        self._timer = manager.event_timer_add(STEP, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def _begin(self, context):
        program = settings.program(context)
        self._folder = Folder()
        try:
            folder = Path(self._folder.name)
            self._given = self.take(context, folder)
            (_, first), *others = self._given.items()
            maps = [word for plane, given in others for word in ("--map", f"{plane}={given.file}")]
            out = folder / f"made{MADE.get(first.file.suffix, '.png')}"
            words = [self.verb, first.file, *maps, *self.wishes(), "--seed", self.seed, "-o", out]
            names = {str(given.file): called(given.name) for given in self._given.values()}
            self._call = Call(program, words, names | self.further_names())
        except BaseException:
            self._folder.cleanup()
            raise

    def further_names(self):
        """Return the names of files beside the maps."""
        return {}

    def modal(self, context, event):
        """Look at the run; Esc stops it."""
        if event.type == "ESC":
            self.cancel(context)
            self.report({"INFO"}, "Stopped; nothing was changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if not self._call.poll():
            context.window_manager.progress_update(100 * self._call.fraction)
            context.workspace.status_text_set(f"{self._call.words()}    Esc: stop")
            return {"PASS_THROUGH"}
        self._leave_window(context)
        return self._finish(context)

    def cancel(self, context):
        """Stop the run: Esc was pressed, another file is opened, or the dialog was left before it began."""
        if self._watched:
            self._leave_window(context)
            self._end(context)

    def _leave_window(self, context):
        Running.busy = self._watched = False
        context.window_manager.event_timer_remove(self._timer)
        for workspace in bpy.data.workspaces:
            workspace.status_text_set(None)

    def _finish(self, context):
        try:
            result = self._call.result()
            (_, first), *others = ((told["holds"], told["path"]) for told in result["files"])
            files = {next(iter(self._given)): first, **dict(others)}
            name = self.put(context, {plane: files[plane] for plane in self._given})
        except Trouble as trouble:
            return self._failed(trouble)
        except Stopped:
            return {"CANCELLED"}
        finally:
            self._end(context)
        width, height = result["size"]
        self.report({"INFO"}, f"{name}: {width}x{height} px, {result['method']}, seed {result['seed']}")
        for line in self._call.warnings:
            self.report({"WARNING"}, re.sub(r"--size \S+ keeps all", "Keep the Size keeps all", line))
        return {"FINISHED"}

    def _end(self, context):
        context.window_manager.progress_end()
        self._call.stop()
        self._folder.cleanup()

    def _failed(self, trouble):
        if not trouble.missing or bpy.app.background:
            self.report({"ERROR"}, str(trouble))
        else:
            bpy.context.window_manager.popup_menu(_offer, title=str(trouble), icon="ERROR")
        return {"CANCELLED"}


def _offer(menu, context):
    """Draw what can be done where the program is missing."""
    menu.layout.operator_context = "INVOKE_DEFAULT"
    menu.layout.operator(settings.Install.bl_idname)
    menu.layout.operator("preferences.addon_show", text="Name its Path...").module = __package__
