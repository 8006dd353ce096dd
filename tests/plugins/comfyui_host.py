"""Stand-ins for ComfyUI and torch: only what the nodes use, with the names and arguments of its V3 interface.

Compared with ComfyUI 0.38 (comfy_api/latest/_io.py, execution.py, comfy/utils.py, comfy_execution/graph_utils.py). A
tensor is an array that also answers `cpu`. An argument that ComfyUI does not have is a TypeError here, too.
"""

from __future__ import annotations

import asyncio
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import intarsia

FOLDER = Path(intarsia.__file__).parent / "plugins" / "hosts" / "comfyui" / "intarsia-textures"


class Tensor(np.ndarray[Any, Any]):
    """A tensor as the nodes see one."""

    def cpu(self) -> Tensor:
        return self


def tensor(array: Any) -> Tensor:
    return np.ascontiguousarray(array).view(Tensor)


def image(*pictures: Any) -> Tensor:
    """A batch as Load Image makes it: float32 of stored colour, three channels."""
    made = []
    for picture in pictures:
        floats = np.asarray(picture).astype(np.float32) / np.iinfo(np.asarray(picture).dtype).max
        made.append(floats if floats.ndim == 3 else floats[:, :, None].repeat(3, axis=2))
    return tensor(np.stack(made))


@dataclass
class Input:
    id: str
    display_name: str | None = None
    optional: bool = False
    tooltip: str | None = None


@dataclass
class Number(Input):
    default: Any = None
    min: Any = None
    max: Any = None
    step: Any = None


@dataclass
class Int(Number):
    control_after_generate: bool | None = None


@dataclass
class Combo(Input):
    options: Any = None
    default: Any = None

    def __init__(self, id: str, options: Any = None, display_name: str | None = None, optional: bool = False,
                 tooltip: str | None = None, default: Any = None) -> None:  # fmt: skip
        super().__init__(id, display_name, optional, tooltip)
        self.options, self.default = options, default


class Output:
    def __init__(self, id: str | None = None, display_name: str | None = None, tooltip: str | None = None) -> None:
        self.id, self.display_name, self.tooltip = id, display_name or id, tooltip


@dataclass
class Schema:
    node_id: str
    display_name: str | None = None
    category: str = "sd"
    inputs: list[Any] = field(default_factory=list)
    outputs: list[Any] = field(default_factory=list)
    description: str = ""
    is_output_node: bool = False


def kind(name: str, base: type = Input) -> SimpleNamespace:
    """A type of sockets: its class of inputs and of outputs, which know the type."""
    return SimpleNamespace(Input=type(name, (base,), {"kind": name}), Output=type(name, (Output,), {"kind": name}))


class NodeOutput:
    def __init__(self, *args: Any, ui: Any = None, expand: Any = None, block_execution: str | None = None) -> None:
        self.args, self.ui = args, ui


class ExecutionBlocker:
    def __init__(self, message: str | None) -> None:
        self.message = message


class InterruptProcessingException(BaseException):
    pass


class Host:
    """What ComfyUI knows while a node runs: the interrupt, which a test may set, and what the bar was told."""

    def __init__(self) -> None:
        self.interrupted = False
        self.interrupt_at = float("inf")
        self.bar_throws = False  # as where the page hears of progress: ComfyUI looks for interrupts there, too
        self.bar: list[tuple[int, int]] = []

    def processing_interrupted(self) -> bool:
        return self.interrupted

    def throw_exception_if_processing_interrupted(self) -> None:
        if self.interrupted:
            self.interrupted = False
            raise InterruptProcessingException

    def progress(self, total: int, node_id: Any = None) -> SimpleNamespace:
        def update_absolute(value: int, total: int = total, preview: Any = None) -> None:
            self.bar.append((value, total))
            self.interrupted |= len(self.bar) >= self.interrupt_at
            if self.bar_throws:
                self.throw_exception_if_processing_interrupted()

        return SimpleNamespace(update_absolute=update_absolute)

    @property
    def modules(self) -> dict[str, Any]:
        """Modules by name, and what is in them."""
        socket = SimpleNamespace(
            ComfyNode=type("ComfyNode", (), {}), Schema=Schema, NodeOutput=NodeOutput, Image=kind("IMAGE"),
            Mask=kind("MASK"), Int=kind("INT", Int), Float=kind("FLOAT", Number), String=kind("STRING"),
            Combo=kind("COMBO", Combo),
        )  # fmt: skip
        preview = lambda image, animated=False, cls=None: SimpleNamespace(image=image, cls=cls)  # noqa: E731
        return {
            "torch": {"from_numpy": tensor},
            "comfy": {},
            "comfy.model_management": {
                "processing_interrupted": self.processing_interrupted,
                "throw_exception_if_processing_interrupted": self.throw_exception_if_processing_interrupted,
            },
            "comfy.utils": {"ProgressBar": self.progress},
            "comfy_execution": {},
            "comfy_execution.graph_utils": {"ExecutionBlocker": ExecutionBlocker},
            "comfy_api": {},
            "comfy_api.latest": {
                "io": socket, "ui": SimpleNamespace(PreviewImage=preview),
                "ComfyExtension": type("ComfyExtension", (), {}),
            },
        }  # fmt: skip


class Comfy:
    """ComfyUI with the nodes in it: runs them as its executor does, with the names that a workflow has."""

    def __init__(self, host: Host, package: ModuleType) -> None:
        self.host, self.package = host, package
        extension = asyncio.run(package.comfy_entrypoint())
        self.nodes = {node.define_schema().node_id: node for node in asyncio.run(extension.get_node_list())}
        self.carrying: Any = sys.modules[f"{package.__name__}.carrying"]

    def schema(self, name: str) -> Schema:
        return self.nodes[name].define_schema()

    def run(self, name: str, **inputs: Any) -> dict[str, Any]:
        """Run a node with what is linked and set, and defaults elsewhere; return its outputs by their shown names."""
        schema, given = self.schema(name), dict(inputs)
        for one in schema.inputs:
            if one.id not in given and not one.optional:
                assert one.default is not None, f"{one.id} of {name} is not linked"
                given[one.id] = one.default
        assert given.keys() <= {one.id for one in schema.inputs}
        self.host.bar.clear()
        out = self.nodes[name].execute(**given)
        assert len(out.args) == len(schema.outputs)
        return {o.display_name: value for o, value in zip(schema.outputs, out.args, strict=True)}


@contextmanager
def comfyui() -> Iterator[Comfy]:
    """The nodes, imported as ComfyUI does, under a name that is no word of Python."""
    host, name = Host(), "custom_nodes_intarsia-textures"
    with pytest.MonkeyPatch.context() as patch:
        for module, content in host.modules.items():
            made = ModuleType(module)
            made.__dict__.update(content)
            patch.setitem(sys.modules, module, made)
        spec = importlib.util.spec_from_file_location(
            name, FOLDER / "__init__.py", submodule_search_locations=[str(FOLDER)]
        )
        assert spec is not None
        assert spec.loader is not None
        package = importlib.util.module_from_spec(spec)
        for module in (name, f"{name}.nodes", f"{name}.carrying"):
            patch.setitem(sys.modules, module, package)  # so that it is put back
            del sys.modules[module]
        sys.modules[name] = package
        spec.loader.exec_module(package)
        yield Comfy(host, package)
