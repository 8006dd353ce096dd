"""Runs inside Blender with a window: dialogs, progress, Esc, redo and undo, and a file that is opened meanwhile.

intarsia install-plugin blender --to DIR/user_default
BLENDER_USER_EXTENSIONS=DIR INTARSIA=intarsia LIBGL_ALWAYS_SOFTWARE=1 xvfb-run blender --factory-startup \
    --enable-event-simulate --window-geometry 0 0 1280 800 --python tests/programs/blender_window.py

Any DISPLAY will do in place of xvfb-run. INTARSIA is the command to compare with, one path; SHOTS a folder for pictures
of the window, if they are wanted (ImageMagick's ``import`` takes them). 77: the plug-in is not where Blender looks, or
there is no window.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path

import bpy

MODULE = "bl_ext.user_default.intarsia_textures"
INTARSIA = os.environ.get("INTARSIA", "intarsia")
SHOTS = os.environ.get("SHOTS")
HERE = Path(tempfile.mkdtemp(prefix="check-blender-"))
TEMPORARY = HERE / "temporary"  # no other program's
TEMPORARY.mkdir()
tempfile.tempdir = str(TEMPORARY)
LONGEST = 120  # s for a run
failed = []


def check(what, good):
    """Say whether it is as it should be."""
    print("OK  " if good else "FAIL", what, flush=True)
    if not good:
        failed.append(what)


def window():
    """Return the window."""
    return bpy.context.window_manager.windows[0]


def editor(kind):
    """Make the largest area an editor of this kind, and return it."""
    area = max(window().screen.areas, key=lambda area: area.width * area.height)
    if area.ui_type != kind:
        area.ui_type = kind
    return area


def inside(area):
    """Work in an area."""
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=window(), area=area, region=region)


def press(key):
    """Press and release a key."""
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type=key, value=value, x=400, y=400)


def shot(name):
    """Keep a picture of the window."""
    if SHOTS:
        subprocess.run(["import", "-window", "root", Path(SHOTS) / f"{name}.png"], check=True)


def busy():
    """Return whether a run is on."""
    return sys.modules[f"{MODULE}.running"].Running.busy


def until_idle():
    """Wait for the run to end."""
    begun = time.monotonic()
    while busy() and time.monotonic() - begun < LONGEST:
        yield 0.2
    yield 0.5


def scene():
    """Make a material of three maps, and show its nodes."""
    subprocess.run(
        [INTARSIA, "grow", "sample:setts", "-o", HERE / "setts.png", "--size", "256", "-m", "repeat", "--quiet"],
        check=True, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    material = bpy.data.materials.new("Setts")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    normal = tree.nodes.new("ShaderNodeNormalMap")
    normal.location = (-300, -100)
    tree.links.new(normal.outputs[0], shader.inputs["Normal"])
    sockets = {"": shader.inputs["Base Color"], "_roughness": shader.inputs["Roughness"],
               "_normal": normal.inputs["Color"]}  # fmt: skip
    for row, (ending, socket) in enumerate(sockets.items()):
        node = tree.nodes.new("ShaderNodeTexImage")
        node.location = (-650, 500 - 300 * row)
        node.image = bpy.data.images.load(str(HERE / f"setts{ending}.png"))
        node.image.colorspace_settings.name = "Non-Color" if ending else "sRGB"
        tree.links.new(node.outputs[0], socket)
    bpy.data.objects["Cube"].data.materials.clear()
    bpy.data.objects["Cube"].data.materials.append(material)
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]


def worn():
    """Return the name of the cube's material."""
    return bpy.data.objects["Cube"].active_material.name


