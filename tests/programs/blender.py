"""Runs inside Blender: the plug-in makes what the command makes, says what is wrong, and leaves nothing behind.

intarsia install-plugin blender --to DIR/user_default
BLENDER_USER_EXTENSIONS=DIR INTARSIA=intarsia blender --background --factory-startup --python-exit-code 1 \
    --python tests/programs/blender.py

With bpy from PyPI in place of Blender: ``... INTARSIA=intarsia python tests/programs/blender.py``. INTARSIA is the
command to compare with, one path; the plug-in is told to use it. 77: the plug-in is not where Blender looks.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from array import array
from pathlib import Path

import bpy

MODULE = "bl_ext.user_default.intarsia_textures"
INTARSIA = os.environ.get("INTARSIA", "intarsia")
HERE = Path(tempfile.mkdtemp(prefix="check-blender-"))
TEMPORARY = HERE / "temporary"  # no other program's
TEMPORARY.mkdir()
tempfile.tempdir = str(TEMPORARY)
failed = []


def check(what, good):
    """Say whether it is as it should be."""
    print("OK  " if good else "FAIL", what, flush=True)
    if not good:
        failed.append(what)


def intarsia(*words):
    """Run the command."""
    subprocess.run([INTARSIA, *map(str, words), "--force", "--quiet"], check=True, cwd=HERE, stdin=subprocess.DEVNULL)


def opened(name, space=None):
    """Open a picture."""
    image = bpy.data.images.load(str(HERE / name))
    if space is not None:
        image.colorspace_settings.name = space
    return image


def pixels(image):
    """Return the size and the pixels of an image."""
    held = array("f", bytes(4 * len(image.pixels)))
    image.pixels.foreach_get(held)
    return tuple(image.size), held


def same(image, name):
    """Return whether an image is a picture of the command, pixel for pixel."""
    wanted = opened(name, image.colorspace_settings.name)
    wanted.alpha_mode = image.alpha_mode
    good = pixels(image) == pixels(wanted) and image.depth == wanted.depth and image.packed_file is not None
    bpy.data.images.remove(wanted)
    return good


def refused(what, part, operator, **fields):
    """Run an operator that has to fail, with a part of its one line."""
    before = (len(bpy.data.images), len(bpy.data.materials))
    try:
        operator(**fields)
        line = "nothing was refused"
    except RuntimeError as e:
        line = str(e).strip()
    lines = line.removeprefix("Error: ").splitlines()
    good = part in line and len(lines) == 1 and "intarsia-plugin-" not in line
    check(f"{what}: {line}", good and before == (len(bpy.data.images), len(bpy.data.materials)))


def images():
    """Images grow, become tileable and are healed as by the command."""
    grow, tile, heal = bpy.ops.image.intarsia_grow, bpy.ops.image.intarsia_tile, bpy.ops.image.intarsia_heal
    intarsia("grow", "sample:stones", "-o", "stones.png", "--size", "128x112", "-m", "repeat")
    old = opened("stones.png")
    before = pixels(old)
    grow(input=old.name, size=(200, 144), wrap="both", seed=3)
    intarsia("grow", "stones.png", "-o", "e.png", "--size", "200x144", "--wrap", "both", "--seed", 3)
    new = bpy.data.images["stones_grown"]
    check("an image grows as by the command", same(new, "e.png"))
    check("it keeps its colour space", new.colorspace_settings.name == "sRGB" and new.alpha_mode == old.alpha_mode)
    check("the old one is as it was", pixels(old) == before and not old.is_dirty)
    grow(input=old.name, method="image-quilting", wrap="none")
    intarsia("grow", "stones.png", "-o", "e.png", "--size", "256x224", "--method", "image-quilting")
    check("twice the example without a size, by a method", same(bpy.data.images["stones_grown.001"], "e.png"))
    tile(input=old.name, axes="x", keep_size=True, seed=1)
    intarsia("tile", "stones.png", "-o", "e.png", "--axes", "x", "--size", "128x112", "--seed", 1)
    check("an image becomes tileable as by the command", same(bpy.data.images["stones_tiled"], "e.png"))
    mask = bpy.data.images.new("a mask", 128, 112)
    mask.pixels.foreach_set(
        array("f", [float(40 <= x < 60 and 30 <= y < 50) for y in range(112) for x in range(128) for _ in range(4)])
    )
    mask.filepath_raw, mask.file_format = str(HERE / "mask.png"), "PNG"
    heal(input=old.name, mask=mask.name, seed=2)
    mask.save()
    intarsia("heal", "stones.png", "--mask", "mask.png", "-o", "e.png", "--seed", 2)
    check("an image is healed by a painted mask as by the command", same(bpy.data.images["stones_healed"], "e.png"))
    held = bpy.data.images["stones_healed"].users > 0
    check("what no material uses is kept in the file", held and bpy.data.images["stones_grown"].use_fake_user)
    packed_and_painted(old, grow, tile, heal)
    bad_images(old, grow, heal)


def packed_and_painted(old, grow, tile, heal):
    """Depth, alpha and painted pixels go out and come back."""
    intarsia("grow", "sample:setts", "-o", "setts.png", "--size", "96", "-m", "repeat")
    deep = opened("setts_height.png", "Non-Color")
    deep.pack()
    grow(input=deep.name, size=(128, 128), wrap="none")
    intarsia("grow", "setts_height.png", "-o", "e.png", "--size", "128")
    new = bpy.data.images["setts_height_grown"]
    check("16 bits stay, of a packed image, Non-Color", same(new, "e.png") and new.is_float)
    clear = bpy.data.images.new("clear", 64, 64, alpha=True)
    half = array("f", [0.2 + 0.01 * ((x * 7 + y * 5 + c) % 64) for y in range(64) for x in range(64) for c in range(4)])
    for k in range(3, len(half), 4):
        half[k] = 0.0 if 20 < k // 256 < 30 and 20 < k // 4 % 64 < 30 else 1.0
    clear.pixels.foreach_set(half)
    heal(input="clear")
    clear.filepath_raw, clear.file_format = str(HERE / "clear.png"), "PNG"
    clear.save()
    intarsia("heal", "clear.png", "--mask", "alpha", "-o", "e.png")
    check("what is transparent is healed, of painted pixels", same(bpy.data.images["clear_healed"], "e.png"))
    bright = bpy.data.images.new("bright", 64, 48, float_buffer=True)
    bright.pixels.foreach_set(array("f", [(k * 37 % 101) / 20 if k % 4 < 3 else 1 for k in range(64 * 48 * 4)]))
    tile(input="bright", axes="both")
    floats = bpy.data.images["bright_tiled"]
    new = floats
    size, made = pixels(new)
    (width, _), drawn = pixels(bright)
    rows, columns = range(20, 28), range(28, 36)
    inside = [(y * width + x) * 4 + c for y in rows for x in columns for c in range(3)] if size == (64, 48) else []
    check("floats above 1 stay what they are", inside and all(made[k] == drawn[k] for k in inside) and max(made) > 4)
    deep_and_painted = opened("setts_height.png")
    deep_and_painted.name = "painted"
    deep_and_painted.pixels[0] = 0.5
    tile(input="painted", keep_size=True)
    new = bpy.data.images["painted_tiled"]
    (width, _), made = pixels(new)
    middle = [(40 * width + x) * 4 + c for x in range(40, 56) for c in range(3)]
    drawn = pixels(deep_and_painted)[1]
    check("painted 16 bits stay", max(abs(made[k] - drawn[k]) for k in middle) < 1e-6 and max(made) > 0)
    check("floats are linear", floats.colorspace_settings.name == bright.colorspace_settings.name and floats.is_float)


def bad_images(old, grow, heal):
    """What cannot be worked on is refused in one line."""
    refused("no such image", "no image gone", grow, input="gone")
    refused("no image", "There is no image", grow)
    mask = bpy.data.images.new("all white", 128, 112)
    mask.generated_color = (1, 1, 1, 1)
    refused("a mask that covers all", "all white covers all", heal, input=old.name, mask=mask.name)
    mask.generated_color = (0, 0, 0, 1)
    refused("a mask of nothing", "all white marks nothing", heal, input=old.name, mask=mask.name)
    mask.scale(64, 64)
    refused("a mask of another size", "all white is 64x64 px", heal, input=old.name, mask=mask.name)
    refused("the image as its own mask", "another image", heal, input=old.name, mask=old.name)
    refused("nothing transparent", "no transparency", heal, input=old.name)
    bpy.data.images.new("tiles", 32, 32, tiled=True)
    refused("UDIM", "UDIM", grow, input="tiles")
    sequence = opened("stones.png")
    sequence.name, sequence.source = "frames", "SEQUENCE"
    refused("a sequence", "sequence", grow, input="frames")
    sequence.source = "MOVIE"
    refused("a movie", "movie", grow, input="frames")
    viewer = bpy.data.images.get("Render Result") or bpy.data.images.new("Render Result", 8, 8)
    viewer.source = "VIEWER"
    refused("a render", "render", grow, input="Render Result")
    lost = bpy.data.images.new("lost", 8, 8)
    lost.source, lost.filepath = "FILE", str(HERE / "none.png")
    refused("a lost file", "missing", grow, input="lost")
    refused("too large", "", grow, input=old.name, size=(1 << 20, 1 << 20))
    linked("images", "setts_height.png", "linked", lambda name: refused("a linked image", "linked", grow, input=name))


def linked(kind, name, part, then):
    """Write data to a library, link it, and do something with it."""
    library = str(HERE / f"{kind}.blend")
    own = getattr(bpy.data, kind)[name]
    bpy.data.libraries.write(library, {own})
    own.name = f"local {name}"
    with bpy.data.libraries.load(library, link=True) as (_, into):
        setattr(into, kind, [name])
    then(name)
    bpy.data.libraries.remove(bpy.data.libraries[f"{kind}.blend"])


def material_of(name, **files):
    """Return a material, the tree of its nodes, and a function that adds an image to it."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")

    def image(file, into, data=True, out="Color", tree=tree):
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images.get(file) or opened(file, "Non-Color" if data else "sRGB")
        tree.links.new(node.outputs[out], into)
        return node

    return material, tree, shader, image


