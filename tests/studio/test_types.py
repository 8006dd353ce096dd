"""The page's JavaScript is checked as TypeScript checks it, strictly, by the types of its JSDoc comments."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

import intarsia.studio

JS = Path(intarsia.studio.__file__).parent / "static" / "js"
TYPES = Path(__file__).parent / "types"


def checked(settings: Path) -> list[str]:
    """What the checker says; where there is none the test is left out, or fails if INTARSIA_BROWSER=required."""
    checker = shutil.which("tsc")
    if checker is None:
        line = "no tsc (Debian's node-typescript): the types of the page are not checked"
        if os.environ.get("INTARSIA_BROWSER") == "required":
            pytest.fail(line)
        pytest.skip(line)
    words = [checker, "-p", str(settings), "--pretty", "false"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    return (done.stdout + done.stderr).splitlines()


def test_the_types_of_the_page_are_right() -> None:
    assert checked(TYPES / "tsconfig.json") == []


def test_a_wrong_type_is_found(tmp_path: Path) -> None:
    shutil.copytree(JS, tmp_path / "js")
    shutil.copy(TYPES / "newer.d.ts", tmp_path)
    settings = json.loads((TYPES / "tsconfig.json").read_text())
    settings["include"] = ["newer.d.ts", "js/stage/view.js"]
    (tmp_path / "tsconfig.json").write_text(json.dumps(settings))
    view = tmp_path / "js" / "stage" / "view.js"
    view.write_text(view.read_text().replace("this.x += dx;", "this.x += String(dx);"))
    said = checked(tmp_path / "tsconfig.json")
    assert len(said) == 1
    assert "js/stage/view.js" in said[0]
    assert "TS2322" in said[0]


def test_nothing_is_kept_from_the_checker() -> None:
    files = sorted(JS.rglob("*.js"))
    assert len(files) > 40
    for path in files:
        assert re.search(r"@ts-(ignore|nocheck|expect-error)", path.read_text("utf-8")) is None, path
