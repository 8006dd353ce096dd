"""Make the pictures of the documentation from built-in exemplars: ``python docs/make_pictures.py [NAME...]``.

Without names, make all. The pixels are the same on every machine, but for the letters in the picture of reports; the
bytes of the JPEG files depend on the version of Pillow. Pictures of the studio: ``make_studio_pictures.py``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from scipy.ndimage import distance_transform_edt, gaussian_filter, zoom
from skimage import data
from skimage.transform import ProjectiveTransform, warp

import intarsia as ia
from intarsia.tasks.drawings import pictures_of, segment_overlay
from intarsia.tasks.scoring import Outcome

FOLDER = Path(__file__).resolve().parent / "images"
sys.path.append(str(FOLDER.parents[1]))

from benchmarks.papers.multrus2003 import maps  # noqa: E402 (found from the root)

GAP = 16  # px between pictures
WHITE = 255
PART = 160  # px of an exemplar, as the README shows it
SMALL = 192  # px of an exemplar that has more to it
SHOWN = 320  # px of what is grown for the README
PAINTED = 300  # px of what is painted

# Exemplars


def rgb(picture: Any) -> np.ndarray:
    """Return 8-bit pixels as (H, W, 3)."""
    pixels = np.atleast_3d(np.asarray(picture))
    return np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels[:, :, :3]


def base(name: str) -> np.ndarray:
    """Return a built-in exemplar with the channels that it has."""
    return np.asarray(ia.read(f"sample:{name}").base)


def sample(name: str, high: int | None = None, wide: int | None = None) -> np.ndarray:
    """Return a built-in exemplar as (H, W, 3), or its upper left part, a square by one number."""
    return rgb(base(name))[:high, : wide or high].copy()


def lit(pixels: np.ndarray, left: float, right: float) -> np.ndarray:
    """Multiply pixels by a slope of light from left to right."""
    slope = np.linspace(left, right, pixels.shape[1])[:, None]
    return np.clip(pixels * slope, 0, WHITE).astype(np.uint8)


# Layouts


def grown(exemplar: Any, size: Any, method: Any = "auto", seed: int = 1, **more: Any) -> ia.Synthesis:
    """Grow an exemplar; a name is that of a built-in one."""
    exemplar = f"sample:{exemplar}" if isinstance(exemplar, str) else exemplar
    return ia.synthesize(exemplar, size, method, seed=seed, **more)


def beside(*pictures: Any, gap: int = GAP, top: bool = False) -> np.ndarray:
    """Put pictures side by side on white, centred or at the top."""
    shown = [rgb(picture) for picture in pictures]
    height = max(p.shape[0] for p in shown)
    out = np.full((height, sum(p.shape[1] + gap for p in shown) - gap, 3), WHITE, np.uint8)
    x = 0
    for p in shown:
        y = 0 if top else (height - p.shape[0]) // 2
        out[y : y + p.shape[0], x : x + p.shape[1]] = p
        x += p.shape[1] + gap
    return out


def rows(*pictures: np.ndarray) -> np.ndarray:
    """Put pictures above one another."""
    return beside(*(p.swapaxes(0, 1) for p in pictures)).swapaxes(0, 1)


def panels(exemplar: Any, size: Any, *methods: Any, **more: Any) -> np.ndarray:
    """Show what grows from one exemplar by several methods."""
    return beside(*(grown(exemplar, size, method, **more) for method in methods))


def pair(exemplar: Any, size: Any, *methods: Any, **more: Any) -> np.ndarray:
    """Show an exemplar, and what grows from it by one or several methods."""
    first = sample(exemplar) if isinstance(exemplar, str) else exemplar
    return beside(first, panels(exemplar, size, *methods or ("auto",), **more))


# Maps and blending


def map_of() -> np.ndarray:
    """Show a picture, its pieces, and its coordinates as colours."""
    made = grown("stones", SHOWN)
    mixed = (made.map.pieces().astype(np.uint32) + 1) * np.uint32(0x9E3779B1)
    mixed ^= mixed >> np.uint32(15)
    colours = np.stack([(mixed >> np.uint32(s)) & np.uint32(127) for s in (3, 11, 19)], axis=2).astype(np.uint8) + 96
    where = np.dstack([made.map.yx[:, :, ::-1], np.full((SHOWN, SHOWN), 96)]).astype(np.uint8)  # 0 to 255 each
    return beside(made, colours, where)


def feathers() -> np.ndarray:
    """Show one map drawn with feathers of 0, 8 and 32 px."""
    made = grown("gravel", 320, ia.RandomTiling(patch=80))
    return beside(*(made.render(feather=f) for f in (0, 8, 32)))


def levelled() -> np.ndarray:
    """Show a wall lit from one side, and what grows from it, as it is and levelled."""
    exemplar = lit(base("planks"), 0.6, 1.2)[:256, :256]
    made = grown(exemplar, (256, 400), ia.ImageQuilting(), seed=5)
    return beside(exemplar, made, made.render(finish=(ia.Levelling(96),)))


def repaired() -> np.ndarray:
    """Show a wall, and the same wall with its worst seams covered anew."""
    made = grown("stones", (336, 432), ia.PatchSampling(), seed=3)
    return beside(made, ia.repair(made))


# Extending, healing, tiling


def extended() -> np.ndarray:
    """Show a part of an exemplar, and the same part continued on all sides."""
    part = sample("stones", 192)
    return beside(part, ia.extend(part, ia.Margins(100, 100, 100, 100), seed=2))


def healed() -> np.ndarray:
    """Show an exemplar without a disc, a scratch and lost blocks, and healed."""
    y, x = np.mgrid[:256, :256]
    hole = (y - 124) ** 2 + (x - 150) ** 2 < 30**2
    hole |= abs(y - 0.55 * x - 60) < 3
    for row, column in ((24, 32), (64, 72), (184, 64), (208, 200), (152, 216), (16, 120)):
        hole[row : row + 16, column : column + 16] = True
    part = sample("stones", 256)
    part[hole] = (255, 0, 255)
    return beside(part, ia.heal(part, hole))


def tiled() -> np.ndarray:
    """Show parts of two exemplars, as they are and tiled, shifted by half their size: borders meet in the middle."""
    parts = [sample(name, 210, 240) for name in ("gravel", "stones")]
    return rows(*(beside(*(np.roll(rgb(p), (105, 120), (0, 1)) for p in (part, ia.tile(part)))) for part in parts))


def tileset() -> np.ndarray:
    """Show an exemplar, the atlas of sixteen tiles, and a field of them, at half size."""
    made = ia.tileset("sample:pebbles", seed=2)
    whole = beside(sample("pebbles"), made.render(), made.laid(made.rule.field(4, 5, seed=1)), gap=2 * GAP)
    return np.asarray(Image.fromarray(whole).reduce(2))


# Patches and segments


def segments() -> np.ndarray:
    """Show two exemplars as they are, and with their groups of segments."""
    names = "stones", "pebbles"
    return beside(*(p for n in names for p in (sample(n), segment_overlay(ia.read(f"sample:{n}")))))


def joins() -> np.ndarray:
    """Show the same map with hard cuts, feathered seams, and cut along the cheapest seam."""
    methods = (ia.PatchSampling(patch=25, overlap=7, join=join) for join in ("middle", "feather", "cut"))
    return panels("stones", 256, *methods, seed=2)


def searches() -> np.ndarray:
    """Show tiles by the full search, and by the pyramid with 1 place kept and with 8."""
    by_pyramid = (ia.PatchSampling(patch=40, overlap=8, pyramid="mean", pyramid_kept=kept) for kept in (1, 8))
    return panels("tiles", 256, ia.PatchSampling(patch=40, overlap=8, search="exact"), *by_pyramid)


def isometries() -> np.ndarray:
    """Show pebbles lit from one side: all isometries, and those that `auto` allows."""
    return panels("pebbles", 256, *(ia.PatchSampling(patch=30, overlap=6, isometries=k) for k in ("both", "auto")))


def distances() -> np.ndarray:
    """Show an exemplar, and how well each of its patches fits at one place of the output; dark is near."""
    _, far = maps(ia.Exemplar.of(sample("planks")), (0,))
    return beside(sample("planks", 150), far.picture.pixels)


# Graph cuts


def graphcut() -> np.ndarray:
    """Show an exemplar, what grows from it, and its pieces in colours: one shift, one colour."""
    exemplar = sample("pebbles", 256)
    made = grown(exemplar, (384, 448), ia.Graphcut())
    away = (made.map.yx - np.moveaxis(np.indices(made.map.yx.shape[:2]), 0, 2)).astype(np.int64)
    mixed = (away[:, :, 0] * 7919 + away[:, :, 1] * 104729) % 16777213
    tint = np.stack([mixed % 241, mixed // 241 % 239, mixed // 57599 % 233], axis=2)
    return beside(exemplar, made, (2 * rgb(made).astype(np.int64) + 3 * tint) // 5)


def usage() -> np.ndarray:
    """Show an exemplar, and for two prices of showing pixels again what is shown and what is grown.

    What is shown is gray: four times, which is due, in the middle; twelve times or more is white.
    """
    exemplar = sample("pebbles", 200)
    shown: list[Any] = [exemplar]
    for price in (0, 0.2):
        made = grown(exemplar, 400, ia.Graphcut(evenness=price), seed=3)
        shown += [np.interp(made.map.usage()[0], (0, 4, 12), (0, 128, 255)), made.render(feather=0)]
    return beside(*shown, top=True)


def reported() -> np.ndarray:
    """Show the pictures of reports: of pebbles grown well, and of pebbles in small squares laid without looking."""

    def panel(pixels: np.ndarray) -> np.ndarray:
        picture = Image.fromarray(pixels)
        picture.thumbnail((256, 256), Image.Resampling.BOX)
        paper = Image.new("RGB", (268, 268), (250, 250, 248))
        paper.paste(picture, (6, 6))
        return np.asarray(paper)

    made = [grown("pebbles", 256, method, wrap="both") for method in (ia.Graphcut(), ia.RandomTiling(patch=16))]
    return np.concatenate([np.hstack([panel(one.pixels) for one in pictures_of(Outcome.of(each))]) for each in made])


# Near-regular textures


def analyzed() -> np.ndarray:
    """Show an exemplar under its lattice, and its best tile, four times."""
    found = ia.analyze("sample:tiles")
    return beside(found.overlay(), np.tile(rgb(found.best_tile().planes["albedo"]), (2, 2, 1)))


# Pixel by pixel, and under control


def jittered() -> np.ndarray:
    """Show an exemplar, and what grows from it with less and with more jitter."""
    methods = (ia.ParallelControllable(jitter=jitter) for jitter in (0, None))
    return pair(sample("pebbles", 192), (384, 448), *methods, seed=4)


def controlled() -> np.ndarray:
    """Show jitter that begins at a third and grows to the right; below, without and with the outlines of a mask."""
    tiles = sample("tiles")
    wide, half = (256, 2 * 384 + GAP), (256, 384)
    ramp = np.linspace(-0.5, 1, wide[1])[None].repeat(wide[0], axis=0).clip(0)
    jitter = ia.ParallelControllable(jitter=(0, 0, 0.4), jitter_output=ia.Field(ramp), keep_lattice="off")
    glazed = tiles[:, :, 2].astype(int) > tiles[:, :, 0]  # the grout is pale and warm
    masked = (ia.ParallelControllable(feature=mask, keep_lattice="off") for mask in (None, ia.Field(glazed)))
    across = rgb(grown(ia.Exemplar.of(tiles, toroidal=True), wide, jitter, seed=4))
    return rows(across, panels(tiles, half, *masked, seed=4))


def turned() -> np.ndarray:
    """Show bricks around a point, planks turned by place, pebbles growing from half the size to twice the size."""
    around = ia.Field(lambda y, x: np.degrees(np.arctan2(192 - y, x - 192)))
    slope = ia.Field(np.linspace(-60, 60, 384)[:, None] * np.ones(384))
    growing = ia.Field(lambda y, x: 0.5 + 1.5 * x / 384 + 0 * y)
    controls = {"brick": {"angle": around}, "planks": {"angle": slope}, "pebbles": {"angle": 20.0, "zoom": growing}}
    return beside(*(grown(name, 384, ia.ParallelControllable(**how), seed=4) for name, how in controls.items()))


def magnified() -> np.ndarray:
    """Show pebbles; grown at full size; at a quarter of it, each map pixel drawn as a square; and blended."""
    exemplar = ia.read("sample:pebbles")
    whole = grown(exemplar, 448, ia.ParallelControllable(), seed=5)
    small = grown(ia.magnified(exemplar, 4), 448 // 4, ia.ParallelControllable(), seed=5)
    return beside(exemplar.base, whole, small.render(feather=0), small, top=True)


def flowing() -> np.ndarray:
    """Show frames 0, 1, 25 and 50 of pebbles in a channel, fastest in the middle."""

    def current(y: Any, x: Any) -> tuple[Any, Any]:
        return 0 * y, 3 * np.sin(np.pi * (y + 0.5) / 256) ** 2

    made = [grown("pebbles", 256, ia.ParallelControllable(), seed=3, wrap="both")]
    for frame in range(1, 51):
        made.append(ia.advect(made[-1], current, frame=frame))
    return beside(*(made[n] for n in (0, 1, 25, 50)))


# Painting


def coloured(marks: np.ndarray) -> np.ndarray:
    """Return labels as colours."""
    return np.array([(230, 200, 120), (60, 90, 160), (150, 60, 60)], np.uint8)[marks]


def labels(marks: np.ndarray) -> ia.Plane:
    """Return numbers as a plane of labels."""
    return ia.Plane(marks, ia.Kind.LABEL)


def path_and_lawn() -> tuple[np.ndarray, np.ndarray]:
    """Return an exemplar with two regions, gravel in grass with a dark rim, and its labels."""
    y, x = np.mgrid[:PAINTED, :PAINTED]
    inside = np.sin(x / 23 + 1) * 22 + np.sin(y / 31) * 24 + 0.35 * x - 0.2 * y > 20
    shade = np.clip(distance_transform_edt(inside) / 5, 0.3, 1)[:, :, None]
    path = np.clip(sample("gravel", PAINTED) * (1.1, 1.0, 0.85), 0, WHITE) * shade
    lawn = np.clip(sample("grass", PAINTED) * (0.8, 1.15, 0.5), 0, WHITE)
    return np.where(inside[:, :, None], path, lawn).astype(np.uint8), inside.astype(np.uint8)


def ring() -> np.ndarray:
    """Show one exemplar, its labels, a target, and what is painted."""
    pixels, marks = path_and_lawn()
    y, x = np.mgrid[:PAINTED, :PAINTED] - PAINTED / 2
    r = np.hypot(y, x) + 8 * np.sin(3 * np.arctan2(y, x))
    target = ((r > 60) & (r < 115)).astype(np.uint8)
    made = grown(pixels, None, seed=2, guide=ia.Guide(labels(marks), labels(target)))
    return beside(pixels, coloured(marks), coloured(target), made, gap=12)


def three() -> np.ndarray:
    """Show three exemplars of one label each: they never meet, so they are cut at the boundary."""
    y, x = np.mgrid[:PAINTED, : PAINTED * 3 // 2]
    target = np.zeros(y.shape, np.uint8)
    target[y > 120 + 25 * np.sin(x / 50)] = 1
    target[y > 210 + 18 * np.sin(x / 35 + 2)] = 2
    exemplars = [ia.read(f"sample:{n}") for n in ("pebbles", "planks", "stones")]
    sources = [labels(np.full((e.height, e.width), k, np.uint8)) for k, e in enumerate(exemplars)]
    return beside(coloured(target), grown(exemplars, None, seed=2, guide=ia.Guide(sources, labels(target))), gap=12)


def strokes() -> tuple[np.ndarray, ia.Synthesis]:
    """Return strokes of 6 to 20 px, and the same in the exemplar of the ring, pixel by pixel."""
    pixels, marks = path_and_lawn()
    y, x = np.mgrid[:PAINTED, :PAINTED]
    target = np.zeros((PAINTED, PAINTED), np.uint8)
    for k, width in enumerate((6, 10, 14, 20)):
        target[abs(y - 45 - 70 * k - 14 * np.sin(x / 30 + k)) < width / 2] = 1
    guide = ia.Guide(labels(marks), labels(target))
    return coloured(target), grown(pixels, None, ia.ParallelControllable(), seed=2, guide=guide)


def portrait() -> tuple[np.ndarray, ia.Synthesis]:
    """Return a photograph of scikit-image, and the same in pebbles, pixel by pixel."""
    pebbles = sample("pebbles")
    tones = gaussian_filter(pebbles @ [0.299, 0.587, 0.114], 2)
    picture = np.asarray(Image.fromarray(data.camera()[20:340, 80:400]).resize((PAINTED, PAINTED)))
    ranks = np.argsort(np.argsort(picture.astype(float), axis=None)).reshape(picture.shape) / picture.size
    source, target = (ia.Plane(p.astype(np.uint8)) for p in (tones, np.quantile(tones, ranks)))
    guide = ia.Guide(source, target, 3.0)
    return picture, grown(pebbles, None, ia.ParallelControllable(), seed=2, guide=guide)


# The README


def gallery_tile() -> np.ndarray:
    """Show a photograph that tiles afterwards, four times."""
    part = sample("gravel", PART)
    return beside(part, np.tile(rgb(ia.tile(part, seed=1)), (2, 2, 1))[:SHOWN, :SHOWN])


def gallery_material() -> np.ndarray:
    """Show albedo, normal, roughness and height, grown together."""
    made = grown("setts", SHOWN)
    every = [np.asarray(made.render(name))[:PART, :PART] for name in made.exemplars[0].planes]
    seen = [rgb((p >> 8).astype(np.uint8) if p.dtype == np.uint16 else p) for p in every]
    return beside(sample("setts", PART), np.vstack([np.hstack(seen[:2]), np.hstack(seen[2:])]))


def packed() -> np.ndarray:
    """Show packed pebbles, twice as large as they grow: some are cut or fused."""
    made = rgb(grown(sample("pebbles", SMALL), 256))[40:200, 60:220]
    return beside(sample("pebbles", PART), zoom(made, (2, 2, 1), order=1))


def slanted() -> np.ndarray:
    """Show a wall seen from the side."""
    corners = [[0, 0], [191, 70], [191, 150], [0, 191]], [[0, 0], [511, 0], [511, 511], [0, 511]]
    far = ProjectiveTransform.from_estimate(*map(np.array, corners))
    seen = warp(data.brick() / 255.0, far, output_shape=(SMALL, SMALL), mode="wrap")
    return pair(rgb((seen * 255).astype(np.uint8)), SHOWN)


def part_of(photograph: np.ndarray, y: int, x: int, side: int) -> np.ndarray:
    """Return a square of a photograph."""
    return np.ascontiguousarray(photograph[y : y + side, x : x + side])


# All pictures

PICTURES: dict[str, Callable[[], np.ndarray]] = {
    "hero": lambda: pair("tiles", (512, 768), seed=3),
    "photographs": lambda: beside(*(grown(name, 320, "image-quilting") for name in ("brick", "grass", "gravel"))),
    # Patches of one size, at random and chosen; too small, as chosen, large; without and with a price on using again
    "baseline": lambda: panels("stones", 400, ia.RandomTiling(patch=72), ia.ImageQuilting(patch=72), seed=3),
    "patches": lambda: panels("stones", 320, *(ia.ImageQuilting(patch=patch) for patch in (16, None, 128)), seed=2),
    "repetition": lambda: panels("planks", 480, *(ia.ImageQuilting(repeat_penalty=u) for u in (0.0, 0.2)), seed=4),
    "map": map_of,
    "feathers": feathers,
    # An exemplar that tiles, and a photograph that does not
    "repeat": lambda: beside(grown("tiles", (320, 512), "repeat"), rgb(grown("brick", (320, 640), "repeat"))[:, 400:]),
    # Three methods that go pixel by pixel; windows too small, and large enough for a brick
    "pixels": lambda: pair(
        base("gravel")[:128, :128], 192, ia.EfrosLeung(window=15), ia.WeiLevoy(), ia.Ashikhmin(), wrap="both"
    ),
    "windows": lambda: pair(base("brick")[::4, ::4], 192, *(ia.EfrosLeung(window=n) for n in (5, 11, 23)), seed=2),
    "levelled": levelled,
    "repaired": repaired,
    "extended": extended,
    "healed": healed,
    "tiled": tiled,
    "tileset": tileset,
    "segments": segments,
    "segment-based": lambda: pair("stones", 400, ia.SegmentBased()),
    "patch-sampling-joins": joins,
    "patch-sampling-searches": searches,
    "patch-sampling-turned": isometries,
    "patch-sampling-distances": distances,
    "graphcut": graphcut,
    "usage": usage,
    "report": reported,
    "near-regular": lambda: pair("tiles", (400, 560), ia.NearRegular(), seed=3),
    "gap-filling": lambda: pair("tiles", (400, 560), ia.GapFilling(), seed=3),
    "raster-quilting": lambda: pair("pebbles", (400, 560), ia.RasterQuilting(patch=42, overlap=7), seed=3),
    "unequal": lambda: pair("stones", (400, 560), ia.NearRegular(course_heights="unequal"), seed=3),
    "straightened": lambda: pair("brick", (512, 560), ia.NearRegular(), seed=3),
    "best-tile": lambda: pair("tiles", (400, 560), ia.BestTile(), seed=3),
    "analyzed": analyzed,
    "parallel": jittered,
    "parallel-controls": controlled,
    "turned": turned,
    "magnified": magnified,
    "flowing": flowing,
    "painting-ring": ring,
    "painting-three": three,
    "painting-corrected": lambda: beside(*strokes(), *portrait(), gap=12),
    "gallery-grow": lambda: pair(sample("pebbles", PART), SHOWN),
    "gallery-tile": gallery_tile,
    "gallery-material": gallery_material,
    # No texture; what is there once; two textures; a trend of light
    "limit-picture": lambda: pair(part_of(data.chelsea(), 40, 120, SMALL), SHOWN),
    "limit-once": lambda: pair(part_of(data.coffee(), 60, 100, 240), SHOWN),
    "limit-two": lambda: pair(np.hstack([sample(name, SMALL, 96) for name in ("stones", "planks")]), SHOWN),
    "limit-light": lambda: pair(lit(sample("gravel", SMALL), 0.35, 1.25), SHOWN),
    "limit-packed": packed,
    "limit-slanted": slanted,
}
QUALITY = {"gallery": 84, "limit": 84, "magnified": 84, "flowing": 84, "painting": 88, "patch": 88, "report": 80}
"""Quality of a JPEG file, by the first word of its name."""
FAIR, BEST = 86, 88  # quality of all others; and from which files are not packed as small as they can be


def main(*names: str) -> None:
    """Write the pictures of these names, or all."""
    if unknown := [name for name in names if name not in PICTURES]:
        sys.exit(f"no picture is called {', '.join(unknown)}; there are {', '.join(PICTURES)}")
    FOLDER.mkdir(exist_ok=True)
    for name in names or PICTURES:
        path = FOLDER / f"{name}.jpg"
        quality = QUALITY.get(name.partition("-")[0], FAIR)
        Image.fromarray(PICTURES[name]()).save(path, quality=quality, optimize=quality < BEST)
        print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main(*sys.argv[1:])