def wearing(material):
    """Return an object that has the material."""
    thing = bpy.data.objects.new(material.name, bpy.data.meshes.new(material.name))
    bpy.context.collection.objects.link(thing)
    thing.data.materials.append(material)
    return thing


def grown(thing, **fields):
    """Grow the material of an object, and return the new one."""
    with bpy.context.temp_override(object=thing, active_object=thing):
        bpy.ops.material.intarsia_grow(**fields)
    return thing.active_material


def shown(material):
    """Return the images of a material by name."""
    return {node.image.name: node.image for node in material.node_tree.nodes if node.type == "TEX_IMAGE"}


def setts(name):
    """Return a material of albedo, normal (through a reroute), roughness and height (displacement)."""
    material, tree, shader, image = material_of(name)
    image("setts.png", shader.inputs["Base Color"], data=False)
    image("setts_roughness.png", shader.inputs["Roughness"])
    normal, reroute = tree.nodes.new("ShaderNodeNormalMap"), tree.nodes.new("NodeReroute")
    tree.links.new(reroute.outputs[0], normal.inputs["Color"])
    tree.links.new(normal.outputs[0], shader.inputs["Normal"])
    image("setts_normal.png", reroute.inputs[0])
    displacement, output = tree.nodes.new("ShaderNodeDisplacement"), tree.nodes["Material Output"]
    tree.links.new(displacement.outputs[0], output.inputs["Displacement"])
    image("local setts_height.png", displacement.inputs["Height"])
    return material


