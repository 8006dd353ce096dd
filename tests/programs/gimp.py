"""Runs inside GIMP 3, and compares what the plug-in makes with what the command makes of the same pixels.

    INTARSIA=/path/to/intarsia gimp-console-3.0 -idf --batch-interpreter=python-fu-eval \
        -b "exec(open('tests/programs/gimp.py').read())" --quit

INTARSIA is the command to compare with; words are split at blanks. The plug-in must be in GIMP's folder of plug-ins
(``intarsia install-plugin gimp``, or ``--to`` with GIMP3_DIRECTORY/plug-ins for a GIMP3_DIRECTORY of its own), and find
the same program: by the command in its installed.json, else as ``intarsia`` on PATH. Needs no display. Prints
``OK what`` or ``FAIL what``. GIMP's exit code is 64 if something failed: it knows no other.
"""

import glob
import json
import os
import random
import shlex
import shutil
import signal
import struct
import subprocess
import tempfile
import threading
import time

from gi.repository import Gegl, Gimp, Gio

COMMAND = shlex.split(os.environ.get("INTARSIA", "intarsia"))
WIDTH, HEIGHT = 160, 112
failed = []
folder = tempfile.mkdtemp(prefix="intarsia-check-")
os.chdir(folder)


def check(what, good):
    if not good:
        failed.append(what)
    print("OK" if good else "FAIL", what, flush=True)


def cli(*words):
    """Run the command; return what it tells."""
    asked = [*COMMAND, *map(str, words), "--force", "--quiet", "--json"]
    return json.loads(subprocess.run(asked, check=True, capture_output=True).stdout)


def load(path):
    return Gimp.file_load(Gimp.RunMode.NONINTERACTIVE, Gio.File.new_for_path(path))


def area(layer):
    return Gegl.Rectangle.new(0, 0, layer.get_width(), layer.get_height())


def pixels(image, form, n=0):
    layer = image.get_layers()[n]
    return layer.get_buffer().get(area(layer), 1.0, form, Gegl.AbyssPolicy.NONE)


def made_of(path, form):
    return pixels(load(path), form)


def call(name, image, layers=None, **values):
    """Call a procedure of the plug-in; return the new image, or True, or the line of the error."""
    found = Gimp.get_pdb().lookup_procedure(f"plug-in-intarsia-{name}")
    config = found.create_config()
    config.set_property("run-mode", Gimp.RunMode.NONINTERACTIVE)
    config.set_property("image", image)
    config.set_core_object_array("drawables", layers or [image.get_layers()[0]])
    for key, value in values.items():
        config.set_property(key, value)
    told = found.run(config)
    if told.index(0) != Gimp.PDBStatusType.SUCCESS:
        return Gimp.get_pdb().get_last_error()
    return told.index(1) if told.length() > 1 else True


def painted(precision, kind, form, bits, size=(96, 64), name="Stones"):
    """Return an image of one layer with these pixels."""
    gray = kind in (Gimp.ImageType.GRAY_IMAGE, Gimp.ImageType.GRAYA_IMAGE)
    base = Gimp.ImageBaseType.GRAY if gray else Gimp.ImageBaseType.RGB
    image = Gimp.Image.new_with_precision(*size, base, precision)
    layer = Gimp.Layer.new(image, name, *size, kind, 100, Gimp.LayerMode.NORMAL)
    image.insert_layer(layer, None, 0)
    layer.get_buffer().set(area(layer), form, bits)
    layer.update(0, 0, *size)
    return image, layer


def selection(image, box):
    grey = image.get_selection().get_buffer()
    return grey.get(Gegl.Rectangle.new(*box), 1.0, "Y u8", Gegl.AbyssPolicy.NONE)


def write_mask(bits, size, name):
    mask, _ = painted(
        Gimp.Precision.U8_NON_LINEAR, Gimp.ImageType.GRAY_IMAGE, "Y' u8", bytes(255 if v else 0 for v in bits), size
    )
    Gimp.file_save(Gimp.RunMode.NONINTERACTIVE, mask, Gio.File.new_for_path(name), None)
    mask.delete()


