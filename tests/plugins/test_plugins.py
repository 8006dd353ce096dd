"""Plug-ins are put where their programs look, and taken away; what they share calls the program as it should."""

from __future__ import annotations

import importlib.util
import json
import os
import stat
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from cli.commands import run

import intarsia as ia
from intarsia import files, plugins
from intarsia.plugins import CONTRACT, HOSTS, KNOWN, TOLD, Host

CACHE = os.environ.get("INTARSIA_CACHE") or os.path.expanduser("~/.cache/intarsia")
THERE = [name for name in KNOWN if (HOSTS / name).is_dir()]


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("HOME", "APPDATA", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setenv("INTARSIA_CACHE", CACHE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def calling(tmp_path: Path) -> ModuleType:
    """What all plug-ins share, as it lies in the folder of an installed one."""
    run("install-plugin", "comfyui", "--to", tmp_path)
    return loaded(tmp_path / "intarsia-textures" / "calling.py")


def loaded(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("calling", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def program(folder: Path, text: str) -> list[str]:
    """A program of our own that takes the place of intarsia."""
    path = folder / "other.py"
    path.write_text(text)
    return [sys.executable, str(path)]


class TestInstalling:
    @pytest.mark.parametrize("name", THERE)
    def test_all_of_it_is_copied_and_taken_away_again(self, name: str, home: Path) -> None:
        host = KNOWN[name]
        said = run("install-plugin", name, "--to", home).stdout
        place = home / host.name
        assert f"wrote {place}" in said
        assert host.then in said
        shipped = {p.relative_to(HOSTS / name / host.name) for p in (HOSTS / name / host.name).rglob("*")}
        shipped = {p for p in shipped if "__pycache__" not in p.parts}
        assert {p.relative_to(place) for p in place.rglob("*")} == shipped | {Path("calling.py"), Path(TOLD)}
        told = json.loads((place / TOLD).read_text())
        assert told == {"version": ia.__version__, "contract": CONTRACT, "command": plugins.own_command()}
        assert all((home / other).exists() for other in host.beside)
        assert f"removed {place}" in run("install-plugin", name, "--to", home, "--remove").stdout
        assert not list(home.iterdir())

    @pytest.mark.parametrize("name", THERE)
    def test_what_can_be_run_stays_so(self, name: str, home: Path) -> None:
        run("install-plugin", name, "--to", home)
        for path in (HOSTS / name / KNOWN[name].name).rglob("*.py"):
            copy = home / KNOWN[name].name / path.relative_to(HOSTS / name / KNOWN[name].name)
            assert stat.S_IMODE(copy.stat().st_mode) == stat.S_IMODE(path.stat().st_mode)

    def test_every_version_that_was_started_gets_it(self, home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        host = Host("Test", "intarsia-textures", ("~/.config/test/[34].*",), "plug-ins", "start it")
        monkeypatch.setitem(KNOWN, "comfyui", host)
        for version in ("2.9", "3.0", "4.1"):
            (home / ".config/test" / version).mkdir(parents=True)
        placed = plugins.install("comfyui")
        assert placed == [home / f".config/test/{v}/plug-ins/intarsia-textures" for v in ("3.0", "4.1")]
        assert not (home / ".config/test/2.9/plug-ins").exists()

    def test_an_older_one_is_replaced_and_what_is_not_ours_stays(self, home: Path) -> None:
        run("install-plugin", "comfyui", "--to", home)
        old = home / "intarsia-textures" / "old.py"
        old.write_text("")
        run("install-plugin", "comfyui", "--to", home)
        assert not old.exists()
        (home / "intarsia-textures" / TOLD).unlink()
        for more in ([], ["--remove"]):
            run("install-plugin", "comfyui", "--to", home, *more, code=2)
        assert (home / "intarsia-textures" / "__init__.py").exists()
        assert sorted(os.listdir(home)) == ["intarsia-textures"]

    @pytest.mark.parametrize(("words", "why"), [
        ("comfyui", "name its custom_nodes with --to"), ("gimp", "start it once"),
        ("gimp --to none", "none is no folder"), ("comfyui --to . --remove", "nothing to remove"),
        ("photoshop", "is not one of"),
    ])  # fmt: skip
    def test_refusals_are_one_line(self, words: str, why: str) -> None:
        said = run(f"install-plugin {words}", code=2).stderr.strip()
        assert why in said
        assert "\n" not in said

    def test_a_disk_that_is_full_leaves_what_was_there(self, home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        run("install-plugin", "comfyui", "--to", home)

        def full(*_: Any, **__: Any) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr("shutil.copy", full)
        assert "no space left" in run("install-plugin", "comfyui", "--to", home, code=1).stderr
        assert sorted(os.listdir(home)) == ["intarsia-textures"]
        assert (home / "intarsia-textures" / TOLD).is_file()


class TestCalling:
    """Against the command line itself, and against programs that are none."""

    def test_it_is_found_by_what_installed_it_by_a_path_and_on_the_path(
        self, calling: ModuleType, home: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        assert calling.command() == plugins.own_command()
        own = home / "intarsia"
        own.write_text("")
        own.chmod(0o755)
        assert calling.command(str(own)) == [str(own)]
        assert calling.command("~/intarsia") == [str(own)]
        calling.TOLD.unlink()
        monkeypatch.setenv("PATH", str(home))
        assert calling.command() == [str(own)]
        own.unlink()
        for chosen, why in (("", "uv tool install intarsia"), ("/none", "/none is no file")):
            with pytest.raises(calling.Trouble, match=why) as told:
                calling.command(chosen)
            assert told.value.missing

    def test_it_says_when_the_two_do_not_belong_together(self, calling: ModuleType, home: Path) -> None:
        assert calling.checked(plugins.own_command())["version"] == ia.__version__
        newer = program(home, "print('{\"version\": \"9.0\", \"contract\": 2}')")
        with pytest.raises(calling.Trouble, match=r"^intarsia 9\.0 and this plug-in do not belong together"):
            calling.checked(newer)
        for text in ("print('hello')", "raise SystemExit(2)", "print('{}')"):
            with pytest.raises(calling.Trouble, match="does not answer as intarsia does"):
                calling.checked(program(home, text))
        with pytest.raises(calling.Trouble, match="does not answer"):
            calling.checked([str(home / "none")])

    def test_a_run_gives_its_result_and_tells_how_far_it_is(self, calling: ModuleType) -> None:
        files.write("layer-1.png", ia.Plane(np.random.default_rng(1).integers(0, 255, (40, 48, 3), np.uint8)))
        told: list[tuple[float, str]] = []
        words = ["grow", "layer-1.png", "-o", "out.png", "--size", "900", "--method", "image-quilting", "--patch", "12"]
        result = calling.run(plugins.own_command(), words, told=lambda *said: told.append(said))
        assert result["size"] == [900, 900]
        assert [f for f, _ in told] == sorted(f for f, _ in told)
        assert told[0] == (0.0, "Looking at the picture")
        assert any(said.startswith("Growing ") for _, said in told)

    def test_a_failure_is_one_line_with_the_persons_names(self, calling: ModuleType, home: Path) -> None:
        words = ["grow", str(home / "layer-1.png"), "-o", "out.png"]
        with pytest.raises(calling.Trouble, match=r"^Background does not exist") as told:
            calling.run(plugins.own_command(), words, {str(home / "layer-1.png"): "Background"})
        assert told.value.kind == "input"

    def test_what_it_says_besides_lines_is_no_secret(self, calling: ModuleType, home: Path) -> None:
        with pytest.raises(calling.Trouble, match=r"^killed by somebody"):
            calling.run(program(home, "import sys; sys.exit('killed by somebody')"), [])
        with pytest.raises(calling.Trouble, match="exit code 5"):
            calling.run(program(home, "raise SystemExit(5)"), [])
        with pytest.raises(calling.Trouble, match="cannot be started"):
            calling.run([str(home / "none")], [])

    def test_a_run_is_stopped_by_what_hears_of_it(self, calling: ModuleType, home: Path) -> None:
        files.write("layer-1.png", ia.Plane(np.random.default_rng(1).integers(0, 255, (40, 48, 3), np.uint8)))
        before = sorted(os.listdir(home))
        words = ["grow", "layer-1.png", "-o", "out.png", "--size", "3000", "--patch", "9"]
        with pytest.raises(calling.Stopped):
            calling.run(plugins.own_command(), words, told=lambda fraction, _: fraction == 0)
        assert sorted(os.listdir(home)) == before

    def test_a_run_that_does_not_listen_is_ended(self, calling: ModuleType, home: Path) -> None:
        deaf = "import signal, sys, time; signal.signal(15, lambda *_: None); print(1, file=sys.stderr, flush=True)\n"
        call = calling.Call(program(home, deaf + "while True: time.sleep(9)"), [])
        call.stop()
        assert call._process.returncode == -9

    def test_what_the_host_sets_for_itself_is_not_handed_on(
        self, calling: ModuleType, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        for name in calling.FOREIGN:
            monkeypatch.setenv(name, "foreign")
        assert not set(calling.FOREIGN) & set(calling.environment())
        assert calling.environment()["HOME"] == os.environ["HOME"]

    def test_folders_that_a_killed_host_left_are_swept(
        self, calling: ModuleType, home: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("tempfile.tempdir", str(home))
        left, fresh = home / "intarsia-plugin-a", home / "intarsia-plugin-b"
        for folder in (left, fresh):
            folder.mkdir()
            (folder / "layer.png").write_text("")
        os.utime(left, (0, 0))
        with calling.Folder() as own:
            assert Path(own).is_dir()
            assert not left.exists()
            assert fresh.exists()
        assert not Path(own).exists()

    @pytest.mark.parametrize("there", [True, False])
    def test_it_is_installed_by_uv_or_into_an_environment_of_its_own(
        self, there: bool, calling: ModuleType, home: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("PATH", str(home))
        if there:
            (home / "uv").write_text("")
            (home / "uv").chmod(0o755)
        steps, said = calling.installation("/usr/bin/python3")
        if there:
            assert steps == [[str(home / "uv"), "tool", "install", "--upgrade", "intarsia"]]
            assert said.startswith("uv tool install intarsia")
        else:
            assert [step[1:3] for step in steps] == [["-m", "venv"], ["-m", "pip"]]
            assert str(home / "intarsia") in said

    def test_an_installation_that_fails_says_why(self, calling: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
        failing = [[sys.executable, "-c", "import sys; sys.exit('no network')"]]
        monkeypatch.setattr(calling, "installation", lambda _: (failing, ""))
        heard: list[str] = []
        with pytest.raises(calling.Trouble, match="could not be installed: no network"):
            calling.install(told=heard.append)
        assert len(heard) == 1
