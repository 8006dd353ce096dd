"""HTML representation of a synthesis for notebooks: the picture, an interactive source map, and the score.

The HTML is self-contained, with pictures and map as data, and loads nothing. It stays below 1 MB for any size: larger
pictures are reduced, and the reduction is stated.
"""

from __future__ import annotations

import base64
import os
import zlib
from html import escape

import numpy as np

from ..foundation import IntarsiaError, legible
from ..model import Exemplar, Exemplars
from ..model.image import Plane, Transfer, encoded, to_display
from ..model.sourcemap import HOLE, SourceMap
from . import score_map
from .windows import block_means

SIDE, SMALL = 512, 256  # px: longest side of the embedded picture, and of the exemplars
PICTURE, EXEMPLARS, MAP = 360_000, 120_000, 200_000  # most bytes of picture, all exemplars, and map, before base64
SHOWN = 6  # exemplars that are shown at most; if there are more, only their names are
JUDGED = 1 << 22  # px: larger maps are not scored, as that would delay the display
QUALITY = 88  # JPEG quality of pictures that are too large as PNG

STYLE = """
.intarsia-made { display: flex; flex-wrap: wrap; gap: 16px; align-items: flex-start;
  font: 13px/1.5 system-ui, sans-serif; }
.intarsia-made figure { margin: 0; position: relative; line-height: 0; max-width: 100%; }
.intarsia-made img { max-width: 100%; height: auto; margin: 0; }
.intarsia-made .from { display: grid; gap: 8px; }
.intarsia-made .told { flex: 1 1 16em; min-width: 12em; overflow-wrap: anywhere; }
.intarsia-made p { margin: 0 0 8px; }
.intarsia-made .where { min-height: 3em; font-variant-numeric: tabular-nums; }
.intarsia-made i { display: none; position: absolute; width: 14px; height: 14px; margin: -9px; border: 2px solid #fff;
  border-radius: 50%; outline: 2px solid #d6006c; pointer-events: none; }
.intarsia-made table { border-collapse: collapse; } .intarsia-made td { padding: 0 12px 0 0; text-align: left; }
"""

SCRIPT = """
(() => {
  const unpacked = async text => {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new DataView(await new Response(stream).arrayBuffer());
  };
  for (const box of document.querySelectorAll(".CLASS:not([data-ready])")) {
    box.dataset.ready = "";
    const {rows, columns, height, width, map} = box.dataset;
    const h = +rows, w = +columns, picture = box.querySelector("[data-made]"), line = box.querySelector(".where");
    const figures = [...box.querySelectorAll("[data-from]")];
    const names = [...box.querySelectorAll("[data-name]")];
    const known = unpacked(map);
    const clear = () => { for (const f of figures) f.querySelector("i").style.display = "none"; };
    picture.addEventListener("pointerleave", clear);
    picture.addEventListener("pointermove", async event => {
      const area = picture.getBoundingClientRect(), data = await known;
      const v = (event.clientY - area.top) / area.height, u = (event.clientX - area.left) / area.width;
      if (!(v >= 0 && v < 1 && u >= 0 && u < 1)) return;
      const r = Math.floor(v * h), c = Math.floor(u * w), n = r * w + c, all = h * w;
      const at = [Math.floor((2 * r + 1) * height / (2 * h)), Math.floor((2 * c + 1) * width / (2 * w))];
      const which = data.getUint8(8 * all + n);
      clear();
      if (which === 255) { line.textContent = `row ${at[0]}, column ${at[1]}: nothing is here`; return; }
      const y = data.getInt32(4 * n, true) + at[0], x = data.getInt32(4 * (all + n), true) + at[1];
      const name = names[which] ? names[which].textContent : `exemplar ${which + 1}`;
      line.textContent = `row ${at[0]}, column ${at[1]} is row ${y}, column ${x} of ${name}`;
      line.dataset.place = [at[0], at[1], which, y, x].join();
      const figure = figures[which];
      if (!figure) return;
      const ring = figure.querySelector("i"), size = figure.dataset.from.split("x");
      ring.style.display = "block";
      ring.style.left = 100 * (x + 0.5) / size[0] + "%";
      ring.style.top = 100 * (y + 0.5) / size[1] + "%";
    });
  }
})();
"""