def same(name, *words):
    """Return whether an image is what the command makes of the set."""
    maps = [w for m in ("normal", "roughness") for w in ("--map", f"{m}={HERE}/setts_{m}.png")]
    out = HERE / "e.png"
    subprocess.run(
        [INTARSIA, "grow", HERE / "setts.png", *maps, "-o", out, "--wrap", "both", *words, "--force", "--quiet"],
        check=True, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    wanted = bpy.data.images.load(str(out))
    good = bpy.data.images[name].pixels[:] == wanted.pixels[:]
    bpy.data.images.remove(wanted)
    return good


def grown():
    """The dialog, a run to its end, the redo panel, undo."""
    area = editor("ShaderNodeTree")
    yield 1
    with inside(area):
        bpy.ops.node.view_all()
        bpy.ops.ed.undo_push(message="the scene")
        bpy.ops.material.intarsia_grow("INVOKE_DEFAULT", verb="grow")
    yield 1
    shot("dialog")
    check("the dialog changes nothing", not busy() and worn() == "Setts")
    press("RET")
    yield 1
    check("Blender goes on while the program works", busy())
    shot("progress")
    yield from until_idle()
    shot("grown")
    check("the object has the grown material", worn() == "Setts_grown")
    check("the size is twice the example's", tuple(bpy.data.images["setts_grown"].size) == (512, 512))
    last = bpy.context.window_manager.operators[-1]
    last.properties.seed = 5
    with inside(area):
        bpy.ops.screen.redo_last("INVOKE_DEFAULT")
    yield 0.5
    shot("redo")
    press("ESC")
    yield 0.5
    with inside(area):
        bpy.ops.ed.undo_redo("EXEC_DEFAULT", True)  # what a change in the redo panel does
    yield 0.5
    check("another seed replaces the result", worn() == "Setts_grown" and "setts_grown.001" not in bpy.data.images)
    check("it is of the first input", same("setts_grown", "--seed", "5"))
    with inside(area):
        bpy.ops.ed.undo()
    yield 0.5
    check("undo takes all away", worn() == "Setts" and "setts_grown" not in bpy.data.images)


def stopped():
    """Esc, and a file that is opened meanwhile."""
    area = editor("ShaderNodeTree")
    count = len(bpy.data.images)
    for how in ("Esc", "another file"):
        with inside(area):
            bpy.ops.material.intarsia_grow("INVOKE_DEFAULT", verb="grow", size=(4096, 4096))
        yield 1
        press("RET")
        yield 2
        child = _child()
        check(f"it works until {how}", busy() and any(TEMPORARY.iterdir()) and child != "none")
        if how == "Esc":
            press("ESC")
        else:
            bpy.ops.wm.read_homefile()
        yield 1
        check(f"{how} ends the run", not busy() and not os.path.exists(f"/proc/{child}"))
        check("no folder is left", not any(TEMPORARY.iterdir()))
        if how == "Esc":
            check("nothing was changed", worn() == "Setts" and len(bpy.data.images) == count)
        yield 0.5


def _child():
    """Return the number of the process of the program."""
    ours = str(os.getpid())
    for entry in Path("/proc").glob("[0-9]*/stat"):
        fields = entry.read_text().rpartition(")")[2].split()
        if fields[1] == ours and (entry.parent / "cmdline").read_bytes().count(b"--with-parent"):
            return entry.parent.name
    return "none"


def images():
    """The dialogs of the image editor; one that is left does nothing."""
    area = editor("IMAGE_EDITOR")
    area.spaces.active.image = bpy.data.images["setts.png"]
    yield 0.5
    with inside(area):
        bpy.ops.ed.undo_push(message="the image")
    for name in ("tile", "heal", "grow"):
        with inside(area):
            getattr(bpy.ops.image, f"intarsia_{name}")("INVOKE_DEFAULT")
        yield 1
        shot(f"image-{name}")
        press("RET" if name == "grow" else "ESC")
        yield 0.5
    yield from until_idle()
    check("the editor shows the new image", area.spaces.active.image.name == "setts_grown")
    shot("image-grown")
    first = bpy.data.images["setts_grown"].pixels[:]
    bpy.context.window_manager.operators[-1].properties.seed = 9
    with inside(area):
        again = bpy.ops.ed.undo_redo("EXEC_DEFAULT", True)
    yield 0.5
    changed = bpy.data.images["setts_grown"].pixels[:] != first and "setts_grown.001" not in bpy.data.images
    check("redo finds the first image again", again == {"FINISHED"} and changed)
    check("the editor shows what redo has made", area.spaces.active.image.name == "setts_grown")
    area.spaces.active.image = bpy.data.images["setts.png"]
    bpy.data.images.remove(bpy.data.images["setts_grown"])
    preferences = bpy.context.preferences.addons[MODULE].preferences
    preferences.program = str(HERE / "none")
    with inside(area):
        bpy.ops.image.intarsia_grow("INVOKE_DEFAULT")
    yield 1
    shot("missing")
    press("ESC")
    preferences.program = INTARSIA
    yield 0.5


def main():
    """Run all, with pauses in which Blender draws."""
    scene()
    for part in (images, grown, stopped):
        yield from part()


def step():
    """Run until the next pause; called by a timer."""
    try:
        return next(steps)
    except StopIteration:
        print(f"{len(failed)} failed" if failed else "all is well", flush=True)
    except Exception:
        traceback.print_exc()
        check("no error in the check itself", False)
    shutil.rmtree(HERE, ignore_errors=True)
    sys.stdout.flush()
    os._exit(1 if failed else 0)  # quitting would ask whether to save


bpy.ops.preferences.addon_enable(module=MODULE)
if bpy.app.background or MODULE not in bpy.context.preferences.addons:
    print(f"{MODULE} is not there, or there is no window.")
    sys.exit(77)
bpy.context.preferences.addons[MODULE].preferences.program = INTARSIA
bpy.context.preferences.view.show_splash = False
steps = main()
bpy.app.timers.register(step, first_interval=1, persistent=True)
