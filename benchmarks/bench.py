"""Measure speed and memory: CPU time of one thread, as ratios to R, so that machines can be compared.

R is the CPU time of 100 x ``scipy.fft.rfft2`` of a 512 x 512 float32 array with one worker, measured in the same run
right before each repetition. Ratios are medians; kernels are compiled before anything is measured.

    python benchmarks/bench.py                 all cases; prints a table, writes bench/results.json
    python benchmarks/bench.py --only cut      cases whose name holds "cut"
    python benchmarks/bench.py --markdown      the table as the page on speed shows it
"""

from __future__ import annotations

import os

# Before NumPy is imported: process time counts all threads.
os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", MKL_NUM_THREADS="1")
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # commands are timed as users have them: compiled once by Python, too

import argparse
import json
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy.fft

import intarsia as ia

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench" / "results.json"
REPEATS = 5
ONE = ia.Run(threads=1)
IDLE = 0.5  # load average below which wall times mean something


@dataclass
class Result:
    """One line of the table: what was measured, in which unit, and what it should be at most."""

    name: str
    value: float | None
    unit: str
    target: float | None
    note: str = ""
    seconds: float | None = None

    @property
    def met(self) -> bool | None:
        """Whether the target is reached; None without a value or a target."""
        return None if self.value is None or self.target is None else self.value <= self.target


# --- how to measure -------------------------------------------------------------------------------------------------


@cache
def _field() -> Any:
    return np.random.default_rng(0).random((512, 512), dtype=np.float32)


def unit_r() -> float:
    """Return R in seconds of CPU time, as measured now."""
    field = _field()
    begin = time.process_time()
    for _ in range(100):
        scipy.fft.rfft2(field, workers=1)
    return time.process_time() - begin


def in_r(work: Callable[[], object], inner: int, repeats: int = REPEATS) -> tuple[float, float]:
    """Return the median CPU time of `work` in R and in seconds; `inner` calls are one repetition."""
    ratios, seconds = [], []
    for _ in range(repeats):
        r = unit_r()
        begin = time.process_time()
        for _ in range(inner):
            work()
        seconds.append((time.process_time() - begin) / inner)
        ratios.append(seconds[-1] / r)
    return statistics.median(ratios), statistics.median(seconds)


def timed(name: str, target: float | None, work: Callable[[], object]) -> Result:
    """Measure a case in R; short work is repeated until it takes a twentieth of a second."""
    work()
    begin = time.process_time()
    work()
    ratio, seconds = in_r(work, inner=max(1, int(0.05 / max(time.process_time() - begin, 1e-5))))
    return Result(name, ratio, "R", target, f"{1000 * seconds:.3g} ms", seconds)


