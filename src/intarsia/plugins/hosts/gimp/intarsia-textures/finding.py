"""Finds the program for GIMP: remembers the path that a person named, and offers to install what is not there."""

from __future__ import annotations

import threading

import calling
from gi.repository import Gimp

REMEMBERED = "intarsia-program"
INSTALL, USE = 1, 2


def chosen():
    """Return the path that was named before, or nothing."""
    parasite = Gimp.get_parasite(REMEMBERED)
    return "" if parasite is None else bytes(parasite.get_data()).decode("utf-8", "replace").strip("\0")


def remember(path):
    """Keep a path for all later calls."""
    persistent = 1
    Gimp.attach_parasite(Gimp.Parasite.new(REMEMBERED, persistent, path.encode()))


def program(interactive):
    """Return the words that start the program; Trouble where there is none. `interactive`: ask the person first."""
    while True:
        try:
            words = calling.command(chosen())
            calling.checked(words)
            return words
        except calling.Trouble as trouble:
            if not interactive or not trouble.missing:
                raise
            ask(str(trouble))


def ask(line):
    """Tell that the program was not found; install it, or have its path named. Stopped if neither is wanted."""
    from gi.repository import Gtk

    _, what = calling.installation()
    window = Gtk.Dialog(title="Intarsia Textures")
    window.add_buttons("_Cancel", Gtk.ResponseType.CANCEL, "_Use This Program", USE, "_Install", INSTALL)
    window.set_response_sensitive(USE, False)
    box = window.get_content_area()
    box.set_spacing(12)
    box.set_border_width(12)
    told = Gtk.Label(label=f"{line}\n\nWith Install: {what}", wrap=True, max_width_chars=60, xalign=0)
    path = Gtk.FileChooserButton(title="The program intarsia")
    path.connect("file-set", lambda *_: window.set_response_sensitive(USE, True))
    row = Gtk.Box(spacing=6)
    row.pack_start(Gtk.Label(label="The program is here:"), False, False, 0)
    row.pack_start(path, True, True, 0)
    bar = Gtk.ProgressBar(show_text=True, no_show_all=True)
    for part in (told, row, bar):
        box.pack_start(part, False, False, 0)
    window.show_all()
    try:
        answer = window.run()
        if answer == USE:
            remember(path.get_filename())
        elif answer == INSTALL:
            row.set_sensitive(False)
            for button in (INSTALL, USE):
                window.set_response_sensitive(button, False)
            bar.show()
            installed(bar)
            remember("")
        else:
            raise calling.Stopped
    finally:
        window.destroy()


def installed(bar):
    """Install the program, and keep the window alive meanwhile."""
    from gi.repository import GLib

    failed, steps = [], ["Installing"]

    def work():
        try:
            calling.install(told=steps.append)
        except calling.Trouble as trouble:
            failed.append(trouble)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    while thread.is_alive():
        bar.set_text(steps[-1])
        bar.pulse()
        for _ in range(20):
            GLib.MainContext.default().iteration(False)
        thread.join(0.1)
    if failed:
        raise calling.Trouble(str(failed[0]))
