"""Dialogs: what to grow, and where the program is. They remember their last values."""

import random

from krita import Krita

from .calling import Trouble, installation
from .qt import QtWidgets

GROUP = "intarsia"  # of Krita's settings
TITLES = {"grow": "Grow Texture", "tile": "Make Tileable", "heal": "Heal Selection"}
LEADS = {
    "grow": "Grows a new picture from the layer, or from what is selected of it.",
    "tile": "Makes the layer continue in itself; only a band along its borders changes.",
    "heal": "Fills what is selected with what suits there, on a new layer.",
}
DIRECTIONS = (("Both ways", "both"), ("Left to right", "x"), ("Top to bottom", "y"), ("No", "none"))
KEPT, CUT = "keep", "cut"
SHAPES = (("Keep: a new layer", KEPT), ("Cut where the pattern closes: a new picture", CUT))
METHODS = (
    ("Automatic", "auto"), ("Free shapes", "graphcut"), ("Square pieces", "image-quilting"),
    ("Soft squares", "patch-sampling"), ("Bricks and tiles", "near-regular"),
)  # fmt: skip
LARGEST, SEEDS = 16384, 2**31 - 1
BUTTON = QtWidgets.QDialogButtonBox.StandardButton


def remembered(name, default=""):
    """Return what was last given, as text."""
    return Krita.instance().readSetting(GROUP, name, str(default))


def remember(name, value):
    """Keep what was given for the next time."""
    Krita.instance().writeSetting(GROUP, name, str(value))


def _number(name, default, least, most, unit=" px", automatic=""):
    box = QtWidgets.QSpinBox()
    box.setRange(least, most)
    box.setSuffix(unit)
    box.setSpecialValueText(automatic)
    last = remembered(name, default)
    box.setValue(int(last) if last.lstrip("-").isdigit() else default)
    return box


def _choice(name, choices):
    box = QtWidgets.QComboBox()
    for text, word in choices:
        box.addItem(text, word)
    box.setCurrentIndex(max(box.findData(remembered(name, choices[0][1])), 0))
    return box