def html_of(picture: Plane, exemplars: Exemplars, smap: SourceMap, about: str) -> str:
    """Return a picture with its map as an HTML fragment; `about` describes how it was made."""
    seen, less = _shown(picture, SIDE, PICTURE, "the output")
    size = f"{picture.width}x{picture.height} px"
    size += f", shown reduced {less} times" if less > 1 else ""
    mark, (rows, columns, data) = f"intarsia-{os.urandom(6).hex()}", _packed(smap)
    told = [f"<p><b>{size}</b><br>{escape(legible(about))}</p>", _score(exemplars, smap)]
    named = (f"<span data-name>{escape(legible(e.name))}</span> {e.width}x{e.height} px" for e in exemplars)
    told.append(f"<p>from {', '.join(named)}</p>")
    told.append('<p class="where">Point at the picture: here it says where each pixel comes from.</p>')
    shown = exemplars if len(exemplars) <= SHOWN else ()
    figures = "".join(_figure(e, EXEMPLARS // len(shown)) for e in shown)
    where = f'data-rows="{rows}" data-columns="{columns}" data-height="{smap.height}" data-width="{smap.width}"'
    return (
        f'<div class="intarsia-made {mark}" {where} data-map="{data}"><style>{STYLE}</style>'
        f'<figure data-made>{seen}</figure><div class="from">{figures}</div>'
        f'<div class="told">{"".join(told)}</div></div><script>{SCRIPT.replace("CLASS", mark)}</script>'
    )


def _figure(exemplar: Exemplar, most: int) -> str:
    seen, _ = _shown(exemplar.base, SMALL, most, f"the exemplar {legible(exemplar.name)}")
    return f'<figure data-from="{exemplar.width}x{exemplar.height}">{seen}<i></i></figure>'


def _score(exemplars: Exemplars, smap: SourceMap) -> str:
    """Return the score and its parts as HTML; a sentence if there is none."""
    if smap.height * smap.width > JUDGED:
        return "<p>intarsia.score judges pictures of this size.</p>"
    try:
        found = score_map(exemplars, smap)
    except IntarsiaError as e:
        return f"<p>no score: {escape(legible(str(e)))}</p>"
    parts = (f"<tr><td>{escape(n)}</td><td>{100 * found.parts[n].normalised:.0f}</td></tr>" for n in found.ranked)
    table = f"<details><summary>its parts, each of 100</summary><table>{''.join(parts)}</table></details>"
    return f"<p>score <b>{found.total:.1f}</b> of 100, {found.verdict}</p>{table}"


def _shown(plane: Plane, side: int, most: int, alt: str) -> tuple[str, int]:
    """Return an <img> of at most `side` px a side and about `most` bytes, and the whole factor of its reduction."""
    pixels = to_display(plane.pixels, plane.kind, plane.transfer is Transfer.LINEAR)
    pixels = pixels.reshape(*pixels.shape[:2], -1)
    step = max(-(-max(pixels.shape[:2]) // side), 1)
    while True:
        step = min(step, *pixels.shape[:2])
        small = block_means(pixels, step).astype(np.uint8)
        data, kind = encoded(small), "png"
        if len(data) > most and small.shape[2] in (1, 3):
            data, kind = encoded(small, QUALITY), "jpeg"
        if len(data) <= most or min(small.shape[:2]) < 16:
            break
        step += max(step // 2, 1)
    text = base64.b64encode(data).decode()
    wide = f'width="{small.shape[1]}" height="{small.shape[0]}"'
    return f'<img src="data:image/{kind};base64,{text}" {wide} alt="{escape(alt)}">', step


def _packed(smap: SourceMap) -> tuple[int, int, str]:
    """Return rows and columns of a map reduced to fit into MAP bytes, and its data: offsets and exemplar numbers.

    Offsets (rows, then columns) are int32, little-endian, and exemplars uint8, compressed by zlib, as base64.
    """
    step = max(-(-max(smap.shape) // SIDE), 1)
    while True:
        height, width = max(smap.height // step, 1), max(smap.width // step, 1)
        rows = (2 * np.arange(height) + 1) * smap.height // (2 * height)
        columns = (2 * np.arange(width) + 1) * smap.width // (2 * width)
        yx = smap.yx[np.ix_(rows, columns)]
        which = smap.numbers[np.ix_(rows, columns)]
        known = which != HOLE
        moved = (np.where(known, yx[:, :, 0] - rows[:, None], 0), np.where(known, yx[:, :, 1] - columns[None], 0))
        data = zlib.compress(b"".join(m.astype("<i4").tobytes() for m in moved) + which.tobytes(), 9)
        if len(data) <= MAP or max(height, width) < 16:
            return height, width, base64.b64encode(data).decode()
        step += max(step // 2, 1)
