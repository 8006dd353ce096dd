"""The plug-in of Blender, with a Blender that has no more than names: what its parts decide. Inside the real one:
tests/programs/blender.py.
"""

from __future__ import annotations

import importlib
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from intarsia.plugins import KNOWN, install
from intarsia.version import VERSION

NAME = KNOWN["blender"].name


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The installed plug-in, imported as Blender does."""
    bpy, props = ModuleType("bpy"), ModuleType("bpy.props")
    for name in ("Bool", "Enum", "Int", "IntVector", "String"):
        setattr(props, f"{name}Property", dict)
    bpy.props, bpy.path = props, SimpleNamespace(abspath=str)  # type: ignore[attr-defined]
    bpy.types = SimpleNamespace(Operator=object, AddonPreferences=object)  # type: ignore[attr-defined]
    bpy.data = SimpleNamespace(workspaces=[])  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "bpy", bpy)
    monkeypatch.setitem(sys.modules, "bpy.props", props)
    install("blender", str(tmp_path))
    monkeypatch.syspath_prepend(str(tmp_path))
    yield importlib.import_module(NAME)
    for name in [n for n in sys.modules if n.partition(".")[0] == NAME]:
        del sys.modules[name]


def test_manifest_is_what_blender_takes(plugin: ModuleType) -> None:
    manifest = tomllib.loads(Path(str(plugin.__file__)).with_name("blender_manifest.toml").read_text())
    assert manifest["schema_version"] == "1.0.0"
    assert manifest["id"] == NAME
    assert manifest["version"] == VERSION.partition("+")[0].partition(".dev")[0]
    for line in (manifest["tagline"], *manifest["permissions"].values()):
        assert len(line) <= 64
        assert line[-1].isalnum()


def test_menus_name_operators_of_their_editors(plugin: ModuleType) -> None:
    operators = {one.bl_idname: one.bl_label for one in plugin.operators.CLASSES}
    assert {name.partition(".")[0] for name in operators} == {"image", "material"}
    assert list(operators.values()) == ["Grow Texture", "Make Tileable", "Heal by Mask", "Grow Material"]


class Socket:
    def __init__(self, node: Node, name: str, kind: str = "VALUE") -> None:
        self.node, self.name, self.identifier, self.type = node, name, name, kind
        self.links: list[Any] = []

    def link(self, start: Socket) -> None:
        self.links.append(SimpleNamespace(from_node=start.node, from_socket=start))


class Node(SimpleNamespace):
    def __init__(self, type: str, into: str = "", out: str = "Out", kind: str = "VALUE", **more: Any) -> None:
        super().__init__(type=type, name=f"{type} {more.get('of', '')}".strip(), mute=False, **more)
        self.inputs = [Socket(self, name) for name in into.split(",") if name]
        self.outputs = [Socket(self, name, kind) for name in out.split(",")]

    def __getitem__(self, name: str) -> Socket:
        return next(s for s in (*self.inputs, *self.outputs) if s.name == name)


def image(name: str, size: tuple[int, int] = (8, 8), **more: Any) -> SimpleNamespace:
    usual = {
        "library": None, "source": "FILE", "type": "IMAGE", "depth": 24, "is_float": False,
        "colorspace_settings": SimpleNamespace(is_data=name != "colour"),
    }  # fmt: skip
    return SimpleNamespace(name=name, size=size, **usual | more)


def texture(one: SimpleNamespace) -> Node:
    return Node("TEX_IMAGE", "Vector", "Color,Alpha", of=one.name, image=one)


def material(*nodes: Node) -> tuple[SimpleNamespace, Node]:
    sockets = "Base Color,Metallic,Roughness,Alpha,Normal,Coat Roughness,Coat Normal"
    shader = Node("BSDF_PRINCIPLED", sockets, "BSDF", "SHADER")
    output = Node("OUTPUT_MATERIAL", "Surface,Displacement", is_active_output=True)
    output.inputs[0].type = "SHADER"
    output["Surface"].link(shader["BSDF"])
    return SimpleNamespace(name="M", library=None, node_tree=SimpleNamespace(nodes=[output, shader, *nodes])), shader


def named(plugin: ModuleType, one: SimpleNamespace) -> dict[str, str]:
    return {m.plane: m.image.name + (f" {m.packed}" if m.packed else "") for m in plugin.materials.maps_of(one)}


def test_maps_are_found_through_what_lies_between(plugin: ModuleType) -> None:
    one, shader = material()
    bump, normal, reroute = Node("BUMP", "Height,Normal"), Node("NORMAL_MAP", "Strength,Color"), Node("REROUTE", "In")
    shader["Normal"].link(bump["Out"])
    bump["Height"].link(texture(image("heights"))["Color"])
    bump["Normal"].link(normal["Out"])
    normal["Color"].link(reroute["Out"])
    reroute["In"].link(texture(image("normals"))["Color"])
    coloured = texture(image("colour"))
    shader["Alpha"].link(coloured["Alpha"])
    shader["Base Color"].link(coloured["Color"])
    shader["Coat Roughness"].link(texture(image("coat"))["Color"])
    lookup = Node("TEX_NOISE", "Vector")
    shader["Metallic"].link(lookup["Out"])
    lookup["Vector"].link(texture(image("distortion"))["Color"])
    assert named(plugin, one) == {
        "albedo": "colour", "normal": "normals", "height": "heights", "coat_roughness": "coat",
    }  # fmt: skip
    assert next(iter(named(plugin, one))) == "albedo"


def test_the_colour_of_an_image_counts_before_its_alpha(plugin: ModuleType) -> None:
    one, shader = material()
    both = texture(image("both"))
    shader["Metallic"].link(both["Alpha"])
    shader["Roughness"].link(both["Color"])
    assert named(plugin, one) == {"roughness": "both"}


def test_normals_of_the_coat_are_no_second_normals(plugin: ModuleType) -> None:
    one, shader = material()
    for name in ("Coat Normal", "Normal"):
        between = Node("NORMAL_MAP", "Strength,Color", of=name)
        shader[name].link(between["Out"])
        between["Color"].link(texture(image(name))["Color"])
    assert named(plugin, one) == {"normal": "Normal", "coat_normal": "Coat Normal"}


def test_a_muted_image_does_not_count(plugin: ModuleType) -> None:
    one, shader = material()
    muted = texture(image("colour"))
    shader["Base Color"].link(muted["Color"])
    muted.mute = True
    with pytest.raises(plugin.materials.Trouble, match="No image feeds the Principled BSDF of M;"):
        plugin.materials.maps_of(one)


def test_channels_of_one_image_are_a_packed_map(plugin: ModuleType) -> None:
    one, shader = material()
    parts, mix = Node("SEPARATE_COLOR", "Color", "Red,Green,Blue"), Node("MIX", "Factor,A,B")
    parts["Color"].link(texture(image("orm"))["Color"])
    shader["Base Color"].link(mix["Out"])
    mix["A"].link(texture(image("colour"))["Color"])
    mix["B"].link(parts["Red"])
    shader["Roughness"].link(parts["Green"])
    shader["Metallic"].link(parts["Blue"])
    assert named(plugin, one) == {"albedo": "colour", "packed": "orm R=ao,B=metallic,G=roughness"}
    shader["Roughness"].links.clear()
    mix["Factor"].link(parts["Green"])
    assert named(plugin, one)["packed"] == "orm B=metallic", "no map is two channels"


def test_no_name_is_given_twice(plugin: ModuleType) -> None:
    one, shader = material()
    mix = Node("MIX", "A,B,C")
    shader["Base Color"].link(mix["Out"])
    for socket, name in zip("ABC", ("colour", "dirt", "shade"), strict=True):
        mix[socket].link(texture(image(name))["Color"])
    assert named(plugin, one) == {"albedo": "colour", "ao": "dirt", "ao_2": "shade"}


def test_images_within_groups_are_found_and_outer_ones_through_them(plugin: ModuleType) -> None:
    one, shader = material()
    inside, begin = texture(image("colour")), Node("GROUP_INPUT", "", "Rough")
    end = Node("GROUP_OUTPUT", "Colour,Roughness", is_active_output=True)
    end["Colour"].link(inside["Color"])
    end["Roughness"].link(begin["Rough"])
    group = Node("GROUP", "Rough", "Colour,Roughness", node_tree=SimpleNamespace(nodes=[end]))
    shader["Base Color"].link(group["Colour"])
    shader["Roughness"].link(group["Roughness"])
    group["Rough"].link(texture(image("roughness"))["Color"])
    maps = {m.plane: m.nodes for m in plugin.materials.maps_of(one)}
    assert maps == {"albedo": {("GROUP", "TEX_IMAGE colour")}, "roughness": {("TEX_IMAGE roughness",)}}


def test_sizes_are_equal_or_whole_multiples(plugin: ModuleType) -> None:
    check = plugin.materials._check_shapes
    check([image("a", (16, 8)), image("b", (32, 16)), image("c", (16, 8)), image("d", (8, 4))])
    for other in ((16, 16), (24, 12), (32, 8), (8, 8)):
        with pytest.raises(plugin.materials.Trouble, match=rf"^a is 16x8 px, b {other[0]}x{other[1]};"):
            check([image("a", (16, 8)), image("b", other)])


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"source": "SEQUENCE"}, "sequence"), ({"source": "MOVIE"}, "movie"), ({"source": "TILED"}, "UDIM"),
        ({"source": "VIEWER"}, "render"), ({"type": "MULTILAYER"}, "layers"), ({"size": (0, 0)}, "damaged"),
        ({"library": "other.blend"}, "linked"),
    ],
)  # fmt: skip
def test_images_that_are_no_single_picture_are_refused(plugin: ModuleType, more: dict[str, Any], said: str) -> None:
    plugin.pictures.check(image("moss"))
    with pytest.raises(plugin.pictures.Trouble, match=rf"^moss .*{said}.*\.$"):
        plugin.pictures.check(image("moss", **more))


def test_the_bytes_of_a_file_are_handed_on(plugin: ModuleType, tmp_path: Path) -> None:
    source = tmp_path / "Große Steine_normal.JPG"
    source.write_bytes(b"as it is")
    one = image(
        "stones", filepath=str(source), file_format="JPEG", packed_file=None, is_dirty=False, alpha_mode="NONE",
        colorspace_settings=SimpleNamespace(name="Non-Color", is_data=True),
    )  # fmt: skip
    stem = plugin.pictures.file_stem(one)
    given = plugin.pictures.write(one, tmp_path, stem)
    assert stem == "Große_Steine_normal", "the ending tells what the picture holds"
    assert given == ("stones", tmp_path / "Große_Steine_normal.jpg", "Non-Color", "NONE")
    assert given.file.read_bytes() == b"as it is"
    plugin.pictures._write_pixels = lambda *_: "the pixels"
    one.is_dirty = True
    assert plugin.pictures.write(one, tmp_path, stem) == "the pixels", "what was painted is not in the file"
    one.is_dirty = False
    one.packed_file = SimpleNamespace(data=b"packed")
    assert plugin.pictures.write(one, tmp_path, "a").file.read_bytes() == b"packed"


class Run:
    """Stands for a run of the program."""

    fraction, stopped = 0.5, 0

    def poll(self) -> bool:
        return False

    def words(self) -> str:
        return "Growing 50 %"

    def stop(self) -> None:
        self.stopped += 1


def watched(plugin: ModuleType, told: list[Any]) -> tuple[Any, SimpleNamespace]:
    operator = plugin.operators.GrowTexture()
    operator._call, operator._timer = Run(), "timer"
    operator._folder = SimpleNamespace(cleanup=lambda: told.append("cleaned"))
    operator.report = lambda kind, line: told.append(line)
    manager = SimpleNamespace(
        progress_update=told.append, progress_end=lambda: told.append("end"), event_timer_remove=told.append
    )
    workspace = SimpleNamespace(status_text_set=told.append)
    return operator, SimpleNamespace(window_manager=manager, workspace=workspace)


def test_escape_stops_a_run_and_all_else_passes(plugin: ModuleType) -> None:
    told: list[Any] = []
    operator, context = watched(plugin, told)
    plugin.running.Running.busy = operator._watched = True
    operator.poll_message_set = None
    assert operator.modal(context, SimpleNamespace(type="MOUSEMOVE")) == {"PASS_THROUGH"}
    assert operator.modal(context, SimpleNamespace(type="TIMER")) == {"PASS_THROUGH"}
    assert told == [50, "Growing 50 %    Esc: stop"]
    assert operator.modal(context, SimpleNamespace(type="ESC")) == {"CANCELLED"}
    assert told[2:] == ["timer", "end", "cleaned", "Stopped; nothing was changed"]
    assert operator._call.stopped == 1
    assert not plugin.running.Running.busy


def test_a_dialog_that_is_left_stops_no_run(plugin: ModuleType) -> None:
    told: list[Any] = []
    operator, context = watched(plugin, told)
    plugin.running.Running.busy = True
    operator.cancel(context)
    assert not told
    assert plugin.running.Running.busy
