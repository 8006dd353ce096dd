"""The command line: ``intarsia grow brick.png -o wall.png``. A thin skin over the public functions."""

from __future__ import annotations

__all__ = ["main"]


def main() -> None:
    """Run the command line on ``sys.argv``, and leave with its exit code."""
    import os
    import signal
    import sys
    import warnings

    from .app import cli

    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # of libraries; what a user must know is told in our own words
    try:
        cli.main(prog_name="intarsia")
    except SystemExit as e:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)  # all is done: nothing is left to be stopped
        if e.code == 130:  # and all is cleaned up; taking the libraries down in good order would only take time
            os._exit(130)
        raise
