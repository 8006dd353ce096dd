"""The table of all options: every field of a request once, in the order in which help lists it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..disk import DEFAULT_PIXELS, VARIABLE
from ..foundation import (
    ALPHAS,
    AUTO_METHOD,
    ENGINES,
    FEATHER,
    MOST_PASSES,
    MOST_TRIALS,
    PLANE_WEIGHTS,
    REACHES,
    STRENGTHS,
    TIMES,
    WEIGHT,
    WEIGHTS,
)
from ..foundation.geometry import Wrap
from ..methods import METHODS, PRESETS, Ability, method_class, parameters_of
from .field import (
    FLAG,
    Called,
    Channels,
    Colour,
    File,
    Kind,
    NamedFile,
    NamedNumber,
    Number,
    Place,
    Rectangle,
    Scale,
    Seed,
    Seeds,
    Size,
    Whole,
    one_of,
    option,
)

PICTURE_VERBS = frozenset({"extend", "heal", "tile"})
"""Verbs that start with a picture."""

PLANNED = PICTURE_VERBS | {"grow", "paint"}
"""Verbs that make one picture, or many, in memory."""

EVERY = PLANNED | {"weave", "render", "replay", "analyze", "score", "tileset"}
DRAWN = PLANNED | {"render", "replay"}
SETS = frozenset({"maps", "export", "tileset"})
"""Verbs that write several files into a folder."""

READ = EVERY | SETS
METHOD_VERBS = PLANNED | {"weave"}

ABILITIES = {
    "paint": {Ability.GUIDE}, "heal": {Ability.START, Ability.MASK}, "tile": {Ability.START, Ability.MASK},
    "weave": {Ability.WINDOW},
}  # fmt: skip
"""Abilities that a method needs to be offered by a verb."""

OUTPUT_SUFFIX = {
    "grow": "grown",
    "paint": "painted",
    "extend": "extended",
    "heal": "healed",
    "tile": "tiled",
    "weave": "woven",
}
"""Suffix of the name of a result, after that of its exemplar, if no name is given."""


def methods_for(verb: str) -> tuple[str, ...]:
    """Return the methods that a verb offers."""
    return tuple(s for s in METHODS if verb not in ABILITIES or ABILITIES[verb] <= method_class(s).supports)


def default_parameters(verb: str, slug: str) -> dict[str, Any]:
    """Return the defaults of a verb for a named method: around a hole the best patch is taken."""
    return {"tolerance": 0.0} if verb in ("heal", "tile") and "tolerance" in parameters_of(slug) else {}


MARGINS, PICTURE, IMAGE, WRITTEN = Whole(high=1 << 20), File(name="exemplar"), File(name="image"), File()
USABLE = "White where pixels may be taken from. One for each picture."
OUT = "The picture to write. Further planes lie beside it as OUT_NAME; - is the standard output (PNG)."
USUAL_OUT = (
    " A name that ends in / is a folder: every material goes there by itself, under its own name. Default: NAME_{} "
    "in the working folder, in the exemplar's format if that is lossless, else PNG or EXR."
)


class MethodOf(Kind):
    """A method that a verb offers, or ``auto``; methods are imported only when their names are needed."""

    name, verb = "choice", ""

    @cached_property
    def choices(self) -> tuple[str, ...]:  # type: ignore[override]
        return AUTO_METHOD, *methods_for(self.verb)


@dataclass(frozen=True, init=False, repr=False, eq=False)
class Options:
    """The fields of a request. A field that the verb does not have keeps its default."""

    verb: str

    left: int | None = option(MARGINS, "--left", "Px to add at the left.", "extend", heading="What goes where")
    right: int | None = option(MARGINS, "--right", "Px to add at the right.", "extend")
    top: int | None = option(MARGINS, "--top", "Px to add at the top.", "extend")
    bottom: int | None = option(MARGINS, "--bottom", "Px to add at the bottom.", "extend")
    axes: str = option(
        one_of("x", "y", "both"), "--axes", "Axes along which it is to tile.", "tile", "tells_default", "both",
    )  # fmt: skip
    band: int | None = option(
        Whole(low=1, high=1 << 16), "--band",
        "Width of the band that is grown anew. Half lies at either border. Default: one and a half elements.",
        "tile", recipe="tile.band", shown="PX",
    )  # fmt: skip
    holes: tuple[str, ...] = option(
        File(name="image", choices=("alpha",)), "--mask", "White is healed; with alpha what is transparent. As large "
        "as the picture; one for all pictures, or one for each.",
        "heal", "many required", shown="HOLE|alpha",
    )  # fmt: skip
    grow: int | None = option(
        Whole(high=1024, choices=("auto",)), "--grow",
        "Enlarge the hole by N px first. With auto as far as a rim of the defect is seen outside. Default: auto.",
        "heal", recipe="heal.grow", shown="N|auto",
    )  # fmt: skip
    labels: tuple[str, ...] = option(
        IMAGE, "--labels -l",
        "Which pixel of the exemplar is what. One colour for each label; once for each exemplar.",
        "paint replay", "many required",
        otherwise={"replay": {"help": "What paint was given as --labels.", "required": False}},
    )  # fmt: skip
    target: str | None = option(
        IMAGE, "--target -t", "Where each label shall be. In the same colours; the output has its size.",
        "paint replay", "required",
        otherwise={"replay": {"help": "What paint was given as --target.", "required": False}},
    )  # fmt: skip
    weight: float = option(
        Number(high=WEIGHTS), "--weight",
        "How closely boundaries follow the target. 1.5 to 2.5 mostly; 0 takes what joins best.",
        "paint", "tells_default", WEIGHT, recipe="guide.weight",
    )  # fmt: skip
    window: tuple[int, int, int, int] | None = option(
        Rectangle(), "--window", "Draw this part only. Where the map wraps it may reach over the border.",
        "render",
    )  # fmt: skip
    engine: str | None = option(
        one_of(*ENGINES), "--for", "The engine that reads it. It decides names, the green axis of normals, and what "
        "is packed.", "export grow tile", "rare local without_effect",
        otherwise={
            "export": {"required": True},
            **dict.fromkeys(
                ("grow", "tile"),
                "Write the set as this engine reads it. In the folder of OUT, called after it; see export.",
            ),
        },
    )  # fmt: skip
    tiles: str = option(
        one_of("16", "81"), "--tiles", "How many. Their corners have two or three colours.", "tileset", "tells_default",
        "16",
    )  # fmt: skip
    strength: float = option(
        Number(low=-STRENGTHS, high=STRENGTHS), "--strength", "How steep the normals are. Below 0 what lay deep "
        "stands out.", "maps", "tells_default", 1.0,
    )  # fmt: skip
    origin: tuple[int, int] = option(
        Place(), "--origin", "Which pixel of the endless plane comes first. Negative and huge ones too.",
        "weave", default=(0, 0),
    )  # fmt: skip
    edge: int = option(
        Whole(high=64), "--edge", "Fill N px along the edge of holes again, pixel by pixel; slow.",
        "heal", "rare", 0, recipe="edge",
    )  # fmt: skip
    reach: int = option(
        Whole(high=REACHES), "--reach", "Pixels this near to a boundary count as partly of both labels.",
        "paint", "rare tells_default", 0, recipe="guide.reach", shown="PX",
    )  # fmt: skip

    out: str | None = option(
        WRITTEN, "-o --output", OUT, DRAWN | SETS | {"weave"}, "local", heading="Output", shown="OUT",
        otherwise={
            **{verb: OUT + USUAL_OUT.format(OUTPUT_SUFFIX[verb]) for verb in PLANNED},
            **{verb: {"required": True} for verb in ("render", "replay")},
            **{verb: {"required": True, "help": "The folder to write into."} for verb in ("export", "tileset")},
            "maps": {
                "required": True, "help": "A folder, or how names begin. What ends in / is a folder; {stem} is filled.",
            },
            "weave": "OUT.zarr, OUT.tif, or OUT.png. A .zarr goes on where it was stopped, all else begins anew; a "
                ".tif is a tiled BigTIFF; a .png, or another picture, must fit into memory. Further planes lie beside "
                "it as OUT_NAME. Default: NAME_woven.tif in the working folder.",
        },
    )  # fmt: skip
    size: tuple[int, int] | None = option(
        Size(), "--size -s", "Size in px; by default twice the exemplar. One number is a square.",
        "grow tile weave tileset", recipe="size",
        otherwise={
            "tileset": "Of a tile in px; one number is a square. Default: about 256, or three elements if these are "
                "larger; whole periods or courses.",
            "tile": "Cut its middle out first. Default: all, or the largest size in which a sure lattice or "
                "courses close.",
            "weave": {
                "kind": Size(most=1 << 80), "required": True,
                "help": "Size in px, as large as the disk allows. One number is a square.",
            },
        },
    )  # fmt: skip
    wrap: str | None = option(
        one_of(*(w.value for w in Wrap)), "--wrap",
        "Axes along which the output tiles. It continues in itself there; without a value along both.",
        (PLANNED - {"tile"}) | {"score"}, "tells_default", Wrap.NONE.value, recipe="wrap",
        alone=Wrap.BOTH.value,
        otherwise={
            "heal": "Axes along which the picture continues in itself.",
            "score": {
                "help": "Axes along which the output should tile. By default as its map does.",
                "default": None, "alone": None, "tells_default": False,
            },
        },
    )  # fmt: skip
    depth: str | None = option(
        one_of("8", "16", "half", "float"), "--depth", "Bits; by default those of the exemplar.", DRAWN,
        recipe="depth",
    )  # fmt: skip
    force: bool = option(
        FLAG, "--force", "Replace files that exist.", READ - {"analyze"}, "local",
        otherwise={"weave": "Replace files that exist; a .zarr is never replaced."},
    )  # fmt: skip
    page: str | None = option(
        WRITTEN, "--report", "A page on how good it is. What it is made of, and where it loses; with {stem} "
        "or {seed} in its name of several outputs.",
        PLANNED | {"replay", "score"}, "without_effect", shown="FILE.html",
        otherwise={"score": "A page on how good it is. Also where it misses a gate."},
    )  # fmt: skip
    preview: str | None = option(
        WRITTEN, "--preview", "Write the result repeated. 3 times along each axis that continues, to look at.", "tile",
        "without_effect",
    )  # fmt: skip
    save_map: str | None = option(
        WRITTEN, "--save-map", "Save which exemplar pixel went where.",
        PLANNED | {"replay"}, "rare without_effect", shown="FILE.npz",
    )  # fmt: skip
    chunk: int | None = option(
        Whole(low=16, high=8192), "--chunk",
        "Side of the chunks of a zarr array, or of the tiles of a TIFF. Default: 512.",
        "weave", "rare", shown="PX",
    )  # fmt: skip

    method: str = option(
        MethodOf(verb="grow"), "--method -m",
        "One of `intarsia methods`; auto chooses. It goes by what the exemplar is like.",
        METHOD_VERBS, "tells_default", AUTO_METHOD, heading="Look",
        otherwise={
            "paint": {"kind": MethodOf(verb="paint"), "help": "How to grow; `intarsia methods` tells of each."},
            "heal": {"kind": MethodOf(verb="heal"), "help": "How to fill the holes."},
            "tile": {"kind": MethodOf(verb="tile"), "help": "How to grow the band."},
            "weave": {
                "kind": MethodOf(verb="weave"), "help": "How to grow; auto chooses. It goes by what the exemplar is "
                "like, among methods that make windows alone.",
            },
        },
    )  # fmt: skip
    feather: int | None = option(
        Whole(high=FEATHER), "--feather",
        "Soften seams over so many px; 0 copies exactly. By default as the method means it.",
        "grow extend paint weave render", recipe="blend.feather", shown="PX",
        otherwise={"render": "Soften the seams over so many px. By default as it was grown."},
    )  # fmt: skip
    trials: int | None = option(
        Whole(low=1, high=MOST_TRIALS), "--trials",
        "Make N variants, keep the best by score. With --method auto only. Default: 1.",
        "grow extend", "without_effect",
    )  # fmt: skip
    seed: int | None = option(
        Seed(), "--seed", "The same number gives the same picture. Default: 0.", METHOD_VERBS | {"tileset"},
        recipe="seed",
    )  # fmt: skip
    document: str | None = option(
        one_of(*PRESETS), "--as",
        "Set what a paper sets: method, its parameters and mixing. What is given besides wins.",
        "grow extend", "rare local without_effect",
    )  # fmt: skip
    repair: int = option(
        Whole(high=MOST_PASSES), "--repair",
        "Look for the worst seams N times and cover them anew where that helps. 4 is much. "
        "Default: 0.", PLANNED, "rare", 0, recipe="repair",
    )  # fmt: skip
    explain: bool = option(
        FLAG, "--explain",
        "With --method auto: tell what was measured, which rule chose, and the command without auto.",
        METHOD_VERBS, "rare local without_effect",
    )  # fmt: skip
    mixing: str | None = option(
        one_of("mean", "source"), "--mixing",
        "How pieces mix where seams are soft: mean in linear light, source as stored.",
        "grow extend paint weave render", "rare", recipe="blend.mixing",
        otherwise={"render": "How pieces mix within the feather; by default as it was grown."},
    )  # fmt: skip
    even_tone: int | None = option(
        Whole(high=FEATHER), "--even-tone",
        "Even out steps of light and colour at seams, so many px to either side. 0 leaves them. By default 96 where "
        "the method is chosen, 0 where it is named.",
        "grow paint weave render", "rare", shown="PX",
        otherwise={
            "render": "Even out steps of light and colour so far to either side of seams, 0: leave them; by default "
                "as it was grown.",
        },
    )  # fmt: skip
    magnify: int = option(
        Whole(low=1, high=TIMES), "--magnify", "Grow small, at 1/N, and draw at full size. All pixels of the exemplar "
        "are drawn: for large outputs. Sizes stay those of the pictures; all else, such as --patch and --feather (then "
        "1 if not given), counts px of 1/N.",
        "grow weave render", "rare of_exemplars", 1,
    )  # fmt: skip

    files: tuple[str, ...] = option(
        PICTURE, "", "", READ, "many required local", heading="Exemplar", shown="EXEMPLAR...",
        otherwise={
            **{verb: {"shown": "IMAGE..."} for verb in PICTURE_VERBS},
            **{
                verb: {
                    "flags": ("--exemplar", "-e"), "help": "The exemplar. Once for each file.", "shown": "FILE",
                    "required": False,
                }
                for verb in ("render", "replay")
            },
        },
    )  # fmt: skip
    maps: tuple[tuple[str, str], ...] = option(
        NamedFile(), "--map",
        "A further plane, such as normal=normals.png. Once for each: height=h.exr, roughness=rough.png.",
        READ - {"score"}, "many local",
    )  # fmt: skip
    masks: tuple[str, ...] = option(
        IMAGE, "--mask", "White where exemplar pixels may be used. One for each exemplar.", EVERY, "many",
        otherwise={
            "heal": {"flags": ("--usable",), "help": USABLE},
            "replay": "The mask that was given. That is the hole that was healed, elsewhere the exemplar pixels that "
                "could be used.",
        },
    )  # fmt: skip
    crop: tuple[int, int, int, int] | None = option(
        Rectangle(), "--crop", "Use this part of the exemplar only.", EVERY - {"heal"}, "of_exemplars",
    )  # fmt: skip
    flatten: bool = option(
        FLAG, "--flatten", "Even out uneven light in the exemplar first. That is a slope or a vignette; `intarsia "
        "analyze` tells where it helps.", EVERY - {"extend", "heal"}, "of_exemplars",
    )  # fmt: skip
    several: bool = option(
        FLAG, "--several",
        "Every file is an exemplar of its own. By default names decide: x_albedo and x_normal are one set.",
        READ - PICTURE_VERBS - {"weave"}, "local",
    )  # fmt: skip
    donors: tuple[str, ...] = option(
        PICTURE, "--from", "Take new pixels from this picture, or these. By default from the picture itself.",
        PICTURE_VERBS | {"replay"}, "many",
        otherwise={"replay": "What new pixels were taken from. By default the picture itself."},
    )  # fmt: skip
    usable: tuple[str, ...] = option(IMAGE, "--usable", USABLE, "replay", "many")
    saved: str | None = option(
        WRITTEN, "", "", "render score", "local",
        otherwise={
            "render": {"shown": "MAP.npz", "required": True},
            "score": {
                "flags": ("--map",), "shown": "FILE.npz",
                "help": "The map that was saved with --save-map. It tells what seams cost, and a report of its pieces.",
            },
        },
    )  # fmt: skip
    picture: str | None = option(WRITTEN, "", "", "replay", "required")
    output: str | None = option(WRITTEN, "", "", "score", "required", shown="OUTPUT")
    packed: str | None = option(
        Channels(), "--packed", "What the channels of the packed map hold (NAME_orm and the like, or --map "
        "packed=FILE), such as R=ao,G=roughness,B=metallic.", READ - {"score"}, "rare of_exemplars",
    )  # fmt: skip
    weights: tuple[tuple[str, float], ...] = option(
        NamedNumber(most=PLANE_WEIGHTS, remedy=f"a plane and 0 to {PLANE_WEIGHTS}, such as height=0.5"),
        "--weight --plane-weight",
        "How much a plane counts in matching, relative to what is usual, such as normal=2; 0: it is only drawn.",
        EVERY - {"score"}, "many rare of_exemplars",
        otherwise={"paint": {"flags": ("--plane-weight",)}},  # --weight is that of the target
    )  # fmt: skip
    as_set: bool = option(
        FLAG, "--set", "All files are planes of one exemplar. Their names do not matter.", READ,
        "rare local without_effect",
    )  # fmt: skip
    scale: int = option(
        Scale(), "--scale",
        "Reduce the exemplar to 1/2, 1/3, ... first. After --crop; blocks are averaged in linear light.",
        EVERY - {"heal"}, "rare of_exemplars", 1,
    )  # fmt: skip
    alpha: str = option(
        one_of(*ALPHAS), "--alpha", "Opacity is a channel to grow, or a mask of the pixels that may be used.",
        EVERY, "rare tells_default of_exemplars", "auto",
    )  # fmt: skip
    avoid: tuple[int, int, int] | None = option(
        Colour(), "--avoid", "Never use exemplar pixels of exactly this colour.", EVERY, "rare of_exemplars",
    )  # fmt: skip
    toroidal: bool = option(
        FLAG, "--toroidal", "The exemplar tiles: it continues across its borders.", READ - {"tile", "export"},
        "rare of_exemplars",
    )  # fmt: skip
    max_pixels: int | None = option(
        Whole(low=1), "--max-pixels",
        f"Most pixels of a picture that is read. Default: {DEFAULT_PIXELS} (8192x8192), or what {VARIABLE} says.",
        READ, "rare local without_effect",
    )  # fmt: skip
    start: str | None = option(
        WRITTEN, "--start", "The map that was continued.", "replay", "rare", shown="MAP.npz",
    )  # fmt: skip
    pictures: tuple[tuple[str, str], ...] = option(
        NamedFile(), "--picture",
        "A picture that was given as a parameter, such as jitter_output=calm.png; once for each.",
        "replay", "many rare", shown="PARAMETER=FILE",
    )  # fmt: skip

    many: tuple[int, ...] | None = option(
        Seeds(), "--seeds", "One output for each seed. {seed} in -o tells them apart.", PLANNED,
        "local without_effect", heading="Work",
    )  # fmt: skip
    dry_run: bool = option(
        FLAG, "--dry-run", "Check everything, write nothing. Tells sizes and memory.", METHOD_VERBS,
        "local without_effect",
        otherwise={"weave": "Check everything, write nothing. Tells size, memory and time."},
    )  # fmt: skip
    dask: str | None = option(
        Kind(), "--dask",
        "A dask cluster draws. One that is started here, or the one whose scheduler is at tcp://HOST:PORT.",
        "weave", "local", shown="local|ADDRESS",
    )  # fmt: skip
    gates: tuple[tuple[str, float], ...] = option(
        NamedNumber(shown="PART=VALUE", most=100, remedy="a part and its least worth, such as joins=0.5"),
        "--gate", "Exit with 4 where less is reached. The total goes to 100, parts to 1; once for each.",
        "score", "many without_effect",
    )  # fmt: skip
    as_json: bool = option(
        FLAG, "--json", "Print the result as a JSON object.", READ, "local without_effect",
        otherwise={
            "analyze": "Print what was found as a JSON object on stdout.",
            "score": "Print the score as a JSON object on stdout.",
        },
    )  # fmt: skip
    quiet: bool = option(
        FLAG, "--quiet -q", "Say nothing but errors.", READ, "local without_effect",
        otherwise={"score": "Print nothing; the exit code tells of the gates."},
    )  # fmt: skip
    sheet: str | None = option(
        WRITTEN, "--sheet", "A contact sheet of all that is made.", PLANNED, "rare without_effect", shown="FILE.png",
    )  # fmt: skip
    threads: int | None = option(
        Whole(low=1, high=1024), "--threads", "Threads to use; by default one a core. Never changes a pixel.",
        EVERY - {"analyze", "score"}, "rare local without_effect",
    )  # fmt: skip
    progress: str | None = option(
        one_of("json"), "--progress", "Tell all as JSON lines on stderr. For programs; docs/callers.md says which.",
        READ, "rare local without_effect",
    )  # fmt: skip
    with_parent: bool = option(
        FLAG, "--with-parent", "End when the standard input is closed. As it is when the calling program ends.", READ,
        "rare local without_effect",
    )  # fmt: skip
    called: tuple[tuple[str, str], ...] = option(
        Called(), "--call", "What messages call a file, such as layer1.png=Background. Once for each.", READ,
        "many rare local without_effect",
    )  # fmt: skip
