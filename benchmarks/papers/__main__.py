"""``python -m benchmarks.papers 000 -o out/``: reproduce the figures of a document from an exemplar."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence
from pathlib import Path

import intarsia as ia
from intarsia.foundation import legible
from intarsia.methods import PRESETS

from .figures import write

DOCUMENTS = {f"{number:03}": document for number, document in enumerate(PRESETS)}
"""Number of a document -> its package, which is a module here with TITLE and FIGURES."""


def main(words: Sequence[str] | None = None) -> Path:
    """Reproduce all figures of a document (or of all), or those named; return the path of the last page written."""
    told = argparse.ArgumentParser(prog="python -m benchmarks.papers", description=__doc__)
    told.add_argument("document", choices=[*DOCUMENTS, "all"])
    told.add_argument("-o", "--output", type=Path, required=True, help="the folder to write; of all, one in it each")
    told.add_argument("--exemplar", help="a picture; by default built-in ones that suit the figures")
    told.add_argument("--only", action="append", metavar="NUMBER", help="a figure, such as 3.6; may be repeated")
    asked = told.parse_args(words)
    every = asked.document == "all"
    for document in DOCUMENTS if every else [asked.document]:
        made = importlib.import_module(f".{DOCUMENTS[document]}", __package__)
        known = {figure.number: figure for figure in made.FIGURES}
        for number in asked.only or ():
            if number not in known:
                told.error(f"figure {number} is not there; give one of {', '.join(known)}")
        exemplar = None if asked.exemplar is None else ia.read(asked.exemplar)
        out = asked.output / document if every else asked.output
        page = write(made.TITLE, [known[n] for n in asked.only or known], exemplar, out)
        print(page)
    return page


if __name__ == "__main__":
    try:
        main()
    except (ia.IntarsiaError, OSError) as e:
        print(f"intarsia: {legible(str(e))}", file=sys.stderr)
        sys.exit(getattr(e, "exit_code", 1))