def peak_bytes() -> int:
    """Return the most memory that this process has held. Linux's own figure is not inherited from the caller."""
    status = Path("/proc/self/status")
    if status.exists():
        return next(int(line.split()[1]) << 10 for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak << 10


def child_cpu(command: list[str], repeats: int = 7) -> float:
    """Return the median CPU time of a command, in seconds."""
    import resource

    seconds = []
    for _ in range(repeats + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return statistics.median(seconds[1:])


# --- what to measure ------------------------------------------------------------------------------------------------


@cache
def pixels(name: str = "stones") -> Any:
    """Return a built-in exemplar as 256 x 256 RGB."""
    found = np.asarray(ia.read(f"sample:{name}").base)[:256, :256]
    return np.ascontiguousarray(np.dstack([found] * 3) if found.ndim == 2 else found[:, :, :3])


@cache
def weave() -> Any:
    """Paint a plain weave, 256 x 256 RGB: a short period, so that very many places are alike."""
    y, x = np.mgrid[:256, :256].astype(np.float64)
    a, b = (-16.14 * x - 15.84 * y) / -519.05, (16.24 * y - 16.22 * x) / -519.05  # whole numbers on the lattice
    over = np.cos(2 * np.pi * (a + b)) * np.cos(2 * np.pi * (a - b))
    rng = np.random.default_rng(1)
    light = 130 + 45 * over + 25 * np.cos(2 * np.pi * a) * np.cos(2 * np.pi * b) + rng.normal(0, 14, (256, 256))
    return np.clip(light[:, :, None] * (1.0, 0.85, 0.6), 0, 255).astype(np.uint8)


def quilting(**parameters: Any) -> Callable[[], object]:
    """Grow and render 1024 x 1024 from 256 x 256, nothing known of the exemplar beforehand."""
    method = ia.ImageQuilting(patch=40, overlap=10, **parameters)
    return lambda: ia.synthesize(pixels(), 1024, method, run=ONE).render(run=ONE)


def case_quilting() -> list[Result]:
    return [timed("image quilting, 1024x1024 from 256x256, patch 40, overlap 10", 3.2, quilting())]


def case_quilting_exact() -> list[Result]:
    return [timed("the same, search at full resolution", 12, quilting(search="exact"))]


def case_quilting_automatic() -> list[Result]:
    def work() -> object:
        return ia.synthesize(pixels(), 1024, ia.ImageQuilting(), run=ONE).render(run=ONE)

    def near() -> object:
        return ia.synthesize(pixels(), 512, ia.ImageQuilting(patch=32), run=ONE)

    return [
        timed("the same, automatic patch and overlap", None, work),
        timed("512x512, patch 32", None, near),
    ]


def case_threads() -> list[Result]:
    """Two threads against one; see ``two_threads.py``."""
    from two_threads import measured  # it imports this module

    return [Result(**vars(r)) for r in measured()]


def case_giant() -> list[Result]:
    found = child("giant")
    case = "image quilting, 4096x4096 from 2048x2048, patch 256"
    return [
        Result(case, found["ratio"], "R", 120, f"{found['seconds']:.3g} s"),
        Result("peak memory of that", found["peak"] / 1e9, "GB", 2.5),
    ]


def child_giant() -> dict[str, float]:
    """Measured in a process of its own, once: what it holds at most is part of the question."""
    exemplar = np.asarray(ia.synthesize(pixels(), 2048, ia.RandomTiling(patch=128), run=ONE).render(run=ONE))
    ia.synthesize(exemplar, 600, ia.ImageQuilting(patch=256), run=ONE).render(run=ONE)  # compiles, or reads the cache
    r = statistics.median(unit_r() for _ in range(3))
    begin = time.process_time()
    ia.synthesize(exemplar, 4096, ia.ImageQuilting(patch=256), run=ONE).render(run=ONE)
    seconds = time.process_time() - begin
    return {"ratio": seconds / r, "seconds": seconds, "peak": peak_bytes()}


def case_rendering() -> list[Result]:
    grown = ia.synthesize(pixels(), 1024, ia.ImageQuilting(patch=40, overlap=10), run=ONE)
    return [
        timed("rendering 1024x1024, feather 28", 5, lambda: grown.render(feather=28, run=ONE)),
        timed("rendering 1024x1024, feather 0 (exact copies)", None, lambda: grown.render(feather=0, run=ONE)),
    ]


def case_cuts() -> list[Result]:
    from intarsia.kernels.cuts import SeamPrice, min_cut, seam_costs
    from intarsia.kernels.maxflow import grid_min_cut

    a, b = pixels()[:, :, :].astype(np.int16), np.roll(pixels(), (37, 91), (0, 1)).astype(np.int16)
    right, down = seam_costs(a, b, SeamPrice())
    out = np.empty((256, 256), np.uint8)
    strip = np.ones((256, 256), np.uint8)
    strip[:, 0], strip[:, -1] = 0, 2
    ring = np.ones((256, 256), np.uint8)
    ring[[0, -1]] = ring[:, [0, -1]] = 0
    ring[96:160, 96:160] = 2
    return [
        timed("minimum cut, strip of 256x256 px", 0.5, lambda: min_cut(strip, right, down, out)),
        timed("the same by maximum flow", 2.6, lambda: grid_min_cut(strip, right, down, out)),
        timed("minimum cut, patch in patch, 256x256 px", 0.8, lambda: min_cut(ring, right, down, out)),
    ]


def case_lattice() -> list[Result]:
    """Lattices of tiles, found anew; the largest exemplar is the others, laid side by side."""
    from intarsia.lattice import lattices_of

    tiles = np.tile(pixels("tiles"), (8, 8, 1))
    return [
        timed(f"lattice of {n}x{n}", target, lambda n=n: lattices_of(ia.Exemplar.of(tiles[:n, :n])))  # type: ignore[misc]
        for n, target in ((128, 5), (256, 15), (2048, 60))
    ]


def case_elements() -> list[Result]:
    from intarsia.analysis import features
    from intarsia.analysis.elements import element_size

    feats = features.features([ia.Exemplar.of(pixels())]).pictures[0]
    return [timed("element size of 256x256", None, lambda: element_size(feats))]


def case_segments() -> list[Result]:
    from intarsia.analysis import features
    from intarsia.segments import find_segments

    feats = features.features([ia.Exemplar.of(pixels())]).pictures[0]
    return [timed("segments of 256x256", 15, lambda: find_segments(feats))]


def case_segment_based() -> list[Result]:
    def work() -> None:
        ia.synthesize(ia.Exemplar.of(pixels()), (512, 512), ia.SegmentBased(), seed=1, run=ONE)

    return [timed("segment-based, 512x512 from 256x256, analysis included", 15, work)]


def case_help() -> list[Result]:
    bare = child_cpu([sys.executable, "-c", "pass"])
    helped = child_cpu([sys.executable, "-m", "intarsia", "--help"])
    target = 3000 * bare + 20
    return [Result("`intarsia --help`, CPU", 1000 * helped, "ms", target, f"`python -c pass`: {1000 * bare:.0f} ms")]


def case_command() -> list[Result]:
    with tempfile.TemporaryDirectory() as folder:
        source, out = f"{folder}/a.png", f"{folder}/b.png"
        ia.write(source, pixels())
        command = ["intarsia", "grow", source, "-o", out, "--force", "--quiet", "--threads", "1"]
        quilting = ["--method", "image-quilting"]
        seconds = child_cpu([sys.executable, "-m", *command, "--size", "512", *quilting], REPEATS)
        r = statistics.median(unit_r() for _ in range(REPEATS))  # a target in seconds supposes 40 ms
        peak = child("peak", *command, "--size", "1024", *quilting)["peak"]
        ia.write(source, pixels("pebbles"), force=True)
        chosen = child_cpu([sys.executable, "-m", *command, "--size", "512"], REPEATS)
        sides = (512, 1024, 2048, 4096)
        taken = [child("peak", *command, "--size", str(side)) for side in sides]
    larger = [
        row for side, found in zip(sides[1:], taken[1:], strict=True) for row in (
            Result(f"the same to {side}x{side}, for each million px, CPU", found["seconds"] / r / (side * side / 1e6),
                   "R", 45, f"{found['seconds']:.3g} s, kernels loaded and the method chosen once"),
            Result("peak memory of that", found["peak"] / 1e6, "MB", 250 + 24 * side * side / 1e6),
        )
    ]  # fmt: skip
    return [
        Result("`intarsia grow -m image-quilting`, 256x256 to 512x512, whole command, CPU", seconds, "s", 1.2,
               f"{seconds / r:.0f} R of {1000 * r:.0f} ms"),
        Result("peak memory of that to 1024x1024", peak / 1e6, "MB", 250 + 24 * 1024**2 / 1e6),
        Result("`intarsia grow`, pebbles, which chooses graphcut, 512x512, whole command, CPU", chosen / r, "R", 26,
               f"{chosen:.3g} s"),
        Result("peak memory of that", taken[0]["peak"] / 1e6, "MB", 250 + 24 * 512**2 / 1e6),
        *larger,
    ]


def case_choice() -> list[Result]:
    """The measurements and the choice; every call sees the exemplar for the first time."""
    results = []
    for name, target in (("tiles", 5), ("stones", 5)):

        def work(name: str = name) -> object:
            return ia.Auto().choose([ia.Exemplar.of(pixels(name))], ia.Canvas(512, 512))

        results.append(timed(f"choosing the method, {name}, 256x256", target, work))

    def large() -> object:
        return ia.Auto().choose([ia.Exemplar.of(np.tile(pixels(), (16, 16, 1)))], ia.Canvas(4096, 4096))

    begin = time.process_time()
    large()
    results.append(Result("choosing the method, 4096x4096, CPU", time.process_time() - begin, "s", 10))
    return results


def case_analyze() -> list[Result]:
    """A lattice that is found, and one that is not, which takes longer."""
    results = []
    with tempfile.TemporaryDirectory() as folder:
        for name in ("tiles", "stones"):
            ia.write(f"{folder}/{name}.png", pixels(name))
            seconds = child_cpu([sys.executable, "-m", "intarsia", "analyze", f"{folder}/{name}.png"], REPEATS)
            results.append(Result(f"`intarsia analyze`, {name}, 256x256, the whole command, CPU", seconds, "s", None))
    return results


def child_peak(*command: str) -> dict[str, float]:
    """Run the command line in this process, and tell the most memory that it held, and its CPU time."""
    from intarsia.__main__ import main

    begin = time.process_time()
    sys.argv = list(command)
    try:
        main()
    except SystemExit as end:
        if end.code:
            raise
    return {"peak": peak_bytes(), "seconds": time.process_time() - begin}


def case_pixels() -> list[Result]:
    """The methods that grow pixel by pixel; the sizes of the published timings of 2003 where there are any."""
    gravel = np.asarray(ia.read("sample:gravel").base.pixels)

    def work(size: int, side: int, method: ia.EfrosLeung | ia.WeiLevoy | ia.Ashikhmin) -> Callable[[], object]:
        return lambda: ia.synthesize(np.ascontiguousarray(gravel[:side, :side]), size, method, run=ONE)

    small = "200x200 from 128x128, window 9x3"
    return [
        timed("Efros-Leung, 128x128 from 64x64, window 11", 25, work(128, 64, ia.EfrosLeung(window=11))),
        timed(f"Wei-Levoy, {small}, exact", 60, work(200, 128, ia.WeiLevoy(window=(3, 9), matching="exact"))),
        timed(f"Wei-Levoy, {small}, tree", 12, work(200, 128, ia.WeiLevoy(window=(3, 9)))),
        timed(f"Ashikhmin, {small}", None, work(200, 128, ia.Ashikhmin(window=(3, 9)))),
    ]


def case_patch_sampling() -> list[Result]:
    """The source's own 25/5; what repeats cost is left out, as it had no price there."""
    method = ia.PatchSampling(patch=25, overlap=5, repetition="none", search="exact")

    def work(side: int, size: int) -> Callable[[], object]:
        exemplar = np.ascontiguousarray(pixels()[:side, :side])
        return lambda: ia.synthesize(exemplar, size, method, run=ONE).render(run=ONE)

    return [
        timed("patch sampling 25/5, 200x200 from 200x200, exact", 2, work(200, 200)),
        timed("patch sampling 25/5, 1024x1024 from 256x256, exact", 12, work(256, 1024)),
    ]


def case_source_000() -> list[Result]:
    """What Multrus 2003 measured, same sizes and parameters; ``source_000.py`` prints it beside the source's times."""
    from source_000 import measured  # it imports this module

    return [Result(**vars(r)) for r in measured()]


def case_first_picture() -> list[Result]:
    """What people wait for: whole commands, with nothing compiled and with all; see ``first_picture.py``."""
    from first_picture import measured  # it imports this module

    return [Result(**vars(r)) for r in measured()]


def case_healing() -> list[Result]:
    hole = np.zeros((256, 256), bool)
    hole[64:192, 64:192] = True

    def work() -> object:
        return ia.heal(pixels(), hole, run=ONE).render(run=ONE)

    return [timed("healing a hole of 128x128 px in 256x256 px", 3, work)]


def case_tileset() -> list[Result]:
    pebbles = pixels("pebbles")
    return [timed("16 tiles of 128x128 px from 256x256", None, lambda: ia.tileset(pebbles, size=128, run=ONE))]


def case_graphcut() -> list[Result]:
    """Large patches of free shape, the worst seams covered anew."""
    small = np.ascontiguousarray(pixels()[:192, :192])

    def work(**parameters: Any) -> Callable[[], object]:
        return lambda: ia.synthesize(small, 512, ia.Graphcut(**parameters), run=ONE).render(run=ONE)

    exemplar = ia.Exemplar.of(pixels("pebbles"))
    chosen = ia.Auto().choose([exemplar], ia.Canvas(512, 512)).method
    return [
        timed("graph cut as `auto` sets it, pebbles, 512x512 from 256x256", 12,
              lambda: ia.synthesize(exemplar, 512, chosen, seed=1, run=ONE).render(run=ONE)),
        timed("graph cut, 512x512 from 192x192", 60, work()),
    ]


def case_repair() -> list[Result]:
    """The worst seams of what image quilting made, looked for four times."""
    made = ia.synthesize(pixels(), 512, run=ONE)
    return [timed("repairing 512x512, 4 passes", 10, lambda: ia.repair(made, 4, run=ONE))]


def case_best_tile() -> list[Result]:
    """The period of the built-in tiles is given, so that the search for it does not count."""
    tiles, method = pixels("tiles"), ia.BestTile(lattice=((64.0, 0.0), (0.0, 64.0)))
    return [timed("best tile, 1024x1024 from 256x256", None, lambda: ia.synthesize(tiles, 1024, method, run=ONE))]


def case_parallel() -> list[Result]:
    """From a ready analysis, rendering included; then the finest level of a map that is known down to it."""
    from intarsia.corrections.coordinate_pyramid import CorrectionParameters, PyramidSynthesis
    from intarsia.corrections.span import Span
    from intarsia.corrections.stack import ComparisonSettings, exemplar_stack
    from intarsia.model.canvas import Canvas

    exemplar, method = ia.Exemplar.of(pixels()), ia.ParallelControllable()
    method = method.resolved((exemplar,), Canvas(1024, 1024))

    large = np.asarray(ia.synthesize(pixels(), 512, ia.ImageQuilting(patch=64), seed=1, run=ONE).render(run=ONE))

    def analysed(picture: Any = None) -> None:
        exemplar_stack(ia.Exemplar.of(pixels() if picture is None else picture), ComparisonSettings.of(method))

    descent = PyramidSynthesis(
        exemplar_stack(exemplar, ComparisonSettings.of(method)), CorrectionParameters.of(method), 1
    )
    spans = descent._spans(Span(0, 1024, 0), Span(0, 1024, 0))
    coords = descent._first(spans, None)
    for level in range(len(spans) - 1, 0, -1):
        if level < len(spans) - 1:
            coords = descent._upsampled(coords, level, spans, None)
        if level < descent._corrected_levels:
            coords = descent._corrected(coords, level, spans[level], ONE)
        elif edge := descent._margin(level):
            coords = coords[edge:-edge, edge:-edge]
    finest = descent._upsampled(coords, 0, spans, None)
    box = ia.Box(10**6, -(10**6), 10**6 + 64, 64 - 10**6)
    return [
        timed("parallel-controllable, 1024x1024 from a ready analysis", 7,
              lambda: ia.synthesize(exemplar, 1024, method, seed=1, run=ONE).render(run=ONE)),
        timed("the same, turned by 30 degrees", 14,
              lambda: ia.synthesize(exemplar, 1024, replace(method, angle=30), seed=1, run=ONE).render(run=ONE)),
        timed("its finest level alone", 3.5, lambda: descent._corrected(finest, 0, spans[0], ONE)),
        timed("a window of 64x64 px of it", 0.4, lambda: method.window((exemplar,), box, 1, ONE)),
        timed("its analysis of 256x256", 6, analysed),
        timed("its analysis of 512x512", 24, lambda: analysed(large)),
    ]


def case_near_regular() -> list[Result]:
    """Both ways to lay blocks on one lattice, known beforehand, and without one."""

    def work(picture: Any = None, kind: Any = ia.NearRegular, **parameters: Any) -> Callable[[], object]:
        given: dict[str, Any] = {"lattice": ((64.22, -0.14), (0.07, 63.82))} | parameters
        method, exemplar = kind(**given), pixels("tiles") if picture is None else picture
        return lambda: ia.synthesize(exemplar, 1024, method, run=ONE).render(run=ONE)

    plain = ia.GapFilling
    anywhere, short = ((1.0, 0.0), (0.0, 1.0)), ((16.24, 16.22), (15.84, -16.14))
    return [
        timed("near-regular, 1024x1024 from 256x256, lattice known", 20, work()),
        timed("gap-filling, the same, blocks of 40", 6, work(kind=plain)),
        timed("the same, a weave with a period of 16 px", 20, work(weave(), lattice=short)),
        timed("gap-filling, the weave, blocks of 40", 6, work(weave(), plain, lattice=short)),
        timed("gap-filling, by correlation", None, work(kind=plain, fit="correlation")),
        timed("gap-filling, lattice 1,0 0,1", None, work(kind=plain, lattice=anywhere)),
        timed("near-regular, lattice 1,0 0,1", None, work(lattice=anywhere)),
    ]


def case_weaving() -> list[Result]:
    """Endless textures by near-regular: a window somewhere, and a picture that is streamed by two threads."""
    texture, places = tiles_without_end(), iter(range(1, 1 << 30))

    def window() -> object:
        y = 5000 * next(places)  # never the same twice
        return texture[y : y + 64, -y : 64 - y]

    found = child("weaving")
    return [
        timed("a window of 64x64, near-regular, anywhere", 0.4, window),
        Result("weaving 4096x4096 to zarr, two threads, CPU", found["ratio"], "R", None, f"{found['seconds']:.3g} s"),
        Result("peak memory of that", found["peak"] / 1e9, "GB", 1),
    ]


def child_weaving() -> dict[str, float]:
    """Measured in a process of its own: what it holds at most is part of the question."""
    texture = tiles_without_end()
    with tempfile.TemporaryDirectory() as folder:
        texture.to_zarr(Path(folder) / "first", 300, run=ONE)  # compiles, or reads the cache
        r = statistics.median(unit_r() for _ in range(3))
        begin = time.process_time()
        texture.to_zarr(Path(folder) / "whole", 4096, run=ia.Run(2))
        seconds = time.process_time() - begin
    return {"ratio": seconds / r, "seconds": seconds, "peak": peak_bytes()}


def tiles_without_end() -> Any:
    """The built-in tiles by near-regular, their lattice known."""
    return ia.weave(pixels("tiles"), ia.NearRegular(lattice=((64.22, -0.14), (0.07, 63.82))), 1)


CASES: dict[str, Callable[[], list[Result]]] = {
    "first-picture": case_first_picture,
    "command": case_command,
    "quilting": case_quilting,
    "quilting-exact": case_quilting_exact,
    "quilting-automatic": case_quilting_automatic,
    "threads": case_threads,
    "giant": case_giant,
    "rendering": case_rendering,
    "cuts": case_cuts,
    "lattice": case_lattice,
    "elements": case_elements,
    "segments": case_segments,
    "segment-based": case_segment_based,
    "patch-sampling": case_patch_sampling,
    "source-000": case_source_000,
    "healing": case_healing,
    "tileset": case_tileset,
    "pixels": case_pixels,
    "best-tile": case_best_tile,
    "near-regular": case_near_regular,
    "parallel": case_parallel,
    "weaving": case_weaving,
    "graphcut": case_graphcut,
    "repair": case_repair,
    "help": case_help,
    "choice": case_choice,
    "analyze": case_analyze,
}
CHILDREN: dict[str, Callable[..., dict[str, float]]] = {
    "giant": child_giant,
    "peak": child_peak,
    "weaving": child_weaving,
}


def child(name: str, *arguments: str) -> dict[str, float]:
    """Run one of CHILDREN in a process of its own."""
    command = [sys.executable, __file__, "--child", name, *arguments]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


# --- what to say ----------------------------------------------------------------------------------------------------


def shown(value: float | None, unit: str) -> str:
    """Write a value with three digits and its unit."""
    if value is None:
        return "not measured"
    digits = f"{value:.0f}" if value >= 100 else f"{value:.3g}"
    return f"{digits} {unit}"


def table(results: list[Result]) -> str:
    """Return the results as plain lines."""
    wide = max(len(r.name) for r in results)
    lines = []
    for r in results:
        verdict = {True: "ok", False: "MISSED", None: ""}[r.met]
        target = "" if r.target is None else f"at most {shown(r.target, r.unit)}"
        lines.append(f"{r.name:{wide}}  {shown(r.value, r.unit):>14}  {target:<18} {verdict:7}{r.note}".rstrip())
    return "\n".join(lines)


def markdown(results: list[Result]) -> str:
    """Return the results as the page on speed shows them."""
    lines = ["| case | measured | target | |", "|:---|:---|:---|:---|"]
    for r in results:
        if r.name.startswith("Multrus 2003"):  # docs/sources-000.md shows these
            continue
        target = "" if r.target is None else f"≤ {shown(r.target, r.unit)}" + (" (missed)" if r.met is False else "")
        lines.append(f"| {r.name} | {shown(r.value, r.unit)} | {target} | {r.note} |")
    return "\n".join(lines)


def machine() -> dict[str, Any]:
    """Say what was measured on, without naming the machine."""
    return {
        "intarsia": ia.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "system": platform.system(),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
    }


def measure(only: str = "") -> list[Result]:
    """Run the cases whose name holds `only`."""
    found = {}
    for name in sorted(CASES, key=lambda name: name != "threads"):  # threads first: the machine may still be idle
        if only in name:
            print(f"measuring {name} ...", file=sys.stderr)
            found[name] = CASES[name]()
    return [result for name in CASES for result in found.get(name, [])]


def main() -> None:
    """Measure, print, and keep the results."""
    if sys.argv[1:2] == ["--child"]:
        print(json.dumps(CHILDREN[sys.argv[2]](*sys.argv[3:])))
        return
    parser = argparse.ArgumentParser(description="Measure speed and memory in ratios to R.")
    parser.add_argument("--only", default="", metavar="WORD", help="cases whose name holds this word")
    parser.add_argument("--markdown", action="store_true", help="print the table as the page on speed shows it")
    parser.add_argument("--again", action="store_true", help="print the kept results, measure nothing")
    given = parser.parse_args()
    if given.again:
        results = [Result(**r) for r in json.loads(RESULTS.read_text())["results"]]
    else:
        about = machine()
        results = measure(given.only)
        about["r_ms"] = 1000 * statistics.median(unit_r() for _ in range(5))
        RESULTS.parent.mkdir(exist_ok=True)
        RESULTS.write_text(json.dumps({"machine": about, "results": [asdict(r) for r in results]}, indent=2) + "\n")
    print((markdown if given.markdown else table)(results))


if __name__ == "__main__":
    main()
