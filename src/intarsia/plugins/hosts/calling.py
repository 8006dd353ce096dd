"""Calls the program intarsia for a plug-in: finds it, starts it, hears what it tells, stops it.

Every plug-in has a copy of this file, and runs it by the Python of its host: 3.9 or newer, the standard library alone.
What is said between the two stands in docs/callers.md.
"""

from __future__ import annotations

import json
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

CONTRACT = 1
TOLD = Path(__file__).with_name("installed.json")
STOPPED = 130  # exit code of a run that was asked to stop
PATIENCE = 0.8  # s for a run to end by itself
LOOK = 0.05  # s between two looks at a run
MADE = 1  # s, until a new folder surely is locked
DAY = 86_400  # s
HIDDEN: dict[str, Any] = {"creationflags": 0x08000000} if os.name == "nt" else {}  # no console window
FOREIGN = ("PYTHONHOME", "PYTHONPATH", "PYTHONSTARTUP", "LD_LIBRARY_PATH", "LD_PRELOAD", "QT_PLUGIN_PATH")
"""Variables that a host sets for its own Python and its own libraries."""

SPELL = "uv tool install intarsia"


class Trouble(Exception):
    """One line for the person who uses the plug-in. `missing`: the program is not there, and can be installed."""

    def __init__(self, line: str, kind: str = "", missing: bool = False) -> None:
        super().__init__(line)
        self.kind, self.missing = kind, missing


class Stopped(Exception):
    """The person stopped the work."""


def environment() -> dict[str, str]:
    """Return the environment for the program: without what the host set for itself."""
    return {name: value for name, value in os.environ.items() if name not in FOREIGN}


def command(chosen: str = "") -> list[str]:
    """Return the words that start the program: the chosen path, else what installed the plug-in, else what PATH has."""
    if chosen.strip():
        path = Path(os.path.expanduser(chosen.strip()))
        if not path.is_file():
            raise Trouble(f"{path} is no file; name the program intarsia.", missing=True)
        return [str(path)]
    words: list[str] = installed().get("command", [])
    if words and Path(words[0]).is_file():
        return words
    usual = os.pathsep.join([os.environ.get("PATH", ""), str(Path.home() / ".local/bin"), str(_own_folder() / "bin")])
    found = shutil.which("intarsia", path=usual)
    if found is None:
        raise Trouble(f"intarsia was not found; install it ({SPELL}), or name its path.", missing=True)
    return [found]


def installed() -> dict[str, Any]:
    """Return what was written when the plug-in was installed; nothing where it was copied by hand."""
    try:
        told: dict[str, Any] = json.loads(TOLD.read_text(encoding="utf-8"))
        return told
    except (OSError, ValueError):
        return {}


def checked(words: Sequence[str]) -> dict[str, Any]:
    """Return what the program says of itself; Trouble if it is none, or does not belong to this plug-in."""
    try:
        asked = [*words, "where", "--json"]
        answer = subprocess.run(asked, capture_output=True, timeout=60, env=environment(), check=True, **HIDDEN)
        about: dict[str, Any] = json.loads(answer.stdout)
        version, contract = str(about["version"]), int(about["contract"])
    except (OSError, ValueError, KeyError, TypeError, subprocess.SubprocessError):
        line = f"{words[0]} does not answer as intarsia does; it is too old, or another program: {SPELL} --upgrade."
        raise Trouble(line, missing=True) from None
    if contract != CONTRACT:
        line = f"intarsia {version} and this plug-in do not belong together; put the plug-in in again: "
        raise Trouble(line + "intarsia install-plugin.")
    return about