class Asking(QtWidgets.QDialog):
    """What a person is asked before a run. `size` is that of the example."""

    def __init__(self, verb, size, parent=None):
        super().__init__(parent)
        self.verb, self.fields, self.form = verb, {}, QtWidgets.QFormLayout()
        self.setWindowTitle(TITLES[verb])
        lead = QtWidgets.QLabel(LEADS[verb])
        lead.setWordWrap(True)
        lead.setMinimumWidth(340)
        getattr(self, f"_add_{verb}")(*size)
        self._add_seed()
        buttons = QtWidgets.QDialogButtonBox(BUTTON.Ok | BUTTON.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        all_of_it = QtWidgets.QVBoxLayout(self)
        all_of_it.addWidget(lead)
        all_of_it.addLayout(self.form)
        all_of_it.addWidget(buttons)

    def _add(self, name, text, field, tip):
        field.setToolTip(tip)
        self.fields[name] = field
        self.form.addRow(text, field)

    def _add_grow(self, width, height):
        for name, text, given in (("width", "Width:", width), ("height", "Height:", height)):
            field = _number(f"grow_{name}", min(2 * given, LARGEST), 1, LARGEST)
            self._add(name, text, field, f"Of the new picture. The example has {given} px.")
        tip = "In which directions the new picture continues in itself"
        self._add("wrap", "Tileable:", _choice("grow_wrap", DIRECTIONS), tip)
        tip = "How pieces of the example are laid together; Automatic looks at the example first"
        self._add("method", "Method:", _choice("grow_method", METHODS), tip)

    def _add_tile(self, width, height):
        tip = "In which directions the layer is to continue in itself"
        self._add("axes", "Tileable:", _choice("tile_axes", DIRECTIONS[:3]), tip)
        tip = "Bricks, tiles and weaves close only after a whole number of them"
        self._add("shape", "Size:", _choice("tile_shape", SHAPES), tip)
        band = _number("tile_band", 0, 0, max(min(width, height) // 2, 1), automatic="Automatic")
        self._add("band", "Band:", band, "How wide the band along the borders is that is grown anew")
        field = QtWidgets.QCheckBox("Switch on wrap-around mode (W)")
        field.setChecked(remembered("tile_around", "True") == "True")
        self._add("around", "", field, "Shows the picture repeated, so that you see at once whether it tiles")

    def _add_heal(self, width, height):
        grow = _number("heal_grow", -1, -1, max(width, height), automatic="Automatic")
        self._add("grow", "Enlarge selection by:", grow, "So that the rim of a flaw goes, too")
        field = _choice("heal_wrap", (DIRECTIONS[3], *DIRECTIONS[:3]))
        self._add("wrap", "Picture tiles:", field, "A picture that continues in itself goes on doing so")

    def _add_seed(self):
        seed, other = _number(f"{self.verb}_seed", 0, 0, SEEDS, unit=""), QtWidgets.QPushButton("Another")
        other.setToolTip("Draw another number")
        other.setAutoDefault(False)
        other.clicked.connect(lambda *_: seed.setValue(random.randrange(100_000)))
        row = QtWidgets.QHBoxLayout()
        row.addWidget(seed, 1)
        row.addWidget(other)
        seed.setToolTip("The same number gives the same picture; another gives another one")
        self.fields["seed"] = seed
        self.form.addRow("Seed:", row)

    def values(self):
        """Return the fields by name, and remember them."""
        found = {}
        for name, field in self.fields.items():
            found[name] = (
                field.currentData() if isinstance(field, QtWidgets.QComboBox)
                else field.isChecked() if isinstance(field, QtWidgets.QCheckBox) else field.value()
            )  # fmt: skip
            remember(f"{self.verb}_{name}", found[name])
        return found


def options_of(verb, values):
    """Return the words of the command line for the values of a dialog."""
    words = ["--seed", values["seed"]]
    if verb == "grow":
        words += ["--size", f"{values['width']}x{values['height']}"]
        words += ["--wrap", values["wrap"], "--method", values["method"]]
    elif verb == "tile":
        words += ["--axes", values["axes"]] + (["--band", values["band"]] if values["band"] else [])
    else:
        words += ["--wrap", values["wrap"]] + (["--grow", values["grow"]] if values["grow"] >= 0 else [])
    return words


class Missing(QtWidgets.QDialog):
    """Says that the program was not found, and takes its path, or the wish to install it (`installs`)."""

    def __init__(self, line, parent=None):
        super().__init__(parent)
        self.installs = False
        self.setWindowTitle("intarsia was not found")
        try:
            way, able = f"Install: {installation()[1]}.", True
        except Trouble as trouble:
            way, able = f"To install it: {trouble}", False
        text = QtWidgets.QLabel(f"{line}\n\n{way}")
        text.setWordWrap(True)
        text.setMinimumWidth(420)
        self.path = QtWidgets.QLineEdit(remembered("command"))
        self.path.setPlaceholderText("path of the program intarsia")
        search = QtWidgets.QPushButton("Browse...")
        search.setAutoDefault(False)
        search.clicked.connect(self._browse)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.path, 1)
        row.addWidget(search)
        buttons = QtWidgets.QDialogButtonBox(BUTTON.Ok | BUTTON.Cancel)
        install = buttons.addButton("Install", QtWidgets.QDialogButtonBox.ButtonRole.ActionRole)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        install.clicked.connect(self._install)
        install.setEnabled(able)
        all_of_it = QtWidgets.QVBoxLayout(self)
        all_of_it.addWidget(text)
        all_of_it.addLayout(row)
        all_of_it.addWidget(buttons)

    def _browse(self, *_):
        path, _ = QtWidgets.QFileDialog.getOpenFileName(self, "The program intarsia", self.path.text())
        self.path.setText(path or self.path.text())

    def _install(self, *_):
        self.installs = True
        self.accept()
