"""Plug-ins for other programs: what is copied into their folders, where that is, and how they find this program.

A plug-in is small and calls the command line (docs/callers.md); that of ComfyUI imports the library. They lie in
``hosts``, are run by other programs, and import nothing of this package but :mod:`.hosts.calling`, which is copied.
Imports nothing heavy.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from ..disk import reason_of
from ..foundation import ParameterError, ResourceError, printable
from ..version import VERSION

CONTRACT = 1
"""Counts up whenever a caller of before could misread what the command line tells, or be misread."""

HOSTS = Path(__file__).parent / "hosts"
CALLING = "calling.py"
TOLD = "installed.json"
"""What lies in the folder of an installed plug-in: version, contract, and the command that installed it."""


@dataclass(frozen=True)
class Host:
    """A program that takes plug-ins.

    `homes` are folders of its settings as glob patterns below a user's folders; `below` is the folder of plug-ins
    in each; `name` that of ours; `beside` are files that lie beside it; `then` says what a person does next.
    """

    title: str
    name: str
    homes: tuple[str, ...]
    below: str
    then: str
    beside: tuple[str, ...] = ()


KNOWN = {
    "blender": Host(
        "Blender 4.2 or newer", "intarsia_textures",
        (
            "~/.config/blender/[45].*", "~/.var/app/org.blender.Blender/config/blender/[45].*",
            "~/Library/Application Support/Blender/[45].*", "$APPDATA/Blender Foundation/Blender/[45].*",
        ),
        "extensions/user_default",
        "switch on Intarsia Textures in Edit > Preferences > Add-ons",
    ),
    "gimp": Host(
        "GIMP 3", "intarsia-textures",
        (
            "~/.config/GIMP/3.*", "~/.var/app/org.gimp.GIMP/config/GIMP/3.*",
            "~/Library/Application Support/GIMP/3.*", "$APPDATA/GIMP/3.*",
        ),
        "plug-ins",
        "start GIMP again; the plug-in is in Filters > Enhance, Render and Map, and in Edit",
    ),
    "krita": Host(
        "Krita 5", "intarsia_textures",
        (
            "~/.local/share/krita", "~/.var/app/org.kde.krita/data/krita", "~/Library/Application Support/krita",
            "$APPDATA/krita",
        ),
        "pykrita",
        "switch on Intarsia Textures in Settings > Configure Krita > Python Plugin Manager, and start Krita again",
        ("intarsia_textures.desktop",),
    ),
    "comfyui": Host(
        "ComfyUI", "intarsia-textures", (), "custom_nodes", "start ComfyUI again; the nodes are in image > texture",
    ),
}  # fmt: skip


def own_command() -> list[str]:
    """Return the words that start this program's command line, whatever the working folder is."""
    script = Path(sys.executable).with_name("intarsia.exe" if os.name == "nt" else "intarsia")
    return [str(script)] if script.is_file() else [sys.executable, "-P", "-m", "intarsia"]


def folders_of(name: str, to: str | None = None) -> list[Path]:
    """Return the folders of plug-ins of a host: of every version that this user has started, or `to` alone.

    ParameterError if there is none.
    """
    host = KNOWN[name]
    if to is not None:
        if not Path(to).is_dir():
            raise ParameterError(f"{printable(to)} is no folder; name the one that holds the plug-ins of {host.title}.")
        return [Path(to)]
    found = [home / host.below for home in _homes(host.homes)]
    if not found:
        where = " or ".join(host.homes[:1]) or "its folder"
        raise ParameterError(
            f"{host.title} has no folder of settings here ({where}); start it once, or name its {host.below} with --to."
        )
    return found


def _homes(patterns: Iterable[str]) -> Iterator[Path]:
    for pattern in patterns:
        root, *parts = os.path.expandvars(os.path.expanduser(pattern)).replace("\\", "/").split("/")
        if not root.startswith("$"):
            place = Path(f"{root}/")
            yield from sorted(p for p in place.glob("/".join(parts)) if p.is_dir())


def install(name: str, to: str | None = None) -> list[Path]:
    """Copy the plug-in of a host into its folders, in place of an older one; return where it is now."""
    host, source = KNOWN[name], HOSTS / name
    placed = []
    for folder in folders_of(name, to):
        place, fresh = folder / host.name, folder / f".{host.name}.new"
        _check_ours(place)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            shutil.rmtree(fresh, ignore_errors=True)
            shutil.copytree(source / host.name, fresh, ignore=shutil.ignore_patterns("__pycache__"))
            shutil.copy(HOSTS / CALLING, fresh / CALLING)
            if (script := fresh / f"{host.name}.py").is_file():
                script.chmod(0o755)  # GIMP starts it; not every installer of packages keeps that bit
            told = {"version": VERSION, "contract": CONTRACT, "command": own_command()}
            (fresh / TOLD).write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
            for other in host.beside:
                shutil.copy(source / other, folder / other)
            shutil.rmtree(place, ignore_errors=True)
            fresh.rename(place)
        except OSError as e:
            shutil.rmtree(fresh, ignore_errors=True)
            said = f"{printable(place)} cannot be written ({reason_of(e)}); name another with --to."
            raise ResourceError(said) from None
        placed.append(place)
    return placed


def remove(name: str, to: str | None = None) -> list[Path]:
    """Remove the plug-in from the folders of a host; return where it was. What is not ours stays."""
    host, gone = KNOWN[name], []
    for folder in folders_of(name, to):
        place = folder / host.name
        if not place.exists():
            continue
        _check_ours(place)
        try:
            shutil.rmtree(place)
            for other in host.beside:
                (folder / other).unlink(missing_ok=True)
        except OSError as e:
            raise ResourceError(f"{printable(place)} cannot be removed ({reason_of(e)}); close the program.") from None
        gone.append(place)
    return gone


def _check_ours(place: Path) -> None:
    """Raise ParameterError if a folder of that name is somebody else's."""
    if place.exists() and not (place / TOLD).is_file():
        raise ParameterError(f"{printable(place)} was not put there by intarsia; move it away first.")
