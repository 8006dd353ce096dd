"""Every bad file and value, given to every command in every way it can be given: one line and the right exit code.

All files of ``corpus`` and ``corpus_maps`` are read here in their roles (``roles`` finds these in the commands
themselves); so is every value of ``values`` for every option, and every bad place for every file that is written.
"""

from __future__ import annotations

import os
import resource
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import corpus
import corpus_maps
import pytest
import roles
from click.testing import CliRunner, Result

from intarsia import files
from intarsia.cli.app import COMMANDS, cli

ALL = os.environ.get("INTARSIA_HYPOTHESIS") == "thorough"
"""Every file in every role, some 28,000 runs; else the files that tell no more go round the roles."""

AS_USAGE = {"recipe patch=700", "recipe extend far"}
"""Cases whose values are refused like those of options, because they are sound but for the exemplar."""

FILES = [*corpus.CASES, *corpus_maps.MAPS, *corpus_maps.recipes(corpus_maps.FORM)]
LIBPNG = {"short-idat.png"}  # libpng itself writes a line to the terminal

MOST_SECONDS, MOST_MEMORY = 60, 700_000  # for one command; KiB


class Place:
    """A folder with sound files, in which a command must leave nothing behind when it fails."""

    def __init__(self, root: Path) -> None:
        self.work, self.folder, self.temporary, self.bad = (root / n for n in ("work", "folder", "tmp", "bad"))
        for made in (self.work, self.folder, self.temporary, self.bad):
            made.mkdir()
        roles.make_sound(self.work)
        self.cases = {**corpus.CASES, **corpus_maps.MAPS}
        os.chdir(self.work)
        sound = files.read_recipe("grown.png")
        assert sound is not None
        self.cases |= corpus_maps.recipes(sound)
        self.before = self.seen()
        self.paths: dict[str, Path] = {}

    def path(self, name: str) -> Path:
        if name not in self.paths:
            folder = self.bad / str(len(self.paths))
            folder.mkdir()
            self.paths[name] = self.cases[name].make(folder)
        return self.paths[name]

    def seen(self) -> dict[str, tuple[int, int]]:
        with os.scandir(self.work) as found:
            return {e.name: (e.stat(follow_symlinks=False).st_mtime_ns, e.stat(follow_symlinks=False).st_size)
                    for e in found}  # fmt: skip

    def run(self, words: list[str], data: bytes | None = None) -> tuple[int, str]:
        """Run a command; check how it ended; return exit code and what it said. What it made is taken away."""
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        began = time.monotonic()
        result = CliRunner().invoke(cli, words, input=data)
        assert time.monotonic() - began < MOST_SECONDS, words
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < MOST_MEMORY, words
        after = self.seen()
        made = set(after) - set(self.before)
        for name in made:
            os.rmdir(name) if os.path.isdir(name) else os.unlink(name)
        assert {n: after.get(n) for n in self.before} == self.before, words
        assert os.listdir(self.temporary) == [], words
        self.check(words, result, made)
        return result.exit_code, result.stderr

    def check(self, words: list[str], result: Result, made: set[str]) -> None:
        told = result.stderr.splitlines()
        assert "Traceback" not in result.output, words
        if result.exit_code == 0:
            assert not told, words
            assert "--dry-run" in words or made or result.stdout_bytes, words
            assert not [n for n in made if n.startswith(".")], words
            return
        assert not made, words
        assert len(told) == 1, (words, told)
        assert told[0].startswith("intarsia: "), (words, told)
        assert "internal error" not in told[0], (words, told)
        assert len(told[0]) < 700, words
        assert result.stdout_bytes == b"", words


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Place]:
    here, temporary = os.getcwd(), tempfile.tempdir
    place = Place(tmp_path_factory.mktemp("bad"))
    tempfile.tempdir = str(place.temporary)
    yield place
    tempfile.tempdir = temporary
    os.chdir(here)


