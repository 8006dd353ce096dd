"""What the site changes: the README is its home, what is beside the pages is not linked, names have a reference."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import intarsia

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)\s]+)\)")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Return the text of a page as the site shows it."""
    if page.file.src_uri == "index.md":
        readme = (ROOT / "README.md").read_text(encoding="utf-8").replace("](docs/", "](")
        markdown = readme.replace("](index.md#", "](#") + "\n\n" + markdown.partition("\n")[2]
    if page.file.src_uri == "reference.md":
        every = sorted(intarsia._HOMES.items(), key=lambda one: (one[0][0].isupper(), one[0]))
        for name, home in every:  # a file may be called like what is in it
            file = ROOT / "src" / "intarsia" / home.replace(".", "/") / f"{name}.py"
            markdown += f"\n::: intarsia.{home}.{name}{f'.{name}' if file.is_file() else ''}\n"
    folder = Path(page.file.src_uri).parent

    def shown(link: re.Match[str]) -> str:
        """A link, or its text alone where it leads to a file beside the documentation."""
        place = link[2].partition("#")[0]
        if "://" in place or not place:
            return link[0]
        target = (ROOT / "docs" / folder / place).resolve()
        inside = target.is_relative_to(ROOT / "docs") and target.is_file()
        return link[0] if inside and target.suffix != ".py" else link[1]

    return LINK.sub(shown, markdown)
