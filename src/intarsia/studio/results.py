"""What is told of a result: its files and what each holds, the command and what it needs, the score once known."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..request.argv import to_line
from ..request.python import to_python
from .store import Row
from .words import MAP, Words, score_words

PUBLIC = (
    "id", "job", "verb", "exemplars", "options", "size", "files", "told", "command", "python", "needs", "made", "score",
)  # fmt: skip


def result_of(name: str, job: Row, words: Words, answer: dict[str, Any], files: Sequence[Path]) -> Row:
    """Return the row of a result: what the command told, without a path."""
    holds = {Path(entry["path"]).name: entry["holds"] for entry in answer.get("files", [])}
    holds.setdefault(MAP, "map")
    entries = [
        {"name": p.name, "holds": holds.get(p.name, "recipe"), "bytes": p.stat().st_size} for p in sorted(files)
    ]
    pictures = [Path(entry["path"]).name for entry in answer.get("files", []) if Path(entry["path"]).name != MAP]
    clean, judged = words.cleaned(answer), bool(pictures) and job["verb"] != "render"
    asked = words.asked(pictures[0] if pictures else "out.png")
    return {
        "id": name, "job": job["id"], "verb": job["verb"], "exemplars": job["exemplars"], "options": job["options"],
        "size": answer.get("size"), "files": entries, "pictures": pictures, "told": clean,
        "command": to_line(asked, joined=True), "python": to_python(asked, clean), "made": time.time(), "score": None,
        "label": job["label"], "began": job["began"],
        "inputs": {own: path for path, own in words.called.items()},
        "score_words": score_words(words, pictures[0]) if judged else None,
    }  # fmt: skip


def told(row: Row) -> Row:
    """What clients are told of a result."""
    address = f"/api/results/{row['id']}"
    files = [entry | {"url": f"{address}/files/{entry['name']}"} for entry in row["files"]]
    return {key: row.get(key) for key in PUBLIC} | {"files": files, "needs": list(row.get("inputs", {}))}