def roles_of(command: str, name: str) -> list[roles.Role]:
    """The roles in which a command gets a file: all, or where files differ in their damage alone, some in turn."""
    every = list(roles.roles(command))
    number = FILES.index(name)
    if ALL:
        return every
    if name.startswith("map ") or name.startswith("recipe "):
        mine = [r for r in every if r.sort == name.split()[0]]
        return mine[:1] + [every[number % len(every)]]
    if name.startswith(("cut-", "flip-")) or name in ("text-bombs.png", "bomb2.png", "profile-bomb.png"):
        mine = roles.READERS.index(command) == number % len(roles.READERS)
        return [every[number // len(roles.READERS) % len(every)]] if mine else []
    if corpus.CASES[name].outcome == corpus.REFUSED:
        paths = [r for r in every if r.how == "path"]
        others = [r for r in every if r.how != "path"]
        return [*paths, others[number % len(others)]]
    return [every[number % len(every)]]


# numpy does not close a damaged .npz itself, which pytest takes for an error of this test.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("command", roles.READERS)
@pytest.mark.parametrize("name", FILES)
def test_a_bad_file_is_refused_in_one_line(
    name: str, command: str, place: Place, capfd: pytest.CaptureFixture[str]
) -> None:
    sort = name.split()[0] if name.startswith(("map ", "recipe ")) else "picture"
    for role in roles_of(command, name):
        given = role.words(place.path(name), place.folder)
        if given is None:
            continue
        code, told = place.run(*given)
        outcome = place.cases[name].outcome
        if sort != role.sort:
            # A picture may carry a recipe, but none of these does.
            assert code == (2 if role.how == "stdin" and role.sort == "map" else 3), (role, told)
        elif outcome == corpus.REFUSED and not (name == "whole-32.tif" and role.field in roles.LABELS):
            usage = name in AS_USAGE or (role.how == "stdin" and role.sort == "map")
            assert code == (2 if usage else 3), (role, told)
        elif outcome == corpus.OK and sort != "picture" and role.how == "path":
            assert code == 0, (role, told)
        else:  # sound, but it may be too small, or of another size or depth than the others
            assert code in (0, 1, 2, 3), (role, told)
            assert code != 1 or "free of masked pixels" in told or "no such patch" in told, (role, told)
    if name not in LIBPNG:
        assert capfd.readouterr() == ("", "")


VALUES = (
    "", " ", "-1", "-3", "0", "00", "1", "1.5", "nan", "inf", "-inf", "1e9", "1e400", "0x0", "1x", "x1", "1x1x1", "-3x4",
    "99999999x99999999", "99999999999999999999999", "9" * 5000, "letters", "1_000", "\u0663", "\u221e", "1,", ",", "1,nan",
    "0,0,0", "a,b,c,d", "0,0,0,0", "-1,-1,1,1", "1..", "9..1", "1..99999999", "{seed}", "{", "%s", "#12", "#gggggg",
    "None", "true", "1 1", "1,0 2,0 3,0", "0,0", "=", "=x", "a=", "../../x", "\u6728\u76ee", "x" * 3000, "8\n9",
)  # fmt: skip
"""What is written behind every option that names no file."""


def options(command: str) -> list[str]:
    return [str(p.name) for p in roles.command(command).params if _valued(command, p)]


def _valued(command: str, p: click.Parameter) -> bool:
    return not roles.names_a_file(p) and not (isinstance(p, click.Option) and (p.is_flag or p.is_eager))


@pytest.mark.parametrize(("command", "option"), [(c, o) for c in COMMANDS if c != "warm-up" for o in options(c)])
def test_a_strange_value_is_used_or_refused_in_one_line(command: str, option: str, place: Place) -> None:
    """R-40, R-41 and what else a stranger may type: never a traceback, a warning of a library, or a file left over."""
    dry = any(p.name == "dry_run" for p in roles.command(command).params)
    for value in VALUES:
        words = [*roles.line(command), *(["--dry-run"] if dry else []), *roles.said(command, option, value)]
        code, told = place.run(words)
        assert code in (0, 2, 3), (value, told)
        if option not in ("slug", "progress"):
            assert code in (2, 3) or value not in ("letters", "nan", "x" * 3000, "%s"), value


@pytest.mark.parametrize("command", list(COMMANDS))
def test_unknown_options_and_too_few_words_are_refused(command: str, place: Place) -> None:
    lines = [["--frobnicate"], ["--frobnicate=3"], ["-Z"], ["--threads"], ["a\0b", "--frobnicate"]]
    if roles.file_parameters(command):
        lines += [[], ["--"], ["-q", "-q", "--size"]]
    for words in lines:
        assert place.run([command, *words])[0] == 2, words


def places(root: Path) -> dict[str, tuple[str, set[int]]]:
    """Where nothing can be written: a name, and the exit codes that are right."""
    (root / "made.d").mkdir(exist_ok=True)
    for name in ("fifo.png",):
        if not (root / name).exists():
            os.mkfifo(root / name)
    return {
        "a folder": (str(root / "made.d"), {2}),
        "the folder here": (".", {2}),
        "the root": ("/", {2}),
        "a missing folder": (str(root / "missing" / "o{}"), {3}),
        "below a file": ("a.png/o{}", {1, 3}),
        "a pipe": (str(root / "fifo.png"), {2}),
        "a device": ("/dev/full", {2}),
        "no ending": (str(root / "o"), {2}),
        "an unknown ending": (str(root / "o.qqq"), {2}),
        "an ending that is only read": (str(root / "o.gif"), {2}),
        "nothing": ("", {2}),
        "a zero": ("o\0{}", {2, 3}),
        "a long name": ("o" * 300 + "{}", {2, 3}),
        "a file that is there": ("b.png", {2}),
        "the input": ("a.png", {2}),
        "a folder that lets nobody write": ("/proc/self/o{}", {1, 3}),
        "an unknown field": ("o{{colour}}{}", {2}),
    }


@pytest.mark.parametrize(
    ("command", "field"), [(c, f) for c in COMMANDS for f in roles.file_parameters(c) if f in roles.WRITTEN]
)
def test_a_place_that_cannot_be_written_is_refused(command: str, field: str, place: Place, tmp_path: Path) -> None:
    """R-45, R-48: before any work, and what is there stays."""
    for name, (path, codes) in places(tmp_path).items():
        ending = os.path.splitext(roles.WRITTEN[field])[1]
        more = {} if field == "out" else {"out": "out.png"} if _writes(command) else {}
        value = path.format(ending)
        words = [*roles.line(command, **more), *roles.said(command, field, value)]
        if field == "distance_map" and command != "replay":
            words += ["--method", "patch-sampling"]
        code, told = place.run(words)
        # Method and fields of a distance map are looked at first, and a sheet's name is taken as it is.
        later = field == "distance_map" and command in ("replay", "heal")
        assert code in (codes | {1, 2} if later else codes) or (field == "sheet" and "field" in name), (name, told)


def _writes(command: str) -> bool:
    return "out" in roles.file_parameters(command)


WITH_OUT = [c for c in COMMANDS if _writes(c)]


@pytest.mark.parametrize("command", WITH_OUT)
def test_a_full_disk_leaves_nothing(command: str, place: Place) -> None:
    """R-48: a file may not grow beyond 200 bytes; also over a file that is there, which then stays."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    for words in (roles.line(command), [*roles.line(command, out="b.png"), "--force"]):
        resource.setrlimit(resource.RLIMIT_FSIZE, (200, limits[1]))
        try:
            code, told = place.run(words)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert code == 1, told
        assert "room" in told


@pytest.mark.parametrize("command", WITH_OUT)
@pytest.mark.parametrize("call", ["os.replace", "os.fsync", "os.access"])
def test_a_folder_that_fails_leaves_nothing(
    command: str, call: str, place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    """R-48: read-only, or broken in the last moment."""

    def fail(*_: object, **__: object) -> Any:
        raise PermissionError(30, "Read-only file system")

    kept: Callable[..., Any] = fail if call != "os.access" else (lambda *_, **__: False)
    monkeypatch.setattr(call, kept)
    code, told = place.run(roles.line(command))
    assert code == 1, told


@pytest.mark.parametrize("command", WITH_OUT)
def test_the_output_may_replace_the_input_if_asked(command: str, place: Place) -> None:
    """It is read before it is written."""
    for name in ("o.png", "ünïcödé 木目.png", "percent%04d.png", " space.png"):
        assert place.run(roles.line(command, out=name))[0] == 0
    Path("own.png").write_bytes(Path("a.png").read_bytes())
    field = next(f for f in ("files", "image", "exemplar") if f in roles.file_parameters(command))
    words = [*roles.line(command, **{field: "own.png", "out": "own.png"}), "--force"]
    if command == "replay":
        words = [*roles.line(command, out="own.png"), "--force"]
    result = CliRunner().invoke(cli, words)
    assert result.exit_code == 0, result.stderr
    assert Path("own.png").read_bytes() != Path("a.png").read_bytes()
    Path("own.png").unlink()


def test_every_command_is_covered() -> None:
    """A command that reads files has a role for each, and one that writes is tried with every bad place."""
    for command in COMMANDS:
        assert set(roles.file_parameters(command)) <= set(roles.SOUND) | set(roles.WRITTEN)
    assert set(COMMANDS) - set(roles.READERS) == {"methods", "warm-up"}
