"""The plug-in inside Krita, without a window: pixels against the command's, bad input, what is left after a stop.

Not called krita.py, which would hide Krita's own module. Started so, with the plug-in installed in FOLDER:

    HOME=EMPTY QT_QPA_PLATFORM=offscreen PYTHONPATH=tests/programs PLUGINS=FOLDER INTARSIA=COMMAND \
        kritarunner -s in_krita -f main

COMMAND is the path of a program intarsia, which the plug-in calls, and with which its results are compared; best
warmed up. TMPDIR names a folder of its own, where plug-ins of other programs are at work, too. Lines
``OK what`` and ``FAIL what`` go to stdout, as does all that Krita says. It ends with 0 if all are OK, else with 1.
"""

import os
import subprocess
import sys
import tempfile
import time
import traceback
from contextlib import suppress
from glob import glob
from pathlib import Path
from types import SimpleNamespace

from krita import InfoObject, Krita, Selection

sys.path.insert(0, os.environ["PLUGINS"])
COMMAND = [os.environ["INTARSIA"]]
WIDTH, HEIGHT = 96, 64
KINDS = ["U8:RGB", "U16:RGB", "F16:RGB", "F32:RGB", "U8:Y", "U16:Y", "F16:Y", "F32:Y"]
failed = []


def main(*_):
    """Called by kritarunner, which never ends by itself."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            Krita.instance().setBatchmode(True)
            for tried in (pixels, cut, transparent, parts, refused, elsewhere, stopped, asked, waited, missing):
                try:
                    tried()
                except Exception:
                    say(False, f"{tried.__name__}: {' / '.join(traceback.format_exc().splitlines()[-3:])}")
            os.chdir("/")
    finally:
        sys.stdout.flush()
        os._exit(1 if failed else 0)


def say(good, what):
    """Tell of one check."""
    print("OK" if good else "FAIL", what, flush=True)
    if not good:
        failed.append(what)


def command(*words):
    """Run the command that results are compared with."""
    from intarsia_textures.calling import environment

    subprocess.run([*COMMAND, *map(str, words), "--force", "-q"], check=True, env=environment())


def opened(path):
    """Return a document, and its layer."""
    doc = Krita.instance().openDocument(str(Path(path).absolute()))
    doc.setBatchmode(True)
    return doc, doc.rootNode().childNodes()[0]


def data(doc, node=None):
    """Return the bytes of a layer on the canvas."""
    return bytes((node or doc.rootNode().childNodes()[0]).pixelData(0, 0, doc.width(), doc.height()))


def made(doc, verb, *options, fresh=False):
    """Run the plug-in to its end; return the new layer or document."""
    from intarsia_textures.work import Work

    work = Work(COMMAND, doc, verb, ["--seed", 1, *options], fresh)
    while not work.call.poll():
        time.sleep(0.02)
    return work.place()


def trouble(ask):
    """Return the line that is told when `ask` is called; "" if there is none."""
    from intarsia_textures.calling import Trouble

    try:
        ask()
    except Trouble as e:
        return str(e)
    return ""


def select(doc, x, y, width, height, value=255):
    """Select a box."""
    chosen = Selection()
    chosen.select(x, y, width, height, value)
    doc.setSelection(chosen)


def example(kind="U8:RGB"):
    """Write a picture of a depth, RGB or gray; return its path."""
    depth, colours = kind.split(":")
    path = f"{depth}{colours}" + (".exr" if depth[0] == "F" else ".png")
    if not Path(path).exists():
        sample = "sample:brick" if colours == "Y" else "sample:stones"
        depth = {"U8": "8", "U16": "16", "F16": "half", "F32": "float"}[depth]
        command("grow", sample, "-o", path, "--size", f"{WIDTH}x{HEIGHT}", "-m", "repeat", "--depth", depth)
    return path


def pixels():
    """Every depth and model: equal to the command's, on a layer above or a new document; the old stays."""
    for kind in KINDS:
        path = example(kind)
        doc, node = opened(path)
        known = node.colorDepth() == kind.split(":")[0] and (node.colorModel() == "GRAYA") == (kind[-1] == "Y")
        before, result = data(doc), "result" + Path(path).suffix
        layer = made(doc, "tile")
        command("tile", path, "-o", result, "--seed", 1, "--size", f"{WIDTH}x{HEIGHT}")
        same = data(doc, layer) == data(opened(result)[0]) != before == data(doc, node)
        above = [n.name() for n in doc.rootNode().childNodes()] == [node.name(), f"{node.name()} tileable"]
        kept = layer.colorProfile() == node.colorProfile() and layer.colorDepth() == node.colorDepth()
        say(known and same and above and kept, f"{kind}: tile as the command, on a layer above, depth and profile kept")
        grown = made(doc, "grow", "--size", "120x88", "--wrap", "both")
        command("grow", path, "-o", result, "--seed", 1, "--size", "120x88", "--wrap", "both")
        same = data(grown) == data(opened(result)[0]) and (grown.width(), grown.height()) == (120, 88)
        kept = (grown.colorProfile(), grown.colorDepth()) == (node.colorProfile(), node.colorDepth())
        say(same and kept, f"{kind}: grow as the command, a new document")


