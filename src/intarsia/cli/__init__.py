"""The command line: ``intarsia grow brick.png -o wall.png``. A thin skin over the public functions."""

from __future__ import annotations

__all__ = ["main"]


def main() -> None:
    """Run the command line on ``sys.argv``, and leave with its exit code."""
    import sys
    import warnings

    from .app import cli

    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # of libraries; what a user must know is told in our own words
    cli.main(prog_name="intarsia")
