"""The images of a material: found from the output of its nodes backwards, and exchanged in a copy of it."""

import re
from collections import Counter
from contextlib import suppress
from typing import NamedTuple

from .calling import Trouble
from .pictures import called, check, has_alpha

PLANES = {
    "Base Color": "albedo", "Color": "albedo", "Emission Color": "emission", "Emission": "emission",
    "Alpha": "opacity", "Displacement": "height", "Specular IOR Level": "specular", "Specular": "specular",
}  # fmt: skip
"""Sockets of shaders -> what the program calls a map that feeds them; others are called like the socket."""

CHANNELS = {"Red": "R", "Green": "G", "Blue": "B", "R": "R", "G": "G", "B": "B"}
ORDER = ("albedo", "normal", "height", "roughness", "metallic")
SCALARS = ("ao", "roughness", "metallic", "height", "opacity", "specular")
"""Maps of one channel, which the channels of a packed map can hold."""
TOLD = (*ORDER, *SCALARS, "emission")
"""Maps that the program knows by the name of a file."""


class Found(NamedTuple):
    """An image of a material: the names of its nodes, those of the groups around them first; channel -> map."""

    image: object
    nodes: set
    feeds: dict


class Map(NamedTuple):
    """An image as a map of a material; `packed` is what its channels hold, in the words of the program."""

    plane: str
    image: object
    nodes: frozenset
    packed: str


def maps_of(material):
    """Return the maps of a material, the one that the others go along with first; Trouble if there is none."""
    if material.library is not None:
        raise Trouble(f"{material.name} is linked from another file; make it local first, in the Outliner.")
    found, seen = {}, set()
    for node in material.node_tree.nodes if material.node_tree else ():
        if node.type == "OUTPUT_MATERIAL" and node.is_active_output:
            for socket in node.inputs:
                _follow(socket, PLANES.get(socket.name, ""), "", (), found, seen)
    if not found:
        raise Trouble(f"No image feeds the Principled BSDF of {material.name}; add one, or choose another material.")
    for one in found.values():
        check(one.image)
    maps = _named(list(found.values()))
    _check_shapes([one.image for one in maps])
    return maps


def _follow(socket, plane, channel, groups, found, seen):
    """Collect the images that feed a socket. `channel` of them is looked at; `groups` are the nodes around."""
    place = (tuple(g.name for g in groups), socket.node.name, socket.identifier, plane, channel)
    if place in seen:
        return
    seen.add(place)
    for link in socket.links:
        node, start = link.from_node, link.from_socket
        if node.type == "TEX_IMAGE":
            if node.image is not None and not node.mute:
                one = found.setdefault(node.image.name, Found(node.image, set(), {}))
                one.nodes.add((*place[0], node.name))
                one.feeds.setdefault("A" if start.name == "Alpha" else channel, plane)
        elif node.type == "GROUP" and node.node_tree is not None:
            for end in node.node_tree.nodes:
                if end.type == "GROUP_OUTPUT" and end.is_active_output:
                    _follow_same(end.inputs, start, plane, channel, (*groups, node), found, seen)
        elif node.type == "GROUP_INPUT" and groups:
            _follow_same(groups[-1].inputs, start, plane, channel, groups[:-1], found, seen)
        elif not node.type.startswith("TEX_"):  # what goes into a texture says where it is looked up
            part = CHANNELS.get(start.name, channel) if node.type in ("SEPARATE_COLOR", "SEPRGB") else channel
            for into in node.inputs:
                _follow(into, _plane(node, into, plane), part, groups, found, seen)


def _follow_same(sockets, like, *others):
    for socket in sockets:
        if socket.identifier == like.identifier:
            _follow(socket, *others)


def _plane(node, socket, plane):
    """Return what a map holds that feeds this socket of a node, where the node's output holds `plane`."""
    if socket.type == "SHADER":
        return ""
    if any(out.type == "SHADER" for out in node.outputs):
        return PLANES.get(socket.name) or re.sub(r"\W+", "_", socket.name).strip("_").lower()
    if node.type in ("BUMP", "DISPLACEMENT") and socket.name == "Height":
        return "height"
    return "normal" if node.type == "NORMAL_MAP" and "normal" not in plane else plane


def _named(found):
    """Give each image the name of a map, no name twice. The first whose channels hold several maps is packed."""
    maps, taken = [], set()
    for one in found:
        parts = _packing(one)
        if parts and not taken and len(found) > 1:
            taken = {"packed", *parts.values()}
            maps.append(Map("packed", one.image, frozenset(one.nodes), ",".join(f"{c}={p}" for c, p in parts.items())))
    for one in found:
        if all(one.image != other.image for other in maps):
            first = one.feeds.get("") or next(iter(one.feeds.values())) or "map"
            plane = _free(_scalar(first) if one.image.colorspace_settings.is_data else first, taken)
            maps.append(Map(plane, one.image, frozenset(one.nodes), ""))
    rank = {plane: number for number, plane in enumerate(ORDER)}
    return sorted(maps, key=lambda m: (m.plane == "packed", rank.get(m.plane, len(ORDER)), m.plane))


def _packing(one):
    """Return what the channels of an image hold, if they are used one by one: channel -> map."""
    if "" in one.feeds:
        return {}
    parts = {c: _scalar(p) for c, p in one.feeds.items() if c != "A" or has_alpha(one.image)}
    counted = Counter(parts.values())
    parts = {c: p for c, p in parts.items() if p in SCALARS and counted[p] == 1}
    return parts if parts.keys() - {"A"} else {}


def _scalar(plane):
    """Return the map that data holds where a colour is fed: occlusion, which is multiplied with the colour."""
    return "ao" if plane == "albedo" else plane


def _free(plane, taken):
    number, name = 1, plane
    while name in taken or name in ("mask", "orm", "arm", "rma"):
        number += 1
        name = f"{plane}_{number}"
    taken.add(name)
    return name


def _check_shapes(images):
    """Raise Trouble if the maps of one material do not lie on each other, one pixel on one or on a block of them."""
    first = images[0]
    for other in images[1:]:
        (w, h), (width, height) = sorted((tuple(first.size), tuple(other.size)))
        if width * h != height * w or width % w:
            raise Trouble(
                f"{called(first.name)} is {first.size[0]}x{first.size[1]} px, {called(other.name)} {other.size[0]}x"
                f"{other.size[1]}; the maps of a material need one size, or whole multiples of it."
            )


def copied(material, ending, images):
    """Return a copy of a material that shows other images: `images` are pairs of names of nodes and an image.

    Groups that hold such nodes are copied, too, as other materials may use them.
    """
    new = material.copy()
    new.name = f"{material.name}_{ending}"
    own = set()
    for nodes, image in images:
        for names in sorted(nodes):
            tree = new.node_tree
            for depth, name in enumerate(names[:-1], 1):
                group = tree.nodes[name]
                if names[:depth] not in own:
                    own.add(names[:depth])
                    group.node_tree = group.node_tree.copy()
                tree = group.node_tree
            tree.nodes[names[-1]].image = image
    return new


def give(new, old, thing):
    """Give a material to an object in place of another; one that nobody has then is saved all the same."""
    with suppress(AttributeError, RuntimeError):  # of linked data
        for slot in thing.material_slots if thing is not None else ():
            if slot.material == old:
                slot.material = new
    for one in (new, old):
        if one.users == 0:
            one.use_fake_user = True
