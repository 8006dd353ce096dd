"""Tests of the page where there is no browser: left out in one line, or failures where they must be run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROGRAM = """
import sys
from pathlib import Path
sys.path.insert(0, "tests")
import studio.browser as browser
browser.CHROMIUM = Path("/nowhere/chromium")
import pytest
files = ["tests/studio/test_page_shell.py", "tests/studio/test_preparing.py"]
sys.exit(pytest.main(["-q", "-x", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "", *files]))
"""


@pytest.mark.parametrize("required", [False, True])
def test_it_is_told_in_one_line(required: bool) -> None:
    known = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "INTARSIA_BROWSER"))}
    env = known | ({"INTARSIA_BROWSER": "required"} if required else {})
    command = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, env=env, timeout=120)
    assert done.returncode == int(required), done.stdout
    told = [line for line in done.stdout.splitlines() if "chromium" in line and not line.startswith(("E ", "ERROR"))]
    assert required or len(told) == 1
    assert ("error" in done.stdout) == required
