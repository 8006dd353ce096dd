"""All campaigns one after another: ``make fuzz N=1000``; the exit code says how many of them failed."""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from importlib import import_module

CAMPAIGNS = {"mutants": 1, "documents": 2, "kills": 50, "caches": 50}
"""Name -> which part of the number is tried: a kill takes as long as many pictures."""


def main(argv: list[str] | None = None) -> int:
    """Run every campaign with `--count` pictures of each format, and the others in proportion."""
    parser = ArgumentParser(description=main.__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(argv)
    failed = 0
    for name, part in CAMPAIGNS.items():
        print(f"== {name}", flush=True)
        words = ["--count", str(max(1, given.count // part)), "--seed", str(given.seed)]
        failed += bool(import_module(f"hostile.{name}").main(words))
    return failed


if __name__ == "__main__":
    sys.exit(main())