def cut():
    """Made tileable and cut where the pattern closes: a new document of that size."""
    path = example("U8:Y")
    doc, _ = opened(path)
    new = made(doc, "tile", fresh=True)
    command("tile", path, "-o", "result.png", "--seed", 1)
    whole, _ = opened("result.png")
    same = data(new) == data(whole) and (new.width(), new.height()) == (whole.width(), whole.height())
    say(same and new.width() < WIDTH, f"cut to {new.width()}x{new.height()} px as the command, a new document")


def transparent():
    """Layers with alpha, against the command on what Krita itself exports of them."""
    for depth, size in (("U8", 1), ("U16", 2), ("F32", 4)):
        doc, node = opened(example(f"{depth}:RGB"))
        raw, low = bytearray(data(doc)), {1: b"\x64", 2: b"\x11\x64", 4: b"\x00\x00\x00\x3f"}[size]
        for y in range(20, 36):
            for x in range(30, 60):
                place = (y * WIDTH + x) * 4 * size + 3 * size
                raw[place : place + size] = low
        node.setPixelData(bytes(raw), 0, 0, WIDTH, HEIGHT)
        doc.refreshProjection()
        doc.waitForDone()
        before, end = data(doc), ".exr" if depth == "F32" else ".png"
        options = InfoObject()
        for name, value in (("alpha", True), ("flatten", True), ("saveSRGBProfile", False), ("forceSRGB", False)):
            options.setProperty(name, value)
        doc.exportImage(str(Path("clear" + end).absolute()), options)
        layer = made(doc, "tile")
        command("tile", "clear" + end, "-o", "result" + end, "--seed", 1, "--size", f"{WIDTH}x{HEIGHT}")
        same = data(doc, layer) == data(opened("result" + end)[0])
        say(same and data(doc, layer) != before, f"{depth}: with alpha as the command on Krita's own export")
        select(doc, 70, 10, 12, 9)
        found = data(doc, made(doc, "heal"))
        step, few = 4 * size, 0
        for place in range(0, len(found), step):
            few += any(found[place + 3 * size : place + step])
        say(108 <= few < 1000, f"{depth}: healed with alpha, {few} px shown of 108 selected")


