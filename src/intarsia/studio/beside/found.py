"""In the process beside: what was found in an exemplar, as JSON and as overlays; and exemplars edited."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import files
from ...analysis.light import flattened
from ...canvas import Canvas
from ...choosing.facts import Facts
from ...cli.exemplars import cropped
from ...cli.outputs import usual_ending
from ...courses.rectify import straight_of
from ...covering.exchange import striking
from ...errors import InputError
from ...exemplar import Exemplar
from ...geometry import Wrap
from ...image import Kind, Plane
from ...segments.things import things
from ...segments.wholes import wholes
from ...tasks.completion import healed_scene
from ...tasks.drawings import CHOSEN, GROUPS, borders, on_paper
from ...tasks.inspection import Findings, analyze
from .looking import exemplar_of
from .pictures import Pixels, png
from .worker import Answer, Tell

KINDS = ("lattice", "courses", "elements", "striking", "segments")
LINE, JOINT, RED = (255, 225, 0, 255), (0, 225, 255, 255), (255, 60, 40, 255)
LABELS = 6  # that the page paints with
FILL = 70  # of 255: how much of a tint is seen

_held: dict[tuple[str, ...], Findings] = {}


def find(said: dict[str, Any], tell: Tell) -> Answer:
    """Look at an exemplar: what `intarsia analyze --json` tells, and which overlays there are."""
    found = _findings(said["paths"])
    exemplar, answer = found.exemplar, found.as_dict()
    elements, seen = wholes(exemplar), things(exemplar)
    strikes = 0 if elements is None else int((striking(exemplar) > 0).sum())
    masonry = _facts(exemplar).masonry
    there = {
        "lattice": found.lattice is not None, "courses": _facts(exemplar).courses is not None,
        "elements": elements is not None, "striking": bool(len(seen.areas) or strikes),
        "segments": len(found.segments.groups) > 0,
    }  # fmt: skip
    more = {
        "overlays": [kind for kind in KINDS if there[kind]],
        "courses": None if masonry is None else masonry.told,
        "striking": {"things": len(seen.areas), "elements": strikes},
        "stones": 0 if elements is None else len(elements.sure) - 1,
    }
    return answer | more, b""


def overlay(said: dict[str, Any], tell: Tell) -> Answer:
    """Draw what was found, on a clear ground: PNG of the exemplar's size; `labels` are numbers, of one channel."""
    found = _findings(said["paths"])
    drawn = {
        "lattice": _lattice, "courses": _courses, "elements": _elements, "striking": _striking, "segments": _segments,
        "labels": _labels,
    }[said["kind"]](found)  # fmt: skip
    if drawn is None:
        raise InputError(f"nothing of this kind was found: {said['kind']}.")
    return {}, png(drawn)


def rim(said: dict[str, Any], tell: Tell) -> Answer:
    """See by how many px `heal --grow auto` would enlarge a hole, and draw what of the picture that is: PNG."""
    exemplar = exemplar_of(said["paths"])
    hole = files.read_mask(said["mask"], exemplar.base, exemplar.name)
    scene = healed_scene(exemplar, hole, (), Wrap.NONE, None)
    assert scene.canvas.start is not None
    drawn = _clear(exemplar)
    drawn[scene.canvas.start.holes & ~hole] = LINE
    return {"grow": scene.recipe["heal"]["grow"]}, png(drawn)


def edit(said: dict[str, Any], tell: Tell) -> Answer:
    """Cut, straighten and flatten an exemplar; write it into a folder and tell the names of its files."""
    exemplar, done = exemplar_of(said["paths"]), []
    if said["crop"] is not None:
        exemplar, done = cropped(exemplar, tuple(said["crop"])), ["cropped"]
    if said["straighten"]:
        straight = straight_of(exemplar)
        if straight is None:
            raise InputError("its courses are straight already, or it has none.")
        exemplar, done = straight.exemplar, [*done, "straight"]
    if said["flatten"]:
        exemplar, done = flattened(exemplar), [*done, "flat"]
    planes = dict(exemplar.planes)
    if exemplar.usable is not None and not exemplar.usable.all():
        planes["mask"] = Plane(exemplar.usable.astype(np.uint8) * np.uint8(255), Kind.LABEL)
    stem, names = "_".join([said["stem"], *done]), []
    for name, plane in planes.items():
        own = stem if len(planes) == 1 else f"{stem}_{name}"
        names.append(own + usual_ending("x.png", plane, 1, None))
        files.write(os.path.join(said["folder"], names[-1]), plane)
    return {"names": names}, b""


