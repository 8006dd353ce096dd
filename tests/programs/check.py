"""Install what this machine offers of the programs that take plug-ins, and try each plug-in inside its program.

    python tests/programs/check.py                     all of them
    python tests/programs/check.py gimp krita          some

Programs come from Debian 13: from this system if it is one, else from a root of Debian 13 below build/, made by
debootstrap, which needs the rights of root. Blender is tried from the package index, too (bpy). ComfyUI is tried where
INTARSIA_COMFYUI names its folder. What cannot be had is left out, with a line that says why. Exits with 1 if a check
fails.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
PROGRAMS = HOME / "tests" / "programs"
BUILD = HOME / "build" / "programs"
RELEASE = "trixie"  # the first Debian that has GIMP 3
MIRROR = "http://deb.debian.org/debian"
SKIPPED = 77
LONGEST = 1800  # s for the checks of one program
PACKAGES = {
    "gimp": ["gimp", "gir1.2-gimp-3.0", "python3-gi"],
    "krita": ["krita", "python3-pyqt5"],
    "blender": ["blender", "python3-numpy"],
    "blender-window": ["blender", "python3-numpy", "xvfb", "xauth", "libgl1-mesa-dri", "libegl1"],
}
NEEDED = ["python3-venv", "ca-certificates"]


class Left(Exception):
    """A program cannot be had here."""


class Place:
    """Where programs run: this system, or a root of Debian below build/ that sees this folder and /tmp."""

    def __init__(self, root: Path | None) -> None:
        self.root = root

    def run(self, *words: str, check: bool = True, **variables: str) -> int:
        """Run a command with these variables besides, and return its exit code."""
        words = tuple(map(str, words))
        if self.root is not None:
            words = ("unshare", "--mount", "--propagation", "private", "sh", "-c", self._entered(words))
        done = subprocess.run(words, env=os.environ | variables, timeout=LONGEST, stdin=subprocess.DEVNULL)
        if check and done.returncode:
            raise Left(f"{shlex.join(words[:4])} ended with exit code {done.returncode}")
        return done.returncode

    def _entered(self, words: Sequence[str]) -> str:
        """Return a script that runs a command in the root; what it mounts is seen by this command alone."""
        root = shlex.quote(str(self.root))
        mounts = [f"mount --bind /proc {root}/proc", f"mount --rbind /dev {root}/dev", f"mount --bind /tmp {root}/tmp"]
        mounts += [f"mkdir -p {root}{HOME}", f"mount --bind {shlex.quote(str(HOME))} {root}{shlex.quote(str(HOME))}"]
        return " && ".join([*mounts, f"exec chroot {root} {shlex.join(words)}"])

    def take(self, name: str) -> None:
        """Copy a file of this system into the root."""
        if self.root is not None and Path("/", name).exists():
            shutil.copy(Path("/", name), self.root / name)

    def install(self, *packages: str) -> None:
        """Install packages of Debian, if they are not there."""
        if self.run("dpkg-query", "--show", *packages, check=False):
            quiet = ["apt-get", "--yes", "--quiet", "--no-install-recommends", "install", *packages]
            self.run(*quiet, DEBIAN_FRONTEND="noninteractive")


def debian() -> Place:
    """Return where programs of Debian 13 run; Left if nowhere."""
    about = Path("/etc/os-release").read_text() if Path("/etc/os-release").exists() else ""
    if f"VERSION_CODENAME={RELEASE}" in about:
        return Place(None)
    if os.geteuid() or shutil.which("debootstrap") is None or shutil.which("unshare") is None:
        raise Left(f"this is no Debian {RELEASE}; as root, debootstrap would make one below build/")
    root = BUILD / RELEASE
    if not (root / "usr/bin/apt-get").exists():
        shutil.rmtree(root, ignore_errors=True)
        root.parent.mkdir(parents=True, exist_ok=True)
        Place(None).run("debootstrap", "--variant=minbase", RELEASE, str(root), MIRROR)
    place = Place(root)
    place.take("etc/resolv.conf")
    place.run("apt-get", "--quiet", "update")
    place.install(*NEEDED)
    place.take("etc/ssl/certs/ca-certificates.crt")  # what this system trusts, which may be more than Debian does
    return place


def command_in(place: Place) -> str:
    """Return the path of a command `intarsia` of this checkout that runs in a place, with all compiled."""
    home = BUILD / "intarsia"
    if not (home / "bin/intarsia").exists():
        place.run("python3", "-m", "venv", "--clear", str(home))
        place.run(str(home / "bin/pip"), "install", "--quiet", "--editable", str(HOME))
    place.run(str(home / "bin/intarsia"), "warm-up", "--quiet")
    return str(home / "bin/intarsia")


@contextmanager
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="intarsia-check-") as made:
        yield Path(made)


def gimp(place: Place, command: str) -> int:
    with folder() as home:
        (home / "plug-ins").mkdir()
        place.run(command, "install-plugin", "gimp", "--to", str(home / "plug-ins"))
        script = f"exec(open({str(PROGRAMS / 'gimp.py')!r}).read())"
        words = ["gimp-console-3.0", "-idf", "--batch-interpreter=python-fu-eval", "-b", script, "--quit"]
        return place.run(*words, check=False, GIMP3_DIRECTORY=str(home), INTARSIA=command)


def krita(place: Place, command: str) -> int:
    with folder() as home:
        place.run(command, "install-plugin", "krita", "--to", str(home))
        told = {"HOME": str(home), "PLUGINS": str(home), "PYTHONPATH": str(PROGRAMS), "TMPDIR": str(home)}
        words = ["kritarunner", "-s", "in_krita", "-f", "main"]
        return place.run(*words, check=False, QT_QPA_PLATFORM="offscreen", INTARSIA=command, **told)


def blender(place: Place, command: str) -> int:
    words = ["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python"]
    return _in_blender(place, command, [*words, str(PROGRAMS / "blender.py")])


def blender_window(place: Place, command: str) -> int:
    words = ["xvfb-run", "blender", "--factory-startup", "--enable-event-simulate", "--window-geometry", "0", "0"]
    return _in_blender(place, command, [*words, "1280", "800", "--python", str(PROGRAMS / "blender_window.py")])


def _in_blender(place: Place, command: str, words: Sequence[str]) -> int:
    with folder() as home:
        (home / "user_default").mkdir()
        place.run(command, "install-plugin", "blender", "--to", str(home / "user_default"))
        told = {"BLENDER_USER_EXTENSIONS": str(home), "LIBGL_ALWAYS_SOFTWARE": "1", "INTARSIA": command}
        return place.run(*words, check=False, **told)


def bpy(place: Place, command: str) -> int:
    """Blender as a module, of the newest version that the package index has for this Python."""
    python = BUILD / "bpy/bin/python"
    if not python.exists():
        place.run("python3", "-m", "venv", "--clear", str(BUILD / "bpy"))
        place.run(str(python), "-m", "pip", "install", "--quiet", "bpy", "numpy")
    return _in_blender(place, command, [str(python), str(PROGRAMS / "blender.py")])


def comfyui(place: Place, command: str) -> int:
    """The server itself, where there is one; by stand-ins the nodes are tried among the usual tests."""
    return place.run(sys.executable, str(PROGRAMS / "comfyui.py"), check=False)


CHECKS: dict[str, Callable[[Place, str], int]] = {
    "gimp": gimp, "krita": krita, "blender": blender, "blender-window": blender_window, "bpy": bpy, "comfyui": comfyui,
}  # fmt: skip


def tried(name: str, places: list[tuple[Place, str]]) -> str:
    """Check one program, and return how it went; the place is made by the first that needs it."""
    try:
        if name == "comfyui":
            code = comfyui(Place(None), "")
        else:
            if not places:
                place = debian()
                places.append((place, command_in(place)))
            place, command = places[0]
            place.install(*PACKAGES.get(name, []))
            code = CHECKS[name](place, command)
    except (Left, OSError, subprocess.TimeoutExpired) as e:
        return f"left out: {e}"
    return {0: "all is well", SKIPPED: "left out, as it says above"}.get(code, f"FAILED with exit code {code}")


def main(*names: str) -> int:
    """Check these programs, or all; return the exit code."""
    unknown = [name for name in names if name not in CHECKS]
    if unknown:
        print(f"{unknown[0]} is unknown; choose some of {', '.join(CHECKS)}")
        return 2
    places = list[tuple[Place, str]]()
    ends = {}
    for name in names or CHECKS:
        print(f"== {name}", flush=True)
        ends[name] = tried(name, places)
    print("\n".join(f"{name:16}{end}" for name, end in ends.items()))
    return int(any(end.startswith("FAILED") for end in ends.values()))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