def whole_materials():
    """A material grows as one set, in a copy."""
    maps = ("--map", "normal=setts_normal.png", "--map", "height=setts_height.png", "--map",
            "roughness=setts_roughness.png")  # fmt: skip
    old = setts("Setts")
    thing = wearing(old)
    new = grown(thing, size=(160, 128), wrap="both", seed=2)
    intarsia("grow", "setts.png", *maps, "-o", "x.png", "--size", "160x128", "--wrap", "both", "--seed", 2)
    made = shown(new)
    names = {"setts_grown": "x.png", "setts_normal_grown": "x_normal.png", "setts_roughness_grown": "x_roughness.png",
             "local setts_height_grown": "x_height.png"}  # fmt: skip
    check("a material has a copy with new images", new.name == "Setts_grown" and made.keys() == names.keys())
    for name, file in names.items():
        check(f"{name} is as by the command", name in made and same(made[name], file))
    spaces = {name: image.colorspace_settings.name for name, image in made.items()}
    check("colour spaces stay", all(s == ("sRGB" if n == "setts_grown" else "Non-Color") for n, s in spaces.items()))
    before = {"setts.png", "setts_normal.png", "setts_roughness.png", "local setts_height.png"}
    check("the old material is as it was", shown(old).keys() == before)
    new = grown(thing, input="Setts", verb="tile", axes="x", seed=1, asset=True)
    intarsia("tile", "setts.png", *maps, "-o", "x.png", "--axes", "x", "--seed", 1)
    check("a material becomes tileable", new.name == "Setts_grown" and "Setts_tiled" in bpy.data.materials)
    made = shown(bpy.data.materials["Setts_tiled"])
    check("its images are as by the command", same(made["setts_tiled"], "x.png"))
    check("it is marked as an asset", bpy.data.materials["Setts_tiled"].asset_data is not None)
    check("what no object has is kept", bpy.data.materials["Setts_tiled"].users > 0)