def _findings(paths: list[str]) -> Findings:
    key = tuple(paths)
    if key not in _held:
        while len(_held) > 3:
            _held.pop(next(iter(_held)))
        _held[key] = analyze(exemplar_of(paths))
    return _held[key]


def _facts(exemplar: Exemplar) -> Facts:
    return exemplar.memo("studio", lambda: Facts([exemplar], Canvas(2 * exemplar.height, 2 * exemplar.width)))


def _clear(exemplar: Exemplar) -> Pixels:
    return np.zeros((exemplar.height, exemplar.width, 4), np.uint8)


def _lattice(found: Findings) -> Pixels | None:
    """The lines of the lattice, taken out of the picture that has them over the exemplar."""
    if found.lattice is None:
        return None
    out, drawn = _clear(found.exemplar), found.overlay("lattice").pixels
    out[..., :3] = drawn
    out[..., 3] = np.where((drawn != on_paper(found.exemplar.base)).any(axis=2), 255, 0)
    return out


def _courses(found: Findings) -> Pixels | None:
    """The lines between courses, and the joints of stones where they are clear."""
    facts = _facts(found.exemplar)
    lines, masonry = facts.courses, facts.masonry
    if lines is None:
        return None
    upright = lines.axis == 1
    out = _clear(found.exemplar)
    drawn = out.swapaxes(0, 1) if upright else out
    if masonry is not None and masonry.upright == upright:
        _draw_joints(drawn, masonry.work)
        _draw_lines(drawn, masonry.work.beds)
    else:
        _draw_lines(drawn, lines.at)
    return out


def _draw_lines(out: NDArray[Any], rows: NDArray[Any]) -> None:
    """Draw lines two px thick; `rows`: of every line the row in every column."""
    columns = np.arange(out.shape[1])
    for line in np.asarray(rows, np.int64):
        for off in (0, 1):
            inside = (line + off >= 0) & (line + off < out.shape[0])
            out[line[inside] + off, columns[inside]] = LINE


def _draw_joints(out: NDArray[Any], work: Any) -> None:
    for k, joints in work.of_course.items():
        for joint in joints:
            columns = np.clip(work.joints[joint], 0, out.shape[1] - 1)
            rows = np.arange(len(columns))
            inside = (rows >= work.beds[k][columns]) & (rows < work.beds[k + 1][columns])
            out[rows[inside], columns[inside]] = JOINT


def _elements(found: Findings) -> Pixels | None:
    elements = wholes(found.exemplar)
    if elements is None:
        return None
    out = _clear(found.exemplar)
    out[elements.labels > 0] = (*JOINT[:3], FILL // 2)
    out[borders(elements.labels)] = LINE
    return out


def _striking(found: Findings) -> Pixels | None:
    exemplar = found.exemplar
    seen, elements = things(exemplar), wholes(exemplar)
    labels = seen.labels
    if elements is not None and (strong := striking(exemplar) > 0).any():
        labels = np.where(np.concatenate([[False], strong])[elements.labels], elements.labels, 0)
    if not labels.any():
        return None
    out = _clear(exemplar)
    out[labels > 0] = (*RED[:3], FILL)
    edge = borders(labels)
    out[edge] = RED
    return out


def _segments(found: Findings) -> Pixels | None:
    """Each group in its tint, the one that was chosen in orange, with their borders."""
    segments = found.segments
    if not len(segments.groups):
        return None
    group, out = segments.group_map, _clear(found.exemplar)
    for number in range(int(group.max(initial=0)) + 1):
        tint = CHOSEN if number == segments.chosen else GROUPS[number % len(GROUPS)]
        out[group == number] = (*tint, FILL + 60 * (number == segments.chosen))
    out[borders(segments.labels)] = (20, 20, 20, 255)
    return out


def _labels(found: Findings) -> Pixels | None:
    """Labels to paint with, proposed from the groups of segments: 0 the largest, then those up to LABELS; (H, W, 1)."""
    if not len(found.segments.groups):
        return None
    group = found.segments.group_map
    areas = np.bincount(group[group >= 0])
    number = np.zeros(len(areas) + 1, np.uint8)  # the last: what does not count
    number[np.argsort(-areas, kind="stable")[:LABELS]] = np.arange(min(LABELS, len(areas)))
    return number[group][:, :, None]
