"""ComfyUI's nodes make what the library makes, and say in one line, with the names of the node, what they cannot."""

from __future__ import annotations

import importlib
import json
import sys
import tomllib
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from plugins.comfyui_host import FOLDER, Comfy, ExecutionBlocker, InterruptProcessingException, comfyui, image, tensor

import intarsia as ia

MAPS = ["normal_map", "roughness_map", "metallic_map", "height_map", "ao_map"]
QUICK = {"width": 72, "height": 64, "method": "image-quilting"}
SAMPLE = ia.read("sample:stones").base.pixels
PART, OTHER = SAMPLE[:64, :64], SAMPLE[100:164, 80:144]
NORMAL = np.dstack([PART[:, :, :2] // 4 + 96, np.full((64, 64), 250, np.uint8)])
GRAY = np.ascontiguousarray(PART[:, :, 1])


@pytest.fixture
def comfy() -> Iterator[Comfy]:
    with comfyui() as found:
        yield found


def bits(made: Any, most: int = 255) -> Any:
    """An image of ComfyUI as whole numbers, which it holds exactly."""
    whole = np.rint(np.asarray(made) * most)
    assert np.abs(whole - np.asarray(made) * most).max() < 1e-2
    return whole.astype(np.uint16)


def mask(shape: tuple[int, int], *boxes: tuple[slice, slice]) -> Any:
    white = np.zeros((1, *shape), np.float32)
    for box in boxes:
        white[(0, *box)] = 1
    return tensor(white)


BOX, ALL = (slice(20, 34), slice(24, 44)), (slice(None), slice(None))


class TestSchema:
    def test_nodes_stand_in_one_place_with_the_names_of_the_documentation(self, comfy: Comfy) -> None:
        named = {name: comfy.schema(name).display_name for name in comfy.nodes}
        assert list(named.values()) == [
            "Grow Texture", "Make Tileable", "Heal Texture", "Score Texture", "Tile Preview",
        ]  # fmt: skip
        assert {comfy.schema(name).category for name in comfy.nodes} == {"image/texture"}

    def test_ids_are_unique_over_inputs_and_outputs_and_all_are_explained(self, comfy: Comfy) -> None:
        for name in comfy.nodes:
            sockets = [*comfy.schema(name).inputs, *comfy.schema(name).outputs]
            assert len({one.id for one in sockets}) == len(sockets)
            assert all(one.tooltip.endswith(".") for one in sockets)
            assert comfy.schema(name).description

    def test_maps_go_in_and_out_in_one_order(self, comfy: Comfy) -> None:
        for name in ("IntarsiaGrow", "IntarsiaTile", "IntarsiaHeal", "IntarsiaScore"):
            assert [i.id for i in comfy.schema(name).inputs if i.id.endswith("_map")] == MAPS
            outputs = [o.display_name for o in comfy.schema(name).outputs if o.kind == "IMAGE"]
            assert outputs == ["image", *MAPS]

    def test_the_seed_has_all_that_the_library_has_and_changes_by_itself(self, comfy: Comfy) -> None:
        seeds = [i for name in comfy.nodes for i in comfy.schema(name).inputs if i.id == "seed"]
        assert [(i.min, i.max, i.control_after_generate) for i in seeds] == [(0, 2**64 - 1, True)] * 3

    def test_registry_and_requirements_name_this_version(self) -> None:
        project = tomllib.loads((FOLDER / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        required = (FOLDER / "requirements.txt").read_text(encoding="utf-8").split()
        assert project["name"] == "intarsia-textures"
        assert project["version"] == ia.__version__
        assert project["dependencies"] == required == ["intarsia>=0.2.0"]


class TestGrow:
    def test_a_material_is_grown_together(self, comfy: Comfy) -> None:
        made = comfy.run(
            "IntarsiaGrow", image=image(PART), normal_map=image(NORMAL), roughness_map=image(GRAY), seed=3, **QUICK
        )
        gray = np.repeat(GRAY[:, :, None], 3, axis=2)
        wanted = ia.synthesize(
            {"albedo": PART, "normal": NORMAL, "roughness": gray}, (64, 72), "image-quilting", seed=3, wrap="both"
        )
        for name, plane in {"image": "albedo", "normal_map": "normal", "roughness_map": "roughness"}.items():
            assert made[name].shape == (1, 64, 72, 3)
            assert made[name].dtype == np.float32
            assert (bits(made[name])[0] == wanted.render(plane).pixels).all()

    def test_what_is_linked_to_a_map_that_is_not_there_is_not_run(self, comfy: Comfy) -> None:
        made = comfy.run("IntarsiaGrow", image=image(PART), height_map=image(GRAY), **QUICK)
        blocked = [name for name, value in made.items() if isinstance(value, ExecutionBlocker)]
        assert blocked == ["normal_map", "roughness_map", "metallic_map", "ao_map"]
        assert {made[name].message for name in blocked} == {None}

    def test_more_than_eight_bits_are_carried_as_sixteen(self, comfy: Comfy) -> None:
        deep = (PART.astype(np.uint16) * 257) ^ np.uint16(5)
        made = comfy.run("IntarsiaGrow", image=image(deep), tileable="no", **QUICK)
        wanted = ia.synthesize(deep, (64, 72), "image-quilting").render().pixels
        assert (bits(made["image"], 65535)[0] == wanted).all()

    def test_gray_comes_back_as_three_channels_and_a_fourth_stays(self, comfy: Comfy) -> None:
        gray = comfy.run("IntarsiaGrow", image=tensor(image(GRAY)[..., :1]), **QUICK)["image"]
        wanted = ia.synthesize(GRAY, (64, 72), "image-quilting", wrap="both").render().samples
        assert (bits(gray)[0] == wanted).all()
        assert gray.shape == (1, 64, 72, 3)
        four = np.dstack([PART, 255 - GRAY // 2])
        made = comfy.run("IntarsiaGrow", image=image(four), **QUICK)["image"]
        assert (bits(made)[0] == ia.synthesize(four, (64, 72), "image-quilting", wrap="both").render().pixels).all()

    def test_colours_beyond_the_range_are_held_at_its_ends(self, comfy: Comfy) -> None:
        bright = comfy.run("IntarsiaGrow", image=tensor(image(PART) * 2.7 - 0.9), **QUICK)["image"]
        assert bright.min() == 0
        assert bright.max() == 1

    def test_wrap_and_method_are_those_that_are_chosen(self, comfy: Comfy) -> None:
        for tileable, wrap in {"no": "none", "left-right": "x", "top-bottom": "y", "both": "both"}.items():
            made = comfy.run("IntarsiaGrow", image=image(PART), **QUICK | {"tileable": tileable})
            wanted = ia.synthesize(PART, (64, 72), "image-quilting", wrap=wrap)
            assert (bits(made["image"])[0] == wanted.render().pixels).all()
        made = comfy.run("IntarsiaGrow", image=image(PART), **QUICK | {"method": "auto"})
        assert (bits(made["image"])[0] == ia.synthesize(PART, (64, 72), wrap="both").render().pixels).all()

    def test_nothing_is_taken_from_where_the_mask_is_white(self, comfy: Comfy) -> None:
        logo = PART.copy()
        logo[BOX] = (255, 0, 255)
        made = comfy.run("IntarsiaGrow", image=image(logo), unusable=mask((64, 64), BOX), **QUICK)
        assert not (bits(made["image"]) == (255, 0, 255)).all(axis=3).any()
        usable = np.ones((64, 64), bool)
        usable[BOX] = False
        wanted = ia.synthesize(ia.Exemplar.of(logo, usable=usable), (64, 72), "image-quilting", wrap="both")
        assert (bits(made["image"])[0] == wanted.render().pixels).all()

    def test_a_black_mask_of_any_size_marks_nothing(self, comfy: Comfy) -> None:
        """Load Image makes one of 64 x 64 px of pictures without transparency."""
        made = comfy.run("IntarsiaGrow", image=image(PART[:60]), unusable=mask((64, 64)), **QUICK)
        assert (made["image"] == comfy.run("IntarsiaGrow", image=image(PART[:60]), **QUICK)["image"]).all()

    def test_a_batch_is_grown_image_by_image(self, comfy: Comfy) -> None:
        made = comfy.run("IntarsiaGrow", image=image(PART, OTHER), height_map=image(GRAY), seed=4, **QUICK)
        for place, one in enumerate((PART, OTHER)):
            alone = comfy.run("IntarsiaGrow", image=image(one), height_map=image(GRAY), seed=4, **QUICK)
            for name in ("image", "height_map"):
                assert (made[name][place] == alone[name][0]).all()

    def test_progress_rises_over_the_whole_batch_to_its_end(self, comfy: Comfy) -> None:
        comfy.run("IntarsiaGrow", image=image(PART, OTHER), **QUICK)
        values = [value for value, _ in comfy.host.bar]
        assert {total for _, total in comfy.host.bar} == {200}
        assert values == sorted(values)
        assert values[-1] == 200
        assert len({*values}) > 4


class TestTile:
    @pytest.mark.parametrize(("crop", "size"), [("no", (64, 64)), ("to whole periods", None)])
    def test_it_is_made_tileable_as_by_the_library(self, comfy: Comfy, crop: str, size: Any) -> None:
        made = comfy.run("IntarsiaTile", image=image(PART), normal_map=image(NORMAL), crop=crop, seed=2)
        wanted = ia.tile({"albedo": PART, "normal": NORMAL}, size=size, seed=2)
        assert (bits(made["image"])[0] == wanted.render().pixels).all()
        assert (bits(made["normal_map"])[0] == wanted.render("normal").pixels).all()

    def test_axes_and_band_are_those_that_are_chosen(self, comfy: Comfy) -> None:
        made = comfy.run("IntarsiaTile", image=image(PART), tileable="left-right", crop="no", band=16)["image"]
        assert (bits(made)[0] == ia.tile(PART, axes="x", band=16, size=(64, 64)).render().pixels).all()
        assert (bits(made)[0, :, 8:-8] == PART[:, 8:-8]).all()

    def test_remarks_come_out_as_text_a_line_for_each(self, comfy: Comfy) -> None:
        note = "image (64x64 px) was cut to 42x64 px, where its periods or courses close; crop = no keeps all."
        assert comfy.run("IntarsiaTile", image=image(PART))["remarks"] == note
        assert comfy.run("IntarsiaTile", image=image(PART), crop="no")["remarks"] == ""
        made = comfy.run("IntarsiaTile", image=image(PART, PART))["remarks"]
        assert made.splitlines() == [f"image {n} of 2: {note}" for n in (1, 2)]

    def test_images_that_are_cropped_to_other_sizes_do_not_fit_in_a_batch(self, comfy: Comfy) -> None:
        y, x = np.mgrid[:64, :64]
        first, second = (np.where((y % n < 2) | (x % n < 2), 40, 200 + x % n + y % n).astype(np.uint8) for n in (9, 11))
        with pytest.raises(ValueError, match=r"^the images of the batch .* px; set crop to no\.$"):
            comfy.run("IntarsiaTile", image=image(first, second))


class TestHeal:
    def test_white_is_filled_and_all_else_stays(self, comfy: Comfy) -> None:
        made = comfy.run("IntarsiaHeal", image=image(PART), height_map=image(GRAY), mask=mask((64, 64), BOX), seed=5,
                         grow_mask=3)  # fmt: skip
        hole = np.zeros((64, 64), bool)
        hole[BOX] = True
        wanted = ia.heal({"albedo": PART, "height": np.repeat(GRAY[:, :, None], 3, axis=2)}, hole, grow=3, seed=5)
        assert (bits(made["image"])[0] == wanted.render().pixels).all()
        assert (bits(made["height_map"])[0] == wanted.render("height").pixels).all()
        changed = (bits(made["image"])[0] != PART).any(axis=2)
        assert changed[17:20, 24:44].any()
        hole[17:37, 21:47] = True
        assert not changed[~hole].any()

    def test_less_than_half_white_is_no_hole_and_the_rim_is_found(self, comfy: Comfy) -> None:
        soft = mask((64, 64), BOX)
        soft[0, :10] = 0.49
        made = comfy.run("IntarsiaHeal", image=image(PART), mask=soft)
        hole = np.zeros((64, 64), bool)
        hole[BOX] = True
        assert (bits(made["image"])[0] == ia.heal(PART, hole).render().pixels).all()

    def test_an_image_of_a_batch_without_a_hole_is_left_as_it_is(self, comfy: Comfy) -> None:
        both = tensor(np.concatenate([mask((64, 64), BOX), mask((64, 64))]))
        made = comfy.run("IntarsiaHeal", image=image(PART), mask=both)["image"]
        assert (bits(made)[0] != PART).any()
        assert (bits(made)[1] == PART).all()
        assert comfy.host.bar[-1] == (200, 200)

    def test_a_mask_without_a_batch_is_one_mask(self, comfy: Comfy) -> None:
        flat = comfy.run("IntarsiaHeal", image=image(PART), mask=mask((64, 64), BOX)[0])
        assert (flat["image"] == comfy.run("IntarsiaHeal", image=image(PART), mask=mask((64, 64), BOX))["image"]).all()


class TestScore:
    def test_number_and_words_are_those_of_the_library(self, comfy: Comfy) -> None:
        found = comfy.run("IntarsiaScore", example=image(SAMPLE), image=image(SAMPLE[:160, :160]), tileable="no")
        wanted = ia.score(SAMPLE, SAMPLE[:160, :160], wrap="none")
        assert found["score"] == wanted.total
        assert found["verdict"] == f"{wanted.total:.0f} of 100, {wanted.verdict}"

    def test_good_ones_of_a_batch_pass_with_their_maps(self, comfy: Comfy) -> None:
        good, other = SAMPLE[:160, :160], SAMPLE[:160, :160].transpose(2, 0, 1).reshape(160, 160, 3)
        batch, both = image(other, good), image(255 - other, 255 - good)
        found = comfy.run(
            "IntarsiaScore", example=image(SAMPLE), image=batch, height_map=both, ao_map=image(other), tileable="no",
            least=60.0,
        )  # fmt: skip
        assert found["score"] < 60
        assert [line.split()[1:3] for line in found["verdict"].splitlines()] == [["of", "100,"]] * 2
        assert (found["image"] == batch[1:]).all()
        assert (found["height_map"] == both[1:]).all()
        assert (found["ao_map"] == image(other)).all()
        assert isinstance(found["normal_map"], ExecutionBlocker)

    def test_if_none_is_good_enough_nothing_that_follows_is_run(self, comfy: Comfy) -> None:
        given = {"example": image(SAMPLE), "image": image(OTHER), "height_map": image(GRAY)}
        found = comfy.run("IntarsiaScore", **given, least=100.0)
        assert all(isinstance(found[name], ExecutionBlocker) for name in ("image", *MAPS))
        assert found["score"] < 100

    def test_an_interrupt_ends_it_between_images(self, comfy: Comfy) -> None:
        comfy.host.interrupt_at = 1
        with pytest.raises(InterruptProcessingException):
            comfy.run("IntarsiaScore", example=image(SAMPLE), image=image(PART, OTHER))
        assert comfy.host.bar == [(1, 2)]


class TestPreview:
    def test_the_image_stands_side_by_side_and_is_shown(self, comfy: Comfy) -> None:
        made = comfy.run("IntarsiaTilePreview", image=image(PART, OTHER), times=2)["image"]
        assert made.shape == (2, 128, 128, 3)
        for place, one in enumerate((PART, OTHER)):
            assert (bits(made)[place] == np.tile(one, (2, 2, 1))).all()
        shown = comfy.nodes["IntarsiaTilePreview"].execute(image(PART), 3).ui
        assert shown.image.shape == (1, 192, 192, 3)
        assert comfy.schema("IntarsiaTilePreview").is_output_node

    def test_it_does_not_grow_beyond_what_comfyui_shows(self, comfy: Comfy) -> None:
        line = r"^8 times image is 24x16400 px, over 16384 a side; choose fewer times\.$"
        with pytest.raises(ValueError, match=line):
            comfy.run("IntarsiaTilePreview", image=tensor(np.zeros((1, 2050, 3, 3), np.float32)), times=8)


class TestInterrupt:
    @pytest.mark.parametrize("bar_throws", [False, True])
    def test_it_ends_the_work_at_the_next_step_and_leaves_nothing(self, comfy: Comfy, bar_throws: bool) -> None:
        comfy.host.bar_throws = bar_throws
        comfy.run("IntarsiaGrow", image=image(PART), **QUICK | {"width": 256, "height": 256})
        whole = len(comfy.host.bar)
        comfy.host.interrupt_at = 3
        with pytest.raises(InterruptProcessingException):
            comfy.run("IntarsiaGrow", image=image(PART), **QUICK | {"width": 256, "height": 256})
        assert len(comfy.host.bar) == 3 < whole
        assert not comfy.host.interrupted

    def test_nothing_begins_once_it_is_asked_for(self, comfy: Comfy) -> None:
        comfy.host.interrupted = True
        with pytest.raises(InterruptProcessingException):
            comfy.run("IntarsiaHeal", image=image(PART), mask=mask((64, 64), BOX))
        assert comfy.host.bar == []


BAD: list[tuple[str, dict[str, Any], str]] = [
    ("IntarsiaGrow", {"height_map": image(GRAY[:32, :48])},
     "height_map is 48x32 px, of another shape than image (64x64)"),
    ("IntarsiaGrow", {"ao_map": image(GRAY, GRAY), "image": image(PART, OTHER, PART)},
     "ao_map holds 2 images, image 3; link 1 or 3."),
    ("IntarsiaGrow", {"image": tensor(np.full((1, 64, 64, 3), np.nan, np.float32))},
     "image holds pixels that are no numbers (NaN); look at what the node before it makes."),
    ("IntarsiaGrow", {"normal_map": tensor(np.zeros((0, 64, 64, 3), np.float32))}, "normal_map holds no image; link"),
    ("IntarsiaGrow", {"unusable": mask((32, 64), BOX)}, "unusable is 64x32 px, image 64x64; make them equal."),
    ("IntarsiaGrow", {"unusable": mask((64, 64), ALL)}, "unusable leaves no pixel of image (64x64 px) to use"),
    ("IntarsiaGrow", {"method": "near-regular", "image": image(PART[:24, :24])}, "near-regular"),
    ("IntarsiaTile", {"image": image(PART[:8])}, "image is too small to be tiled (64x8 px); give 16 px a side."),
    ("IntarsiaTile", {"image": image(PART[:8], PART[:8])}, "image 1 of 2: image is too small to be tiled (64x8 px)"),
    ("IntarsiaTile", {"band": 60}, "band"),
    ("IntarsiaHeal", {"mask": mask((64, 64))}, "mask is all black; paint white what is to be healed."),
    ("IntarsiaHeal", {"mask": mask((64, 64), ALL)}, "covers all of image (64x64 px)"),
    ("IntarsiaHeal", {"mask": mask((64, 60), BOX)}, "mask is 60x64 px, image 64x64; make them equal."),
    ("IntarsiaScore", {"example": image(PART, OTHER), "image": image(PART, PART, PART)},
     "example holds 2 images, image 3; link 1 or 3."),
    ("IntarsiaScore", {"example": tensor(image(PART)[..., :2])}, "image has"),
]  # fmt: skip


@pytest.mark.parametrize(("node", "inputs", "line"), BAD)
def test_bad_input_ends_in_one_line_that_names_the_inputs(comfy: Comfy, node: str, inputs: Any, line: str) -> None:
    with pytest.raises(ValueError) as told:
        comfy.run(node, **{"image": image(PART)} | (QUICK if node == "IntarsiaGrow" else {}) | inputs)
    said = str(told.value)
    assert line in said
    assert "\n" not in said
    assert said.endswith(".")
    assert not {"albedo", "plane", "exemplar"} & {*said.replace("'", " ").split()}
    assert told.value.__suppress_context__ or told.value.__context__ is None


class TestLibrary:
    def test_it_is_the_one_that_these_nodes_come_with(self, comfy: Comfy) -> None:
        assert comfy.carrying.library() is ia
        assert importlib.import_module("intarsia.plugins").CONTRACT == comfy.carrying.CONTRACT

    @pytest.mark.parametrize(
        ("version", "contract", "line"),
        [
            ("", None, 'intarsia is missing in the Python of ComfyUI; run "{}" -m pip install'),
            ("0.1.9", None, 'intarsia 0.1.9 is too old for these nodes; run "{}" -m pip install'),
            ("0.10.0", None, "intarsia 0.10.0 and these nodes do not belong together; install the nodes that come"),
            ("0.3.0", 2, "intarsia 0.3.0 and these nodes do not belong together; install the nodes that come"),
        ],
    )
    def test_a_node_says_what_is_amiss(
        self, comfy: Comfy, monkeypatch: pytest.MonkeyPatch, version: str, contract: Any, line: str
    ) -> None:
        found = SimpleNamespace(__version__=version) if version else None  # None: as if it was not installed
        monkeypatch.setitem(sys.modules, "intarsia", found)  # type: ignore[arg-type]
        plugins = SimpleNamespace(CONTRACT=contract) if contract else None
        monkeypatch.setitem(sys.modules, "intarsia.plugins", plugins)  # type: ignore[arg-type]
        for node, more in {"IntarsiaGrow": {}, "IntarsiaScore": {"example": image(PART)}}.items():
            with pytest.raises(RuntimeError) as told:
                comfy.run(node, image=image(PART), **more)
            assert str(told.value).startswith(line.format(sys.executable))
            assert "\n" not in str(told.value)


WORKFLOWS = sorted((FOLDER / "example_workflows").glob("*.json"))
THEIRS = {  # ComfyUI's own nodes that the workflows use: types in, types out
    "LoadImage": ([], ["IMAGE", "MASK"]), "SaveImage": (["IMAGE"], []), "PreviewAny": (["*"], []),
    "MarkdownNote": ([], []), "CheckpointLoaderSimple": ([], ["MODEL", "CLIP", "VAE"]),
    "CLIPTextEncode": (["CLIP"], ["CONDITIONING"]), "EmptyLatentImage": ([], ["LATENT"]),
    "KSampler": (["MODEL", "CONDITIONING", "CONDITIONING", "LATENT"], ["LATENT"]),
    "VAEDecode": (["LATENT", "VAE"], ["IMAGE"]),
}  # fmt: skip


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
class TestWorkflows:
    def test_nodes_have_the_sockets_and_values_of_their_schemas(self, comfy: Comfy, path: Any) -> None:
        for node in json.loads(path.read_text(encoding="utf-8"))["nodes"]:
            if node["type"] in THEIRS:
                kinds = [one["type"] for one in node["inputs"]], [one["type"] for one in node["outputs"]]
                assert kinds == THEIRS[node["type"]]
                continue
            schema = comfy.schema(node["type"])
            sockets = [i for i in schema.inputs if i.kind in ("IMAGE", "MASK")]
            assert [(i["name"], i["type"]) for i in node["inputs"]] == [(i.id, i.kind) for i in sockets]
            wanted = [(o.display_name, o.kind) for o in schema.outputs]
            assert [(o["name"], o["type"]) for o in node["outputs"]] == wanted
            values = iter(node["widgets_values"])
            for one in (i for i in schema.inputs if i not in sockets):
                value = next(values)
                assert value in one.options if one.kind == "COMBO" else one.min <= value <= one.max
                if getattr(one, "control_after_generate", None):
                    assert next(values) in ("fixed", "increment", "decrement", "randomize")
            assert next(values, None) is None
            linked = {i["name"] for i in node["inputs"] if i["link"] is not None}
            assert {i.id for i in sockets if not i.optional} <= linked

    def test_links_join_sockets_of_one_type_and_no_map_that_is_not_there(self, comfy: Comfy, path: Any) -> None:
        flow = json.loads(path.read_text(encoding="utf-8"))
        nodes = {node["id"]: node for node in flow["nodes"]}
        assert len(nodes) == len(flow["nodes"])
        for link, source, out, target, into, kind in flow["links"]:
            start, end = nodes[source]["outputs"][out], nodes[target]["inputs"][into]
            assert link in start["links"]
            assert link == end["link"]
            assert start["type"] == kind
            assert end["type"] in (kind, "*")
            if start["name"] in MAPS:
                assert {i["name"]: i["link"] for i in nodes[source]["inputs"]}[start["name"]] is not None
        ends = [i["link"] for node in flow["nodes"] for i in node["inputs"] if i["link"] is not None]
        assert sorted(ends) == sorted(link[0] for link in flow["links"])
        assert max(ends) == flow["last_link_id"]
        assert max(nodes) == flow["last_node_id"]


def test_there_are_workflows() -> None:
    assert "any-model-to-tileable-material" in {path.stem for path in WORKFLOWS}