def unequal_materials():
    """A map of twice the size, through Bump, beside a JPEG; the image of the height gives the alpha, too."""
    old, tree, shader, image = material_of("Unequal")
    intarsia("grow", "setts.png", "-o", "colour.jpg", "--size", "96", "-m", "repeat")
    intarsia("grow", "sample:gravel", "-o", "double.png", "--size", "192", "-m", "repeat")
    image("colour.jpg", shader.inputs["Base Color"], data=False)
    bump = tree.nodes.new("ShaderNodeBump")
    tree.links.new(bump.outputs[0], shader.inputs["Normal"])
    node = image("double.png", bump.inputs["Height"])
    tree.links.new(node.outputs["Alpha"], shader.inputs["Alpha"])
    made = list(shown(grown(wearing(old), size=(128, 128), wrap="x", seed=4)).values())
    intarsia("grow", "colour.jpg", "--map", "height=double.png", "-o", "x.png", "--size", "128", "--wrap", "x",
             "--seed", 4)  # fmt: skip
    check("a map of twice the size stays so", tuple(made[1].size) == (256, 256))
    check("both are as by the command", same(made[0], "x.png") and same(made[1], "x_height.png"))


def packed_materials():
    """Channels of a packed map, occlusion that is multiplied with the colour, images within groups."""
    old, tree, shader, image = material_of("Packed")
    color = image("setts.png", shader.inputs["Base Color"], data=False)
    parts = tree.nodes.new("ShaderNodeSeparateColor")
    tree.links.new(parts.outputs["Green"], shader.inputs["Roughness"])
    tree.links.new(parts.outputs["Blue"], shader.inputs["Metallic"])
    mix = tree.nodes.new("ShaderNodeMixRGB")
    tree.links.new(color.outputs[0], mix.inputs["Color1"])
    tree.links.new(parts.outputs["Red"], mix.inputs["Color2"])
    tree.links.new(mix.outputs[0], shader.inputs["Base Color"])
    image("setts_normal.png", parts.inputs[0])
    new = grown(wearing(old), size=(96, 96), wrap="none")
    intarsia("grow", "setts.png", "--map", "packed=setts_normal.png", "--packed", "G=roughness,B=metallic,R=ao",
             "-o", "x.png", "--size", "96")  # fmt: skip
    made = list(shown(new).values())
    good = same(made[0], "x.png") and same(made[1], "x_packed.png")
    check("a packed map grows by its channels", good)

    old, tree, shader, _ = material_of("Grouped")
    inner = bpy.data.node_groups.new("Maps", "ShaderNodeTree")
    inner.interface.new_socket("Colour", in_out="OUTPUT", socket_type="NodeSocketColor")
    end, inside = inner.nodes.new("NodeGroupOutput"), inner.nodes.new("ShaderNodeTexImage")
    inside.image = bpy.data.images["setts.png"]
    inner.links.new(inside.outputs[0], end.inputs[0])
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = inner
    tree.links.new(group.outputs[0], shader.inputs["Base Color"])
    new = grown(wearing(old), size=(96, 96), wrap="none")
    trees = [next(n for n in m.node_tree.nodes if n.type == "GROUP").node_tree for m in (old, new)]
    names = [next(n for n in t.nodes if n.type == "TEX_IMAGE").image.name for t in trees]
    check("a group around an image is copied", names[0] == "setts.png" and names[1].startswith("setts_grown"))


