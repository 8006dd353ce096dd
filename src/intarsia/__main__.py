"""``python -m intarsia`` is the command line: ``intarsia grow brick.png -o wall.png``."""

from __future__ import annotations


def main() -> None:
    """Run the command line on ``sys.argv``, and leave with its exit code."""
    import gc

    gc.disable()  # what is imported stays; to look through all of it for garbage takes 40 ms

    import os
    import signal
    import sys
    import warnings

    from .cli import STOPS, cli

    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # of libraries; what a user must know is told in our own words
    try:
        cli.main(prog_name="intarsia")
    except SystemExit as e:
        for number in STOPS:
            signal.signal(number, signal.SIG_IGN)  # all is done: nothing is left to be stopped
        # All is cleaned up, too; taking the libraries down in good order would only take time.
        if e.code == 130 or (e.code in (None, 0) and "numpy" not in sys.modules and _flushed()):
            os._exit(e.code or 0)
        gc.unfreeze()  # or OpenImageIO finds itself still there at the end, and tells of it in 48 lines
        raise


def _flushed() -> bool:
    """Flush the standard streams; False if that failed, so that Python reports it as usual."""
    import sys

    try:
        for stream in filter(None, (sys.stdout, sys.stderr)):
            stream.flush()
    except (OSError, ValueError):
        return False
    return True


if __name__ == "__main__":
    main()
