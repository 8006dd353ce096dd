"""The menu entries, and what happens between them and a result: Krita stays alive, one run at a time."""

import threading

from krita import Extension, Krita

from . import calling
from .dialogs import CUT, TITLES, Asking, Missing, options_of, remember, remembered
from .qt import QtCore, QtGui, QtWidgets
from .work import Work, chosen_layer, example_box

LOOK = 80  # ms between two looks at a run
SHOWN = 6000  # ms that a notice stays
MENU = "tools/scripts"


def krita_window():
    """Return the window of Krita that is used, also while another program is in front; None if there is none."""
    return Krita.instance().activeWindow() or next(iter(Krita.instance().windows()), None)


def main_window():
    """Return the window that dialogs belong to."""
    window = krita_window()
    return window.qwindow() if window else None


def show_trouble(trouble):
    """Show a line in a message box that does not stop Krita."""
    box = QtWidgets.QMessageBox(QtWidgets.QMessageBox.Icon.Warning, "intarsia", str(trouble), parent=main_window())
    box.setAttribute(QtCore.Qt.WidgetAttribute.WA_DeleteOnClose)
    box.open()


def show_failure(e):
    """Show why something failed. Nothing may be raised out of what Qt calls: it would end Krita."""
    if not isinstance(e, calling.Stopped):
        show_trouble(e if isinstance(e, calling.Trouble) else f"The plug-in failed ({type(e).__name__}: {e}).")


def show_notice(text):
    """Show a line on the canvas for a while."""
    window = krita_window()
    view = window.activeView() if window else None
    if view is not None:
        view.showFloatingMessage(text, QtGui.QIcon(), SHOWN, 1)


class Waiting:
    """A progress dialog beside which Krita goes on. `look` is called until it says True, then `done`."""

    def __init__(self, title, look, done, cancel=None):
        self.look, self.done, self.cancel, self.over = look, done, cancel, False
        self.bar = QtWidgets.QProgressDialog(title, "Cancel" if cancel else "", 0, 100 if cancel else 0, main_window())
        self.bar.setWindowTitle(title)
        self.bar.setMinimumWidth(360)
        self.bar.setWindowModality(QtCore.Qt.WindowModality.NonModal)
        self.bar.setMinimumDuration(0)
        self.bar.setAutoClose(False)
        self.bar.setAutoReset(False)
        if cancel is None:
            self.bar.setCancelButton(None)
        else:
            self.bar.canceled.connect(self.stop)
        self.bar.destroyed.connect(self._end)  # with its window
        self.timer = QtCore.QTimer()
        self.timer.timeout.connect(self._tick)
        self.timer.start(LOOK)
        self.bar.show()

    def tell(self, fraction, words):
        """Show how far it is."""
        self.bar.setLabelText(words)
        if self.cancel is not None:
            self.bar.setValue(min(int(100 * fraction), 100))

    def _tick(self):
        try:
            if not self.over and self.look(self):
                self._close()
                self.done()
        except Exception as e:
            self.stop()
            show_failure(e)

    def stop(self, *_):
        """End what is waited for, without a result."""
        if not self.over:
            self._close()
            self._cancel()

    def _end(self, *_):
        if not self.over:
            self.over = True
            self.timer.stop()
            self._cancel()

    def _cancel(self):
        if self.cancel is not None:
            self.cancel()

    def _close(self):
        self.over = True
        self.timer.stop()
        self.bar.blockSignals(True)
        self.bar.close()
        self.bar.deleteLater()


class Textures(Extension):
    """The plug-in."""

    def __init__(self, parent):
        super().__init__(parent)
        self.waiting, self.known = None, ()

    def setup(self):
        """Called by Krita once; there is nothing to set up."""

    def createActions(self, window):
        """Called by Krita for each of its windows."""
        actions = []
        for verb, title in TITLES.items():
            action = window.createAction(f"intarsia_{verb}", f"{title}...", MENU)
            action.triggered.connect(lambda *_, verb=verb: self.ask(verb))
            actions.append(action)
        main = window.qwindow()
        QtCore.QTimer.singleShot(0, lambda: self._add_to_filters(main, actions))  # Krita fills its menus after this

    def _add_to_filters(self, main, actions):
        bar = main.menuBar()
        filters = next((entry.menu() for entry in bar.actions() if entry.objectName().lower() == "filter"), None)
        if filters is not None:
            menu = QtWidgets.QMenu("Texture (intarsia)", filters)
            menu.addActions(actions)
            filters.addMenu(menu)

    def ask(self, verb):
        """Ask what is wanted, and start."""
        try:
            if self.waiting is not None and not self.waiting.over:
                raise calling.Trouble("intarsia is still at work; wait for that, or cancel it.")
            doc = Krita.instance().activeDocument()
            chosen_layer(doc)
            if verb == "heal" and doc.selection() is None:
                raise calling.Trouble("Nothing is selected; select what is to be healed.")
            size = example_box(doc)[2:]
            program = self.program()
            dialog = Asking(verb, size, main_window())
            if dialog.exec():
                self.start(program, doc, verb, dialog.values())
        except Exception as e:
            if getattr(e, "missing", False):
                self.offer(str(e), verb)
            else:
                show_failure(e)

    def program(self):
        """Return the words that start the program, which has told who it is."""
        words = calling.command(remembered("command"))
        if tuple(words) != self.known:
            calling.checked(words)
            self.known = tuple(words)
        return words

    def offer(self, line, verb):
        """Say that the program was not found; take its path and go on, or install it."""
        dialog = Missing(line, main_window())
        if not dialog.exec():
            return
        remember("command", dialog.path.text().strip())
        if dialog.installs:
            self.install()
        else:
            QtCore.QTimer.singleShot(0, lambda: self.ask(verb))

    def install(self):
        """Install the program in a thread."""
        found = {"line": ""}

        def work():
            try:
                found["words"] = calling.install(told=lambda line: found.update(line=line))
            except Exception as e:  # shown by the thread of the window
                found["trouble"] = e if isinstance(e, calling.Trouble) else calling.Trouble(f"It failed: {e}")

        def done():
            if "trouble" in found:
                raise found["trouble"]
            remember("command", "")
            show_notice("intarsia is installed, and compiles for this computer in the background")

        thread = threading.Thread(target=work, daemon=True)
        thread.start()

        def look(waiting):
            waiting.tell(0, f"Installing intarsia, about 150 MB\n{found['line']}")
            return not thread.is_alive()

        self.waiting = Waiting("Installing intarsia", look, done)

    def start(self, program, doc, verb, values):
        """Start a run, whose end shows its result."""
        work = Work(program, doc, verb, options_of(verb, values), values.get("shape") == CUT)

        def look(waiting):
            ended = work.call.poll()
            waiting.tell(work.call.fraction, work.call.words())
            return ended

        def done():
            made = work.place()
            window = krita_window()
            if work.fresh and window is not None:
                window.addView(made)
            around = Krita.instance().action("wrap_around_mode")
            shown = Krita.instance().activeDocument() in (doc, made)
            if verb == "tile" and values["around"] and shown and around is not None and not around.isChecked():
                around.trigger()
            if work.call.warnings:
                show_notice("\n".join(line.split("; --")[0] for line in work.call.warnings))  # no words of options

        self.waiting = Waiting(f"{TITLES[verb]}: {work.name}", look, done, work.stop)