def parts():
    """Selections: what is healed, and what is grown from."""
    for kind in ("U8:RGB", "U16:Y", "F32:RGB"):
        path = example(kind)
        doc, _ = opened(path)
        select(doc, 40, 20, 14, 9)
        layer = made(doc, "heal")
        mask, result = "mask.png", "healed" + Path(path).suffix
        from intarsia_textures.layers import save_mask

        hole = [40 <= i % WIDTH < 54 and 20 <= i // WIDTH < 29 for i in range(WIDTH * HEIGHT)]
        save_mask(bytes(255 * h for h in hole), WIDTH, HEIGHT, mask)
        command("heal", path, "--mask", mask, "-o", result, "--seed", 1)
        whole, found, before = data(opened(result)[0]), data(doc, layer), data(doc)
        step = len(whole) // (WIDTH * HEIGHT)
        size = step // (2 if kind[-1] == "Y" else 4)
        right = True
        for i, chosen in enumerate(hole):
            pixel, new, old = (every[i * step : (i + 1) * step] for every in (found, whole, before))
            right &= pixel == new if chosen or new != old else not any(pixel[-size:])
        say(right and whole != before, f"{kind}: healed as the command, transparent elsewhere")
    doc, _ = opened(example())
    select(doc, 16, 8, 64, 48)
    grown = made(doc, "grow", "--size", "80x80")
    command("grow", example(), "--crop", "16,8,64,48", "-o", "result.png", "--seed", 1, "--size", "80x80")
    say(data(grown) == data(opened("result.png")[0]), "grown from what is selected, as the command from a crop")
    chosen, hole = Selection(), Selection()
    chosen.select(0, 0, WIDTH, HEIGHT, 255)
    hole.select(40, 20, 14, 9, 255)
    chosen.subtract(hole)
    doc.setSelection(chosen)
    grown = made(doc, "grow", "--size", "80x80")
    usable = bytes(0 if 40 <= i % WIDTH < 54 and 20 <= i // WIDTH < 29 else 255 for i in range(WIDTH * HEIGHT))
    save_mask(usable, WIDTH, HEIGHT, "mask.png")
    command("grow", example(), "--mask", "mask.png", "-o", "result.png", "--seed", 1, "--size", "80x80")
    say(data(grown) == data(opened("result.png")[0]), "grown from a selection with a hole, as the command by a mask")


def refused():
    """One line for bad input, with names that a person knows; nothing changes."""
    app = Krita.instance()
    doc, node = opened(example())
    node.setName("Wall = old")
    for what, prepare, verb, word in (
        ("nothing selected", lambda: doc.setSelection(None), "heal", "Nothing is selected"),
        ("all selected", lambda: select(doc, 0, 0, WIDTH, HEIGHT), "heal", "the selection"),
        ("selected outside", lambda: select(doc, 500, 500, 9, 9), "grow", "outside"),
    ):
        prepare()
        line = trouble(lambda verb=verb: made(doc, verb))
        plain = "krita_" not in line and "/tmp" not in line and "\n" not in line
        say(word in line and plain, f"{what}: {line}")
    doc.setSelection(None)
    say(len(doc.rootNode().childNodes()) == 1, "no layer was added by what failed")
    chosen = SimpleNamespace(activeNode=lambda: doc.createGroupLayer("Group"))
    say("no paint layer" in (line := trouble(lambda: made(chosen, "tile"))), f"a group: {line}")
    for model, depth in (("CMYKA", "U8"), ("LABA", "U16")):
        other = app.createDocument(WIDTH, HEIGHT, "other", model, depth, "", 72.0)
        line = trouble(lambda other=other: made(other, "tile"))
        say("gray and RGB" in line, f"{model}: {line}")
    clear = app.createDocument(WIDTH, HEIGHT, "clear", "RGBA", "U8", "", 72.0)
    layer = clear.rootNode().childNodes()[0]
    layer.setPixelData(bytes(4 * WIDTH * HEIGHT), 0, 0, WIDTH, HEIGHT)
    line = trouble(lambda: made(clear, "grow", "--size", "80x80"))
    say("is empty" in line, f"a layer that is clear: {line}")
    say("No picture" in trouble(lambda: made(None, "tile")), "no picture")


def elsewhere():
    """What changes while it works: a layer or a picture that goes; and a layer of another depth than its picture."""
    from intarsia_textures.work import Work

    def begun(doc, verb="tile"):
        work = Work(COMMAND, doc, verb, ["--seed", 1])
        while not work.call.poll():
            time.sleep(0.02)
        return work

    doc, node = opened(example())
    other = doc.createNode("Gray", "paintlayer")
    gray, base = opened(example("U16:Y"))
    doc.rootNode().addChildNode(other, None)
    other.setColorSpace("GRAYA", "U16", base.colorProfile())
    node.remove()
    doc.waitForDone()
    other.setPixelData(data(gray), 0, 0, WIDTH, HEIGHT)
    layer = made(doc, "tile")
    expected = made(gray, "tile")
    kept = (layer.colorModel(), layer.colorDepth()) == ("GRAYA", "U16")
    say(kept and data(doc, layer) == data(gray, expected), "a gray layer of 16 bit in an RGB picture of 8")
    work = begun(doc)
    other.remove()
    layer.remove()
    doc.waitForDone()
    work.place()
    names = [n.name() for n in doc.rootNode().childNodes()]
    say(names == ["Gray tileable"], f"the layer was removed meanwhile: {names}")
    work = begun(gray)
    gray.close()
    line = trouble(work.place)
    say("closed meanwhile" in line and left() == ([], []), line)


def left():
    """Return the folders and the processes of the plug-in that are there."""
    mine = []
    for about in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):  # it has ended meanwhile
            mine += [about.parent.name] if b"krita_layer" in about.read_bytes() else []
    return glob(f"{tempfile.gettempdir()}/intarsia-plugin-*/krita_*"), mine


def stopped():
    """A run that is stopped ends within a second, and leaves nothing."""
    from intarsia_textures.work import Work

    doc, _ = opened(example())
    work = Work(COMMAND, doc, "grow", ["--size", "6000x6000"])
    until = time.time() + 60
    while work.call.fraction == 0 and time.time() < until and not work.call.poll():
        time.sleep(0.02)
    pid, began = work.call._process.pid, time.time()
    work.stop()
    took = time.time() - began
    gone = not Path(f"/proc/{pid}").exists()
    say(gone and took < 1 and left() == ([], []), f"stopped in {took:.2f} s at {work.call.words()}; left: {left()}")


def asked():
    """The dialogs: few fields, remembered values, words of the command line."""
    from intarsia_textures.dialogs import Asking, options_of

    for verb, words in (
        ("grow", ["--seed", 7, "--size", "192x128", "--wrap", "both", "--method", "auto"]),
        ("tile", ["--seed", 7, "--axes", "both"]), ("heal", ["--seed", 7, "--wrap", "none"]),
    ):  # fmt: skip
        dialog = Asking(verb, (WIDTH, HEIGHT))
        dialog.fields["seed"].setValue(7)
        found = options_of(verb, dialog.values())
        again = Asking(verb, (WIDTH, HEIGHT)).values()["seed"]
        say(found == words and again == 7 and len(dialog.fields) <= 5, f"dialog of {verb}: {found}")


def until_over(plugin, most=90):
    """Let Krita go on until a run is over; return how often it did."""
    from intarsia_textures.qt import QtCore

    until, turns = time.time() + most, 0
    while not plugin.waiting.over and time.time() < until:
        QtCore.QCoreApplication.processEvents()
        time.sleep(0.01)
        turns += 1
    return turns


def waited():
    """The progress dialog: Krita goes on beside it, the result comes, and Cancel ends a run."""
    from intarsia_textures.extension import Textures

    doc, _ = opened(example())
    plugin = Textures(Krita.instance())
    plugin.start(COMMAND, doc, "tile", {"seed": 1, "axes": "both", "band": 0, "around": False, "shape": "keep"})
    turns = until_over(plugin)
    say(len(doc.rootNode().childNodes()) == 2 and turns > 10, "the result comes beside a progress dialog")
    values = {"seed": 1, "width": 6000, "height": 6000, "wrap": "none", "method": "auto"}
    plugin.start(COMMAND, doc, "grow", values)
    until_over(plugin, 2)
    began = time.time()
    plugin.waiting.bar.canceled.emit()
    took = time.time() - began
    say(took < 1 and left() == ([], []), f"Cancel ends it in {took:.2f} s; left: {left()}")
    plugin.waiting.stop()
    say(plugin.waiting.over, "a second end does no harm")


def missing():
    """The program is not there, or does not belong to the plug-in."""
    from intarsia_textures import calling
    from intarsia_textures.dialogs import Missing
    from intarsia_textures.extension import Textures

    line = trouble(lambda: calling.command("/nowhere/intarsia"))
    say("no file" in line, line)
    dialog = Missing(line)
    dialog.path.setText("/x")
    dialog._install()
    say(dialog.installs, "the dialog offers to install it")
    plugin, real = Textures(Krita.instance()), calling.install
    try:
        for install, word in ((lambda told: told("a step") or time.sleep(0.3), ""), (lambda told: 1 / 0, "It failed")):
            calling.install = install
            plugin.install()
            line = trouble(lambda: until_over(plugin))
            say(plugin.waiting.over and line == "", f"installed beside Krita {word}")
    finally:
        calling.install = real
    other = Path("other")
    other.write_text('#!/bin/sh\necho \'{"version": "9", "contract": 99}\'\n')
    other.chmod(0o755)
    line = trouble(lambda: calling.checked([str(other.absolute())]))
    say("do not belong together" in line, line)
    say(calling.checked(calling.command(COMMAND[0]))["contract"] == calling.CONTRACT, "the command answers")