class Call:
    """A run of the program. `words` are those of the command, `names` what the person calls its files: path -> name."""

    def __init__(self, program: Sequence[str], words: Sequence[object], names: Mapping[str, str] | None = None) -> None:
        called = [part for path, name in (names or {}).items() for part in ("--call", f"{path}={name}")]
        asked = [*program, *map(str, words), *called, "--progress", "json", "--with-parent"]
        try:
            self._process: subprocess.Popen[bytes] = subprocess.Popen(
                asked, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment(),
                **HIDDEN,
            )  # fmt: skip
        except OSError as e:
            raise Trouble(f"{program[0]} cannot be started ({e.strerror or e}).", missing=True) from None
        self.fraction, self.stage = 0.0, "start"
        self.remaining: float | None = None
        self.warnings: list[str] = []
        self._result: dict[str, Any] | None = None
        self._error: dict[str, Any] | None = None
        self._lines: queue.Queue[bytes | None] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stderr is not None
        with self._process.stderr as lines:
            for line in lines:
                self._lines.put(line)
        self._lines.put(None)

    def poll(self) -> bool:
        """Take in what was told until now; return whether the run has ended."""
        while True:
            try:
                line = self._lines.get_nowait()
            except queue.Empty:
                return False
            if line is None:
                self._process.wait()
                return True
            try:
                self._hear(json.loads(line))
            except ValueError:
                self._error = {"error": line.decode("utf-8", "replace").strip()}

    def _hear(self, told: dict[str, Any]) -> None:
        self.fraction = told.get("fraction", self.fraction)
        self.stage = told.get("stage", self.stage)
        self.remaining = told.get("remaining", self.remaining)
        self.warnings += [told["warning"]] if "warning" in told else []
        self._result = told.get("result", self._result)
        self._error = told if "error" in told else self._error

    def words(self) -> str:
        """Return the state in words for a progress bar."""
        if self.stage == "compile":
            return "Compiling, once, about half a minute"
        if self.stage == "start":
            return "Looking at the picture"
        left = "" if self.remaining is None or self.remaining < 2 else f", {self.remaining:.0f} s left"
        return f"Growing {100 * self.fraction:.0f} %{left}"

    def result(self) -> dict[str, Any]:
        """Return what the ended run has made, its warnings with the names that the person knows.

        Trouble with its one line if it failed, Stopped if it was stopped.
        """
        if self._process.returncode == 0 and self._result is not None:
            return {**self._result, "warnings": self.warnings}
        if self._process.returncode == STOPPED:
            raise Stopped
        told = self._error or {"error": f"intarsia ended with exit code {self._process.returncode}."}
        raise Trouble(told["error"], told.get("kind", ""))

    def stop(self) -> None:
        """End the run within a second, and wait for that."""
        assert self._process.stdin is not None
        with suppress(OSError):
            self._process.stdin.close()
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def run(
    program: Sequence[str],
    words: Sequence[object],
    names: Mapping[str, str] | None = None,
    told: Callable[[float, str], Any] | None = None,
) -> dict[str, Any]:
    """Run the program to its end, and return its result. `told(fraction, words)` may return False to stop it."""
    call = Call(program, words, names)
    try:
        while not call.poll():
            if told is not None and told(call.fraction, call.words()) is False:
                raise Stopped
            time.sleep(LOOK)
        return call.result()
    finally:
        call.stop()


class Folder(tempfile.TemporaryDirectory[str]):
    """A folder for the files of one call, removed at its end. Folders that a killed host left are removed, too.

    It is locked while its host lives, where the system has such locks; elsewhere what is a day old is left over.
    """

    MARK = "intarsia-plugin-"

    def __init__(self) -> None:
        for old in Path(tempfile.gettempdir()).glob(f"{self.MARK}*"):
            with suppress(OSError):
                if not old.is_symlink() and _left_over(old):
                    shutil.rmtree(old, ignore_errors=True)
        super().__init__(prefix=self.MARK)
        self._held = _locked(self.name)

    def cleanup(self) -> None:
        """Remove the folder."""
        super().cleanup()
        if self._held is not None:
            os.close(self._held)
            self._held = None


def _locked(folder: str | Path) -> int | None:
    """Lock a folder as long as this process lives; None if another holds it, or the system has no such locks."""
    if fcntl is None:
        return None
    held = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(held)
        return None
    return held


def _left_over(folder: Path) -> bool:
    """Return whether the host that made a folder has ended."""
    age = time.time() - folder.stat().st_mtime
    if fcntl is None or age < MADE:
        return age > DAY
    held = _locked(folder)
    if held is not None:
        os.close(held)
    return held is not None


def _own_folder() -> Path:
    """Return the folder of an environment that the plug-in makes itself."""
    home = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share"
    return Path(home) / "intarsia"


def installation(python: str = "") -> tuple[list[list[str]], str]:
    """Return the commands that install the program, as lists of words, and a line that tells a person of them.

    Trouble if there is neither uv nor a Python: the `sys.executable` of a host may be the host itself.
    """
    uv = shutil.which("uv", path=os.pathsep.join([os.environ.get("PATH", ""), str(Path.home() / ".local/bin")]))
    if uv is not None:
        return [[uv, "tool", "install", "--upgrade", "intarsia"]], f"{SPELL} (about 150 MB)"
    python = python or shutil.which("python3") or shutil.which("python") or sys.executable
    if not Path(python).stem.lower().startswith("python"):
        raise Trouble(f"neither uv nor Python was found; get uv (docs.astral.sh/uv), then: {SPELL}.", missing=True)
    own = _own_folder()
    inside = own / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    made = [[python, "-m", "venv", str(own)], [str(inside), "-m", "pip", "install", "--upgrade", "intarsia"]]
    return made, f"a Python environment of its own in {own} (about 150 MB)"


def install(python: str = "", told: Callable[[str], Any] | None = None) -> list[str]:
    """Install the program and have it compile; return the words that start it. `told(line)` hears of each step."""
    steps, _ = installation(python)
    for step in steps:
        if told is not None:
            told(" ".join(step[:3]))
        done = subprocess.run(step, capture_output=True, env=environment(), **HIDDEN)
        if done.returncode:
            last = (done.stderr or done.stdout).decode("utf-8", "replace").strip().splitlines()[-1:]
            raise Trouble(f"intarsia could not be installed: {' '.join(last) or 'no reason was told'}")
    words = command()
    subprocess.Popen([*words, "warm-up", "--quiet"], stdin=subprocess.DEVNULL, env=environment(), **HIDDEN)
    return words