def bad_materials():
    """What cannot be worked on is refused in one line."""
    grow = bpy.ops.material.intarsia_grow
    _, _, shader, image = material_of("Bad")
    refused("no image", "No image feeds", grow, input="Bad")
    image("setts.png", shader.inputs["Base Color"], data=False)
    odd = image("stones.png", shader.inputs["Roughness"])
    refused("maps of other shapes", "stones.png 128x112", grow, input="Bad")
    odd.image = bpy.data.images["tiles"]
    refused("a map with UDIM tiles", "tiles has UDIM", grow, input="Bad")
    refused("no such material", "no material gone", grow, input="gone")
    linked("materials", "Bad", "linked", lambda name: refused("a linked material", "linked", grow, input=name))


def stopped():
    """A run that is stopped leaves no process and no folder, within a second."""
    calling = sys.modules[f"{MODULE}.calling"]
    with calling.Folder() as folder:
        out = Path(folder) / "big.png"
        call = calling.Call([INTARSIA], ["grow", HERE / "stones.png", "-o", out, "--size", 2048, "-m", "graphcut"])
        while call.fraction == 0 and not call.poll():
            time.sleep(0.05)
        begun, child = time.monotonic(), call._process
        call.stop()
        took = time.monotonic() - begun
    check(f"a run stops within a second ({took:.2f} s)", took < 1 and child.poll() is not None and not out.exists())
    left = [one.name for one in TEMPORARY.iterdir()]
    check(f"no folder is left {left}", not left)
    check("all threads have ended", all(t is threading.main_thread() or t.daemon for t in threading.enumerate()))


def programs():
    """What is said where the program is missing, or does not belong to the plug-in."""
    own = bpy.context.preferences.addons[MODULE].preferences
    settings = sys.modules[f"{MODULE}.settings"]
    for path, part in ((str(HERE / "none"), "is no file"), (sys.executable, "does not answer")):
        own.program = path
        refused("the program is another", part, bpy.ops.image.intarsia_grow, input="stones.png")
        settings._ask(path)
        check("so do the preferences say", part in settings._lines[path])
    other = HERE / "other"
    other.write_text('#!/bin/sh\necho \'{"version": "9.9.9", "contract": 99}\'\n')
    other.chmod(0o755)
    if os.name != "nt":
        own.program = str(other)
        refused("it does not belong to the plug-in", "9.9.9", bpy.ops.image.intarsia_grow, input="stones.png")
    own.program = INTARSIA
    settings._ask(INTARSIA)
    check(f"the preferences say: {settings._lines[INTARSIA]}", settings._lines[INTARSIA].startswith("intarsia "))
    if not bpy.app.online_access:
        refused("nothing is installed offline", "Online Access", bpy.ops.preferences.intarsia_install)


def saved():
    """A file that is saved holds what was made."""
    bpy.ops.wm.save_as_mainfile(filepath=str(HERE / "made.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(HERE / "made.blend"))
    names = ("stones_grown", "setts_normal_grown", "setts_tiled")
    check("a saved file holds all that was made", all(min(bpy.data.images[name].size) > 0 for name in names))
    check("and the material that it was made of", "Setts" in bpy.data.materials and "setts.png" in bpy.data.images)


def main():
    """Run all; return the exit code."""
    print("Blender", bpy.app.version_string, "Python", sys.version.split()[0])
    try:
        bpy.ops.preferences.addon_enable(module=MODULE)
    except RuntimeError as e:
        print(f"{MODULE} cannot be enabled: {e}")
        return 77
    if MODULE not in bpy.context.preferences.addons:
        print(f"{MODULE} is not there; install-plugin blender --to puts it there.")
        return 77
    bpy.context.preferences.addons[MODULE].preferences.program = INTARSIA
    for part in (images, whole_materials, unequal_materials, packed_materials, bad_materials, stopped, programs, saved):
        part()
    bpy.ops.preferences.addon_disable(module=MODULE)
    check("it can be switched off", not hasattr(bpy.types, "IMAGE_OT_intarsia_grow"))
    print(f"{len(failed)} failed" if failed else "all is well")
    shutil.rmtree(HERE)
    return 1 if failed else 0


sys.exit(main())
