"""Rewrite src/intarsia/tasks/kernels.json: which kernels each command runs, in the order in which it needs them.

    python tools/list_kernels.py           run a command for each method, and all that warms up
    python tools/list_kernels.py --run X   run one of them and print its list: how the above does it
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

SAMPLES = ("stones", "tiles", "brick", "grass", "gravel", "pebbles", "planks")
SAMPLE = {"near-regular": "tiles", "best-tile": "tiles", "repeat": "tiles"}
SMALL = ("efros-leung", "wei-levoy", "ashikhmin")  # slow ones: what they run does not depend on the size


def run(name: str) -> list[str]:
    """Do what belongs to a list, and return the kernels that were asked for."""
    import intarsia as ia
    from intarsia.kernels import compiling
    from intarsia.kernels.cache import KernelCache
    from intarsia.kernels.listed import line_of

    asked: dict[str, None] = {}
    load = KernelCache.load_overload

    def noted(self: Any, sig: Any, context: Any) -> Any:
        if compiling._depth == 1:
            with suppress(ValueError):  # of a type that no line can say
                asked[line_of(self._py_func, sig)] = None
        return load(self, sig, context)

    KernelCache.load_overload = noted  # type: ignore[method-assign]
    if name == "all":
        from intarsia.tasks.tiny_textures import grow_tiny, kinds

        for number in range(len(kinds())):
            grow_tiny(number, ia.Run())
    elif name.startswith("choose "):
        choose(name.removeprefix("choose "))
    else:
        from intarsia.cli import main

        sample = name.removeprefix("grow ") if name.startswith("grow ") else SAMPLE.get(name, "stones")
        words = [] if name.startswith("grow ") else ["-m", name]
        if name in SMALL:
            words += ["--size", "48", "--crop", "0,0,40,40"]
        with tempfile.TemporaryDirectory() as folder:
            sys.argv = ["intarsia", "grow", f"sample:{sample}", "-q", "-o", f"{folder}/o.png", *words]
            try:
                main()
            except SystemExit as end:
                if end.code:
                    raise
    return list(asked)


def choose(sample: str) -> str:
    """Choose a method for a sample; return its name."""
    import intarsia as ia

    exemplar = ia.read(f"sample:{sample}")
    return str(ia.Auto().choose([exemplar], ia.Canvas(2 * exemplar.height, 2 * exemplar.width)).method.slug)


def measured(name: str) -> list[str]:
    """Return a list, made by a process of its own: what was used before is not asked for again."""
    command = [sys.executable, __file__, "--run", name]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    found: list[str] = json.loads(done.stdout.splitlines()[-1])
    return found


def every() -> dict[str, list[str]]:
    """All lists: what every choice needs, what a method needs that was chosen, and that was named; what warms up."""
    from intarsia.methods.base import METHODS

    choices = [measured(f"choose {sample}") for sample in SAMPLES]
    found = {"auto": [line for line in choices[0] if all(line in choice for choice in choices)]}
    for sample in SAMPLES:
        name = f"auto-{choose(sample)}"
        before = found.get(name, [])
        lines = [line for line in measured(f"grow {sample}") if line not in found["auto"]]
        found[name] = [line for line in lines if line not in before] + before  # what few need is compiled last
    return found | {slug: measured(slug) for slug in METHODS} | {"all": measured("all")}


def main_() -> None:
    """Print one list, or write all of them."""
    if sys.argv[1:2] == ["--run"]:
        print(json.dumps(run(sys.argv[2])))
        return
    from intarsia.tasks.ahead import LIST, as_json

    for _ in range(2):  # what is compiled within another kernel is not asked for: all must be on disk before
        found = every()
    LIST.write_text(as_json(found), encoding="utf-8")
    print(f"{Path(LIST).name}: written")


if __name__ == "__main__":
    main_()
