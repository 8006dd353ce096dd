"""The documentation is true: its examples run, its tables are those of the code, its links lead somewhere."""

from __future__ import annotations

import importlib.util
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import intarsia as ia
from intarsia.cli import COMMANDS, cli
from intarsia.methods import METHODS

ROOT = Path(__file__).resolve().parent.parent
FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.DOTALL | re.MULTILINE)
LANGUAGES = {"python", "sh", "text"}


def load(path: Path) -> ModuleType:
    """Import a script by its path."""
    name = f"_loaded_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


TABLES = load(ROOT / "docs" / "make_tables.py")
DOCUMENTS: list[Path] = TABLES.documents()
NAMES = [str(path.relative_to(ROOT)) for path in DOCUMENTS]


def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def blocks(path: Path, language: str) -> list[str]:
    return [body for _, found, body in FENCE.findall(text_of(path)) if found == language]


PYTHON = [(path, number) for path in DOCUMENTS for number in range(len(blocks(path, "python")))]


@pytest.fixture
def moss(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the pictures that the documentation speaks of."""
    draws = np.random.default_rng(1)
    colour = draws.integers(0, 256, (96, 96, 3), dtype=np.uint8)
    normal = np.dstack([colour[:, :, :2] // 4 + 96, np.full((96, 96), 250, np.uint8)])
    half = np.repeat(np.array([[0, 255]], np.uint8), 48, axis=1).repeat(96, axis=0)
    pictures = {
        "moss": colour,
        "coast": np.where(half[:, :, None] > 0, colour // 2, 255 - colour // 2).astype(np.uint8),
        "ramp": half,
        "sand": 255 - colour // 2,
        "coast_labels": half,
        "sand_labels": half * 0,
        "moss_labels": half * 0 + 255,
        "island": np.pad(np.full((50, 60), 255, np.uint8), 30),
        "moss_albedo": colour,
        "moss_normal": normal,
        "moss_height": draws.integers(0, 65536, (96, 96), dtype=np.uint16),
        "moss_roughness": colour[:, :, 0],
        "moss_mask": np.pad(np.full((90, 90), 255, np.uint8), 3),
        "scratches": np.pad(np.full((10, 30), 255, np.uint8), ((40, 46), (30, 36))),
        "cutout": np.dstack([colour, np.pad(np.zeros((12, 12), np.uint8), 42, constant_values=255)]),
    }
    for name, pixels in pictures.items():
        ia.write(tmp_path / f"{name}.png", pixels)
    monkeypatch.chdir(tmp_path)
    return tmp_path


SLOW = {("parallel-controllable", 2), ("map-and-rendering", 3)}


@pytest.mark.parametrize(
    ("path", "number"),
    [pytest.param(p, n, marks=pytest.mark.long if (p.stem, n) in SLOW else (), id=f"{p.stem}-{n}") for p, n in PYTHON],
)
def test_python_blocks_run(path: Path, number: int, moss: Path) -> None:
    """Each on its own, in a folder with pictures."""
    exec(compile(blocks(path, "python")[number], f"{path.name}, block {number}", "exec"), {"__name__": "__main__"})


def smaller(arguments: list[str]) -> list[str]:
    """The same command for a picture of at most 200 px a side, where it grows one; of the corner of a photograph."""
    if arguments[0] not in ("grow", "weave") or {"--dry-run", "--wrap", "--save-map"} & {*arguments}:
        return arguments  # a wrapped picture must hold whole periods, a map is read again as the page says
    sized = [n + 1 for n, word in enumerate(arguments) if word in ("--size", "-s")]
    for n in sized:
        arguments[n] = re.sub(r"\d+", lambda found: str(min(int(found[0]), 200)), arguments[n])
    large = arguments[0] == "grow" and {"sample:brick", "sample:grass", "sample:gravel"} & {*arguments}
    return [*arguments, *(() if sized else ("--size", "200")), *(("--crop", "0,0,200,200") if large else ())]


def test_a_smaller_command_is_the_same_but_for_its_size() -> None:
    for line, wanted in {
        "grow a.png -o b.png": "grow a.png -o b.png --size 200",
        "grow sample:brick --size 90": "grow sample:brick --size 90 --crop 0,0,200,200",
        "weave a.png --size 2048x120 --seed 7000": "weave a.png --size 200x120 --seed 7000",
        "grow a.png -o b.png --size 20000 --dry-run": "grow a.png -o b.png --size 20000 --dry-run",
        "render map.npz -o b.png": "render map.npz -o b.png",
    }.items():
        assert smaller(line.split()) == wanted.split()


@pytest.mark.parametrize("path", [p for p in DOCUMENTS if blocks(p, "sh")], ids=lambda p: p.stem)
def test_command_lines_run(path: Path, moss: Path, thorough: bool) -> None:
    """All of a document one after another, in one folder; as they stand in the long run, else for small pictures."""
    for block in blocks(path, "sh"):
        for line in block.replace("\\\n", " ").splitlines():
            program, *arguments = shlex.split(line, comments=True) or [""]
            if not program:
                continue
            assert program == "intarsia", f"{path.name}: {line}"
            if arguments == ["warm-up"] and not thorough:  # `make test` has done so
                continue
            done = CliRunner().invoke(cli, arguments if thorough else smaller(arguments), prog_name="intarsia")
            assert done.exit_code == 0, f"{path.name}: {line}\n{done.output}"


@pytest.mark.parametrize("path", DOCUMENTS, ids=NAMES)
def test_blocks_are_closed_and_of_a_known_language(path: Path) -> None:
    assert len(re.findall(r"^ *```", text_of(path), re.MULTILINE)) == 2 * len(FENCE.findall(text_of(path)))
    assert {language for _, language, _ in FENCE.findall(text_of(path))} <= LANGUAGES


@pytest.mark.parametrize("path", DOCUMENTS, ids=NAMES)
def test_tables_are_those_of_the_code(path: Path) -> None:
    """`make tables` writes them."""
    assert TABLES.filled(path, text_of(path)) == text_of(path)


def test_every_method_has_a_page_with_its_parameters() -> None:
    pages = {path.stem: text_of(path) for path in (ROOT / "docs" / "methods").glob("*.md")}
    assert set(pages) == set(METHODS)
    for slug, text in pages.items():
        assert f"<!-- parameters: {slug} -->" in text
        assert text.startswith(f"# {slug}\n")
        for word in ("```python", "```sh", "../images/", "Source", "Departures", "Cost"):
            assert word.lower() in text.lower(), f"{slug}: {word}"


def test_every_command_has_a_section() -> None:
    page = text_of(ROOT / "docs" / "command-line.md")
    for name in COMMANDS:
        assert f"\n## {name}\n" in page
        assert f"[`{name}`](#{name})" in page


def anchors(path: Path) -> set[str]:
    """Return the anchors of the headings of a document."""
    heads = re.findall(r"^#+ (.+)$", FENCE.sub("", text_of(path)), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("path", DOCUMENTS, ids=NAMES)
def test_links_lead_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)|^\[[^\]]+\]: (\S+)", FENCE.sub("", text_of(path)), re.MULTILINE):
        place, _, anchor = (target[0] or target[1]).partition("#")
        if place.startswith("https://"):
            continue
        found = path if not place else (path.parent / place).resolve()
        assert found.exists(), f"{path.name}: {place}"
        assert found.is_relative_to(ROOT)
        if anchor:
            assert anchor in anchors(found), f"{path.name}: {place}#{anchor}"


def test_every_page_is_reached_from_the_index() -> None:
    seen, open_pages = set(), [ROOT / "README.md"]
    while open_pages:
        page = open_pages.pop()
        if page in seen or page.suffix != ".md":
            continue
        seen.add(page)
        links = re.findall(r"\]\(([^)#\s]+)", text_of(page))
        open_pages += [(page.parent / link).resolve() for link in links if not link.startswith("https://")]
    assert seen == set(DOCUMENTS)


def test_pictures_are_small_and_all_are_used() -> None:
    pictures = {path.stem: path for path in (ROOT / "docs" / "images").iterdir() if path.is_file()}
    windows = {path.stem: path for path in (ROOT / "docs" / "images" / "plug-ins").iterdir()}  # of other programs
    of_studio = re.findall(r'keep\(page, "([\w-]+)"\)', text_of(ROOT / "docs" / "make_studio_pictures.py"))
    made = {"architecture", *load(ROOT / "docs" / "make_pictures.py").PICTURES, *of_studio}
    assert set(pictures) == made
    used = {Path(link).stem for p in DOCUMENTS for link in re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text_of(p))}
    assert used == made | set(windows)
    for name, path in pictures.items():
        assert path.stat().st_size < 400_000, name
    for name, path in windows.items():
        assert path.stat().st_size < 60_000, name


def test_one_picture_is_made_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = load(ROOT / "docs" / "make_pictures.py")
    monkeypatch.setattr(script, "FOLDER", tmp_path)
    script.main("repeat")
    assert [path.name for path in tmp_path.iterdir()] == ["repeat.jpg"]
    with pytest.raises(SystemExit, match="no picture is called moss; there are hero, "):
        script.main("repeat", "moss")


def named_file(stem: str) -> Path:
    """The file of tests that is called so, in whichever room."""
    (found,) = (ROOT / "tests").rglob(f"{stem}.py")
    return found


TABLE_002 = [f"S2-{n:02}" for n in range(1, 14)] + [f"D2-{n}" for n in range(1, 8)]
TABLE_002 += ["D0-2", "D0-3", "D0-4", "D0-5", "D0-6", "S0-80", "S0-81", "D-G1"]
TABLE_001 = [f"S1-{n:02}" for a, b in ((1, 8), (10, 18), (20, 21), (30, 39), (50, 57)) for n in range(a, b + 1)]
TABLE_001 += [f"D1-{n}" for n in range(1, 10)] + ["D-L1"]


@pytest.mark.parametrize(("page", "wanted"), [("sources-001.md", TABLE_001), ("sources-002.md", TABLE_002)])
def test_the_tables_of_sources_name_tests_that_exist(page: str, wanted: list[str]) -> None:
    tests = {path.stem: text_of(path) for path in (ROOT / "tests").rglob("*.py")}
    text = text_of(ROOT / "docs" / page)
    assert re.findall(r"^\| ([SD][\w-]+) \|", text, re.MULTILINE) == wanted
    for name in re.findall(r"`(test_\w+|naive_\w+)\.py`", text):
        assert name in tests, name
    everything = "\n".join(tests.values())
    for name in re.findall(r"`(test_\w+)`", text):
        assert f"def {name}(" in everything, name


def test_every_line_of_source_000_has_a_test_or_a_decision() -> None:
    """Each line of the source is in the table, and each test that the table names is in the file it names."""
    text = text_of(ROOT / "docs" / "sources-000.md").partition("## Line by line")[2].partition("\n## ")[0]
    found: set[int] = set()
    for ids, told in re.findall(r"^\| (S0-[^|]*) \| (.*) \|$", text, re.MULTILINE):
        ends = [int(n) for n in re.findall(r"S0-(\d\d)", ids)]
        found |= set(range(ends[0], ends[-1] + 1)) if ".." in ids else set(ends)
        for path in re.findall(r"tests/[\w/]+\.py", told):
            assert (ROOT / path).is_file(), path
        for file, names in re.findall(r"(\w+): ((?:[a-z0-9]+_\w+(?:, )?)+)", told):
            tests = text_of(named_file(f"test_{file}"))
            for name in names.removesuffix(", ").split(", "):
                assert f"def test_{name}(" in tests, (file, name)
    gaps = {9, *range(24, 30), *range(36, 40), *range(44, 50), *range(55, 60), 68, 69, *range(75, 80)}
    assert found == set(range(1, 95)) - gaps


def test_the_table_of_corrections_names_tests_that_exist() -> None:
    text = text_of(ROOT / "docs" / "sources-004.md")
    lines = (*range(1, 10), *range(20, 36), *range(40, 46), *range(60, 73))
    wanted = [f"S4-{n:02}" for n in lines] + ["D4-1", "D4-2"]
    assert re.findall(r"^\| ([SD][\w-]+) \|", text, re.MULTILINE) == wanted
    tests = text_of(named_file("test_parallel_controllable"))
    for row in re.findall(r"^\| [SD].*$", text, re.MULTILINE):
        for name, ending in re.findall(r"`(test_\w+)(\.py)?`", row):
            assert named_file(name).is_file() if ending else f"def {name}(" in tests, name


def test_the_table_of_segments_names_tests_that_exist() -> None:
    text = text_of(ROOT / "docs" / "sources-003.md")
    wanted = [f"S3-{n:02}" for n in (*range(1, 9), *range(20, 27), *range(30, 34))] + ["D3-1", "D3-2", "D3-3"]
    assert re.findall(r"^\| ([SD][\w-]+) \|", text, re.MULTILINE) == wanted
    usual = "".join(text_of(path) for path in (ROOT / "tests").rglob("test_segment*.py"))
    for row in re.findall(r"^\| [SD].*$", text, re.MULTILINE):
        tests = usual
        for name, ending in re.findall(r"`(test_\w+)(\.py)?`", row):
            if ending:
                tests = text_of(named_file(name))
            else:
                assert f"def {name}(" in tests, name
        assert re.search(r"`test_\w+`|decided|answered|benchmarks", row), row


def test_the_version_is_the_same_everywhere() -> None:
    assert f"\nversion: {ia.__version__}\n" in text_of(ROOT / "CITATION.cff")
    assert f'\nversion = "{ia.__version__}"\n' in text_of(ROOT / "pyproject.toml")
    assert ia.__version__ in text_of(ROOT / "CHANGELOG.md")


UNWANTED = {
    "the path of some machine": re.compile(r"(?<![\w.~*}])/(?:work|home|root|Users|mnt|opt|srv)/"),
    "something left to do": re.compile(r"\b(?:TO" + r"DO|FIX" + r"ME|X" + r"XX)\b"),
    "praise": re.compile(r"\b(?:blazing|revolutionary|cutting-edge|state-of-the-art|stunning|game-changing)\b", re.I),
}


@pytest.mark.parametrize("what", UNWANTED)
def test_nothing_unwanted_is_said(what: str) -> None:
    files = [*DOCUMENTS, ROOT / "Makefile", ROOT / "pyproject.toml", ROOT / "CITATION.cff"]
    for folder in ("src", "tests", "examples", "benchmarks", "docs"):
        files += sorted((ROOT / folder).rglob("*.py"))
    for path in files:
        if path != Path(__file__).resolve():
            found = UNWANTED[what].search(text_of(path))
            assert found is None, f"{path.relative_to(ROOT)}: {found[0] if found else ''}"


EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_examples_run(path: Path, tmp_path: Path) -> None:
    made: Any = load(path).main(160, tmp_path)
    for written in made if isinstance(made, list) else [made]:
        assert written.parent == tmp_path
        assert written.stat().st_size > 0


@pytest.mark.skipif(shutil.which("make") is None, reason="there is no make")
def test_the_environment_of_the_demo_can_start_the_studio(tmp_path: Path) -> None:
    command = ["make", "-n", "demo", f"VENV={tmp_path / 'none'}", f"PYTHON={sys.executable}"]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=True).stdout
    assert "install -e '.[studio]'" in said