def changes(before, after, n):
    return {i for i in range(len(before) // n) if before[i * n : i * n + n] != after[i * n : i * n + n]}


def depths():
    for bits, form in ((8, "R'G'B' u8"), (16, "R'G'B' u16")):
        given = f"given{bits}.png"
        cli("grow", "sample:stones", "-o", given, "--size", f"{WIDTH}x{HEIGHT}", "-m", "repeat", "--depth", bits)
        image = load(given)
        new = call("grow", image, width=200, height=144, wrap="both", seed=3)
        cli("grow", given, "-o", "out.png", "--size", "200x144", "--wrap", "both", "--seed", 3)
        check(f"grow, {bits} bit: as the command", pixels(new, form) == made_of("out.png", form))
        check(f"grow, {bits} bit: its depth stays", new.get_precision() == image.get_precision())

        before = pixels(image, form)
        call("tile", image, crop=False, seed=1)
        cli("tile", given, "-o", "out.png", "--seed", 1, "--size", f"{WIDTH}x{HEIGHT}")
        check(f"tile, {bits} bit: as the command", pixels(image, form) == made_of("out.png", form) != before)

        image = load(given)
        image.get_layers()[0].set_name("Wall")
        call("tile", image, seed=1)
        width, height = cli("tile", given, "-o", "out.png", "--seed", 1)["size"]
        check(f"tile, {bits} bit: cropped as by the command", pixels(image, form) == made_of("out.png", form))
        fits = (image.get_width(), image.get_height()) == (width, height) != (WIDTH, HEIGHT)
        check("tile: the canvas is cropped, too", fits)

        image = load(given)
        image.select_rectangle(Gimp.ChannelOps.REPLACE, 60, 40, 30, 20)
        write_mask(selection(image, (0, 0, WIDTH, HEIGHT)), (WIDTH, HEIGHT), "hole.png")
        call("heal", image, enlarge=0, reach=0, seed=2)
        cli("heal", given, "-o", "out.png", "--mask", "hole.png", "--grow", 0, "--seed", 2)
        check(f"heal, {bits} bit: as the command", pixels(image, form) == made_of("out.png", form) != before)
        check("heal: can be undone", image.is_dirty())

        image = load(given)
        call("uncrop", image, left=10, right=20, top=5, bottom=0)
        cli("extend", given, "-o", "out.png", "--left", 10, "--right", 20, "--top", 5)
        check(f"uncrop, {bits} bit: as the command", pixels(image, form) == made_of("out.png", form))
        check("uncrop: the canvas grew", (image.get_width(), image.get_height()) == (WIDTH + 30, HEIGHT + 5))


def healing():
    image = load("given8.png")
    before = pixels(image, "R'G'B' u8")
    image.select_ellipse(Gimp.ChannelOps.REPLACE, 50, 40, 40, 30)
    old = selection(image, (0, 0, WIDTH, HEIGHT))
    call("heal", image, enlarge=4, reach=0)
    check("heal: the selection stays", selection(image, (0, 0, WIDTH, HEIGHT)) == old)
    check("heal: the selected layer stays, no channel is left", len(image.get_channels()) == 0)
    Gimp.Selection.grow(image, 4)
    grown = selection(image, (0, 0, WIDTH, HEIGHT))
    changed = changes(before, pixels(image, "R'G'B' u8"), 3)
    there = {i for i, v in enumerate(grown) if v}
    check("heal: what is enlarged is healed, the rest stays", changed <= there and len(changed) > 0.9 * len(there))

    image = load("given8.png")
    image.select_rectangle(Gimp.ChannelOps.REPLACE, 70, 40, 20, 20)
    write_mask(bytes(255 if 18 <= i // WIDTH < 82 else 0 for i in range(WIDTH * HEIGHT)), (WIDTH, HEIGHT), "usable.png")
    write_mask(selection(image, (0, 0, WIDTH, HEIGHT)), (WIDTH, HEIGHT), "hole.png")
    call("heal", image, enlarge=0, reach=0, take="sides")
    cli("heal", "given8.png", "-o", "out.png", "--mask", "hole.png", "--grow", 0, "--usable", "usable.png")
    check("heal from the sides: as the command", pixels(image, "R'G'B' u8") == made_of("out.png", "R'G'B' u8"))

    image, other = load("given8.png"), load("out.png")
    image.select_rectangle(Gimp.ChannelOps.REPLACE, 70, 40, 20, 20)
    call("heal", image, enlarge=0, reach=0, take="other", source=other.get_layers()[0])
    cli("heal", "given8.png", "-o", "out2.png", "--mask", "hole.png", "--grow", 0, "--from", "out.png")
    check("heal from another image: as the command", pixels(image, "R'G'B' u8") == made_of("out2.png", "R'G'B' u8"))

    image = load("given8.png")
    image.select_rectangle(Gimp.ChannelOps.REPLACE, 10, 12, 50, 40)
    before = pixels(image, "R'G'B' u8")
    call("fill", image, source=other.get_layers()[0], seed=5)
    cli("grow", "out.png", "-o", "out3.png", "--size", "50x40", "--seed", 5)
    after, piece = pixels(image, "R'G'B' u8"), made_of("out3.png", "R'G'B' u8")
    rows = [after[3 * (WIDTH * y + 10) : 3 * (WIDTH * y + 60)] for y in range(12, 52)]
    check("fill: as the command", b"".join(rows) == piece)
    inside = {WIDTH * y + x for y in range(12, 52) for x in range(10, 60)}
    check("fill: the rest stays", changes(before, after, 3) <= inside)


def kinds():
    """Profiles, alpha, floats, gray, offsets."""
    random.seed(1)
    noise = bytes(random.randrange(256) for _ in range(96 * 64 * 3))
    image, layer = painted(Gimp.Precision.U8_NON_LINEAR, Gimp.ImageType.RGB_IMAGE, "R'G'B' u8", noise)
    profile = Gimp.ColorProfile.new_rgb_adobe()
    image.set_color_profile(profile)
    new = call("grow", image, width=96, height=64, wrap="none", seed=1)
    check("profile: stays", new.get_color_profile() and new.get_color_profile().get_label() == profile.get_label())
    new.set_color_profile(Gimp.ColorProfile.new_rgb_srgb())
    seen = pixels(new, "R'G'B' u8")
    given = {noise[i : i + 3] for i in range(0, len(noise), 3)}
    shared = sum(seen[i : i + 3] in given for i in range(0, len(seen), 3)) / (96 * 64)
    check("profile: pixels are those of the layer, not converted", shared > 0.9)
    call("tile", image, crop=False, seed=1)
    image.set_color_profile(Gimp.ColorProfile.new_rgb_srgb())
    kept = pixels(image, "R'G'B' u8")
    middle = 3 * (32 * 96 + 40)
    check("profile: what does not change is the same bytes", kept[middle : middle + 30] == noise[middle : middle + 30])

    floats = struct.pack(f"{96 * 64 * 3}f", *[4 * random.random() for _ in range(96 * 64 * 3)])
    for precision in (Gimp.Precision.FLOAT_LINEAR, Gimp.Precision.HALF_LINEAR):
        image, layer = painted(precision, Gimp.ImageType.RGB_IMAGE, "RGB float", floats)
        before = pixels(image, "RGB float")
        call("tile", image, crop=False, seed=1)
        after = pixels(image, "RGB float")
        middle = slice(12 * (32 * 96 + 40), 12 * (32 * 96 + 50))
        check(f"{precision.value_nick}: the middle is the same bits", before[middle] == after[middle])
        new = call("grow", image, width=80, height=80, wrap="none", method="image-quilting", seed=1)
        seen, made = pixels(new, "RGB float"), {after[i : i + 12] for i in range(0, len(after), 12)}
        exact = sum(seen[i : i + 12] in made for i in range(0, len(seen), 12))
        check(f"{precision.value_nick}: grown pixels are the same bits", exact > 6000)
        check(f"{precision.value_nick}: depth stays", new.get_precision() == precision)

    four = [random.random() if i % 4 < 3 else 0.25 + 0.7 * random.random() for i in range(96 * 64 * 4)]
    four = struct.pack(f"{len(four)}f", *four)
    image, layer = painted(Gimp.Precision.FLOAT_LINEAR, Gimp.ImageType.RGBA_IMAGE, "RGBA float", four)
    before = pixels(image, "RGBA float")
    call("tile", image, crop=False, seed=1)
    after, middle = pixels(image, "RGBA float"), slice(16 * (32 * 96 + 40), 16 * (32 * 96 + 50))
    check("float with alpha: the middle is the same bits", before[middle] == after[middle])
    check("float with alpha: changed", before != after)

    for name in ("u8-linear", "u8-perceptual", "u16-perceptual", "u32-linear", "u32-non-linear", "half-non-linear",
                 "float-non-linear", "double-linear"):  # fmt: skip
        precision = getattr(Gimp.Precision, name.upper().replace("-", "_"))
        image, layer = painted(precision, Gimp.ImageType.RGB_IMAGE, "R'G'B' u8", noise)
        before = pixels(image, "R'G'B' u16")
        done = call("tile", image, crop=False, seed=1)
        after, middle = pixels(image, "R'G'B' u16"), slice(6 * (32 * 96 + 40), 6 * (32 * 96 + 50))
        check(f"{name}: {done}, the middle is the same", before[middle] == after[middle] and before != after)

    wide = struct.pack("<6144H", *[random.randrange(65536) for _ in range(6144)])
    for precision in (Gimp.Precision.U16_LINEAR, Gimp.Precision.U16_NON_LINEAR):
        form = "Y u16" if precision == Gimp.Precision.U16_LINEAR else "Y' u16"
        image, layer = painted(precision, Gimp.ImageType.GRAY_IMAGE, form, wide)
        call("tile", image, crop=False, seed=1)
        after, middle = pixels(image, form), 2 * (32 * 96 + 40)
        same = after[middle : middle + 20] == wide[middle : middle + 20]
        check(f"gray {precision.value_nick}: the middle is the same bits", same and after != wide)

    bits = bytes(random.randrange(256) if i % 4 < 3 else (0 if i // 4 % 96 < 9 else 255) for i in range(96 * 64 * 4))
    image, layer = painted(Gimp.Precision.U8_NON_LINEAR, Gimp.ImageType.RGBA_IMAGE, "R'G'B'A u8", bits)
    image.resize(160, 112, 20, 10)
    image.select_rectangle(Gimp.ChannelOps.REPLACE, 45, 25, 12, 10)
    call("heal", image, enlarge=0)
    changed = changes(bits, pixels(image, "R'G'B'A u8"), 4)
    inside = {96 * y + x for y in range(15, 25) for x in range(25, 37)}
    check("a layer that lies elsewhere: healed there", changed and changed <= inside)
    Gimp.Selection.none(image)
    write = Gimp.Image.new(96, 64, Gimp.ImageBaseType.RGB)
    write.insert_layer(Gimp.Layer.new_from_drawable(layer, write), None, 0)
    Gimp.file_save(Gimp.RunMode.NONINTERACTIVE, write, Gio.File.new_for_path("clear.tif"), None)
    before = pixels(image, "R'G'B'A u8")
    call("heal-transparency", image, enlarge=0)
    after = pixels(image, "R'G'B'A u8")
    hole = {96 * y + x for y in range(64) for x in range(9)}
    check("transparency: filled", changes(before, after, 4) == hole and all(after[4 * i + 3] == 255 for i in hole))
    call("tile", image, crop=False)
    check("tile keeps alpha", layer.has_alpha())


def materials():
    cli("grow", "sample:setts", "-o", "set_albedo.png", "--size", "144x128", "--depth", 8)
    image = load("set_albedo.png")
    names = ("normal", "roughness", "height")
    image.get_layers()[0].set_name("setts_albedo.png")
    for name in names:
        file = Gio.File.new_for_path(f"set_albedo_{name}.png")
        layer = Gimp.file_load_layer(Gimp.RunMode.NONINTERACTIVE, image, file)
        layer.set_name(f"setts {name} copy")
        image.insert_layer(layer, None, 1)
    layers = list(image.get_layers())
    files = [f"given_{layer.get_name().split()[1]}.png" if n else "given.png" for n, layer in enumerate(layers)]
    for path, layer in zip(files, layers, strict=True):
        one = Gimp.Image.new(144, 128, Gimp.ImageBaseType.RGB)
        one.insert_layer(Gimp.Layer.new_from_drawable(layer, one), None, 0)
        Gimp.file_save(Gimp.RunMode.NONINTERACTIVE, one, Gio.File.new_for_path(path), None)
    new = call("grow", image, layers, width=160, height=96, wrap="both", seed=4)
    told = cli("grow", *files, "-o", "big.png", "--size", "160x96", "--wrap", "both", "--seed", 4)
    made = {file["holds"]: file["path"] for file in told["files"]}
    order = {layer.get_name(): n for n, layer in enumerate(new.get_layers())}
    for layer in layers:
        what = next((n for n in names if n in layer.get_name()), "albedo")
        same = pixels(new, "R'G'B' u8", order[layer.get_name()]) == made_of(made[what], "R'G'B' u8")
        check(f"material: {what} as the command", same)
    alone = call("grow", image, [layers[1]], width=96, height=96, wrap="none", seed=4)
    name = files[1].replace("given", "alone")
    os.rename(files[1], name)
    cli("grow", name, "-o", "alone.png", "--size", "96x96", "--seed", 4)
    check("material: a map alone as the command", pixels(alone, "R'G'B' u8") == made_of("alone.png", "R'G'B' u8"))
    image.select_rectangle(Gimp.ChannelOps.REPLACE, 60, 40, 30, 20)
    before = [pixels(image, "R'G'B' u8", n) for n in range(4)]
    check("material: healed", call("heal", image, layers) is True)
    for n in range(4):
        check(f"material: map {n} is healed", before[n] != pixels(image, "R'G'B' u8", n))
    layers[1].set_name("setts")
    line = call("grow", image, layers[:2])
    check("material: two pictures are refused: " + str(line), "both are the albedo" in str(line))


def refusals():
    def told(what, line, *words):
        check(f"{what}: {line}", isinstance(line, str) and all(w in line for w in words) and "\n" not in line)

    image = load("given8.png")
    image.get_layers()[0].set_name("Wall")
    told("nothing selected", call("heal", image), "Select")
    told("no alpha", call("heal-transparency", image), "Wall")
    told("no source", call("fill", image, source=None), "Choose")
    told("no side", call("uncrop", image, left=0, right=0, top=0, bottom=0), "side")
    image.select_rectangle(Gimp.ChannelOps.REPLACE, 0, 0, WIDTH, HEIGHT)
    told("all selected", call("heal", image), "covers all")
    image.select_rectangle(Gimp.ChannelOps.REPLACE, 0, 0, 8, 8)
    told("too small", call("tile", image), "Wall", "small")
    image.resize(WIDTH + 50, HEIGHT, 0, 0)
    image.select_rectangle(Gimp.ChannelOps.REPLACE, WIDTH + 10, 10, 20, 20)
    told("selected elsewhere", call("heal", image), "outside", "Wall")
    Gimp.Selection.none(image)
    image.get_layers()[0].set_lock_content(True)
    told("locked", call("tile", image), "locked", "Wall")
    image = load("given8.png")
    image.convert_indexed(Gimp.ConvertDitherType.NONE, Gimp.ConvertPaletteType.GENERATE, 16, False, False, "")
    told("indexed", call("tile", image), "Indexed")


def running():
    """Return the processes: number, number of the parent, words."""
    found = []
    for path in glob.glob("/proc/[0-9]*"):
        try:
            with open(f"{path}/cmdline", "rb") as file, open(f"{path}/stat") as stat:
                words = file.read().decode("utf-8", "replace").split("\0")
                found.append((int(path[6:]), int(stat.read().rpartition(")")[2].split()[1]), words))
        except OSError:
            continue
    return found


def growing():
    return [pid for pid, _, words in running() if "grow" in words and "9000x9000" in words]


def cancel():
    """GIMP cancels by SIGKILL; the folder is removed by the next call."""
    mark = os.path.join(tempfile.gettempdir(), "intarsia-plugin-*")
    others, seen = set(glob.glob(mark)), {}

    def kill():
        while not growing() and time.time() < started + 60:
            time.sleep(0.05)
        time.sleep(0.5)
        seen["child"] = growing()
        for pid, parent, words in running():
            if parent == os.getppid() and any(word.endswith("intarsia-textures.py") for word in words):
                os.kill(pid, signal.SIGKILL)
        seen["killed"] = time.time()

    image = load("given8.png")
    before, started = pixels(image, "R'G'B' u8"), time.time()
    thread = threading.Thread(target=kill, daemon=True)
    thread.start()
    line = call("grow", image, width=9000, height=9000, wrap="none", seed=1)
    thread.join()
    time.sleep(max(0, seen["killed"] + 1 - time.time()))
    check(f"cancelled: {line}", isinstance(line, str) and seen["child"])
    check("cancelled: no process is left after a second", not growing())
    check("cancelled: nothing is changed", pixels(image, "R'G'B' u8") == before)
    left = set(glob.glob(mark)) - others
    call("grow", image, width=64, height=64, wrap="none", seed=1)
    check("cancelled: the next call removes the folder", not [path for path in left if os.path.exists(path)])


for part in (depths, healing, kinds, materials, refusals, cancel):
    try:
        part()
    except Exception as error:
        import traceback

        traceback.print_exc()
        check(f"{part.__name__}: {type(error).__name__} {error}", False)
os.chdir("/")
shutil.rmtree(folder, ignore_errors=True)
if failed:
    raise SystemExit(f"{len(failed)} checks failed")
