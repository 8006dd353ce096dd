"""Uploads: limits before decoding, sanitised names, and decoding in a process with limited memory."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..foundation import SAMPLES, InputError, printable, said
from .processes import FailedError, Process
from .store import Row, Store, digest

MOST_BYTES = 3 << 30  # of address space of the decoding process
WITHIN = 30.0  # s to decode an exemplar

PNG = b"\x89PNG\r\n\x1a\n"
Part = tuple[str, bytes]
"""The name of a file, and what it holds."""

MAGIC = {
    PNG: (".png",),
    b"\xff\xd8\xff": (".jpg", ".jpeg"),
    **dict.fromkeys((b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"), (".tif", ".tiff")),
    b"v/1\x01": (".exr",),
    **dict.fromkeys((b"#?RADIANCE", b"#?RGBE"), (".hdr",)),
    **dict.fromkeys((b"GIF87a", b"GIF89a"), (".gif",)),
    b"RIFF": (".webp",),
    b"BM": (".bmp",),
    **dict.fromkeys((b"P3", b"P6"), (".ppm",)),
    **dict.fromkeys((b"P2", b"P5"), (".pgm",)),
    **dict.fromkeys((b"PF", b"Pf"), (".pfm",)),
}
"""First bytes of the accepted formats, and the endings of their names."""


def ending_of(data: bytes, name: str) -> str:
    """Return the ending for a file by its first bytes; InputError if they are of no known format."""
    if not data:
        raise InputError(f"{printable(name)} is empty; give the picture itself.")
    for mark, endings in MAGIC.items():
        if data.startswith(mark) and (mark != b"RIFF" or data[8:12] == b"WEBP"):
            own = Path(name).suffix.lower()
            return own if own in endings else endings[0]
    raise InputError(f"{printable(name)} is no picture: give PNG, JPEG, TIFF, EXR, HDR, WebP, GIF or BMP.")


def stem_of(name: str) -> str:
    """Return what of a name is kept: letters, digits, _ and - of its last part, without its ending."""
    last = re.split(r"[/\\]", name)[-1]
    stem = last.rpartition(".")[0] or last
    kept = "".join(c if (c.isalnum() or c in "_-") and c.isprintable() else "_" for c in stem)
    return kept.strip("_")[:60].lstrip("-") or "picture"


class Uploads:
    """Exemplars and images that come in, and the process that decodes them."""

    def __init__(self, store: Store, looker: Process) -> None:
        self.store, self.looker = store, looker

    async def sets(self, parts: Sequence[Part]) -> list[list[Part]]:
        """Sort files into exemplars by their names, as the command does."""
        named = dict[str, Part]()
        for name, data in parts:
            own = stem_of(name) + Path(name).suffix.lower()
            if own in named:
                raise InputError(f"two files are called {own}; rename one.")
            named[own] = name, data
        found, _ = await self.looker.ask("sets", within=WITHIN, names=list(named))
        return [[named[own] for own in names] for names in found["sets"]]

    async def exemplar(self, parts: Sequence[Part], more: Row | None = None) -> Row:
        """Store the files of one exemplar, and what more is known of it."""
        with self.folder("exemplars") as folder:
            names = list[str]()
            for name, data in parts:
                own = stem_of(name) + ending_of(data[:32], name)
                if own in names:  # two endings of one format
                    raise InputError(f"two files are called {own}; rename one.")
                names.append(own)
                await asyncio.to_thread((folder / own).write_bytes, data)
            return await self.kept(folder, names, more)

    async def sample(self, name: Any) -> Row:
        """Add a built-in exemplar."""
        if name not in SAMPLES:
            raise InputError(f"{said(name)} is no built-in exemplar; give one of {', '.join(SAMPLES)}.")
        row = await self._looked([f"sample:{name}"])
        row |= {"id": digest((), f"sample:{name}"), "files": [], "sample": name}
        return self.store.keep("exemplars", self.store.begun("exemplars"), row)

    async def result(self, name: Any) -> Row:
        """Add a result as an exemplar."""
        row = self.store.get("results", name) if isinstance(name, str) else None
        if row is None:
            raise InputError(f"{said(name)} is not the id of a result.")
        place = self.store.place("results", row["id"])
        parts = [(name, (place / name).read_bytes()) for name in row["pictures"]]
        return await self.exemplar(parts, {"from": row["id"]})

    async def _looked(self, paths: list[str]) -> Row:
        seen, _ = await self.looker.ask("look", within=WITHIN, paths=paths)
        return {**seen, "created": time.time()}

    async def image(self, data: bytes) -> Row:
        """Store a picture of numbers: labels, a mask."""
        if not data.startswith(PNG):
            raise InputError("the image is no PNG; save it so, with one channel of 8 bits.")
        with self.folder("images") as folder:
            path = folder / "image.png"
            path.write_bytes(data)
            await self.looker.ask("labels", within=WITHIN, path=str(path))
            row = {"id": digest([path])}
            self.store.put("images", row)  # first, as an image without a note has no owner
            path.replace(self.store.place("images", row["id"]))
            return row

    async def kept(self, folder: Path, names: list[str], more: Row | None = None) -> Row:
        """Store an exemplar whose files were written into a folder, and what more is known of it."""
        row = await self._looked([str(folder / name) for name in names])
        row |= {"id": digest(folder.iterdir()), "files": names} | (more or {})
        return self.store.keep("exemplars", folder, row)

    @contextmanager
    def folder(self, kind: str) -> Iterator[Path]:
        """Yield a temporary folder whose path is removed from errors."""
        with self.store.under_way(kind) as folder:
            try:
                yield folder
            except FailedError as e:
                raise FailedError(str(e).replace(f"{folder}/", ""), e.exit_code) from None

    def paths_of(self, row: Row) -> list[str]:
        """Return the files of an exemplar."""
        place = self.store.place("exemplars", row["id"])
        return [f"sample:{row['sample']}"] if row.get("sample") else [str(place / name) for name in row["files"]]
