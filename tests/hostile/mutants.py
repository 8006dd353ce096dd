"""Mutated pictures through ``ia.read``, in one long-lived process for each format.

    python -m hostile.mutants --count 1000 --seed 0 [--formats png,exr]

From small sound pictures of each format mutants are made: bytes and bits changed, parts cut out or doubled, fields set
to odd numbers; two of three PNG have their checksums mended, one of them is packed anew. A mutant fails that ends in
anything but a picture or an InputError, whose message is no legible line, that makes a library write to stdout or
stderr, takes more than 2 s of CPU or 512 MB, or leaves a file or a descriptor behind; and so does a process that dies.
Failures are kept in ``fuzz/`` below the current folder.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path
from random import Random

SLOW, LARGE = 2.0, 512_000_000 // 1024
ODD = (0, 1, 2, 3, 4, 7, 8, 15, 16, 127, 128, 255, 256, 32767, 32768, 65535, 1 << 24, *((1 << 31) + k for k in (-1, 0)))


def seeds(name: str) -> list[bytes]:
    """Small sound pictures of a format, in several ways to pack them."""
    import corpus
    import numpy as np
    from pictures import png_of, samples_of
    from PIL import Image

    picture, pillow = corpus.picture(9, 8), corpus.pillow
    gray, clear = corpus.picture(9, 8, 1), corpus.picture(9, 8, 4)
    if name == "png":
        kinds = ((0, 8), (0, 16), (2, 8), (2, 16), (4, 8), (4, 16), (6, 8), (6, 16), (0, 1), (0, 4))
        made = [png_of(samples_of(9, 8, d, c), d, c, interlaced=bool(n % 2)) for n, (c, d) in enumerate(kinds)]
        palette = Image.fromarray(picture).quantize(16)
        return [*made, pillow("png", palette), pillow("png", palette, transparency=3), _described(corpus, "png")]
    if name == "jpeg":
        ways = ({}, {"progressive": True}, {"subsampling": 0, "quality": 30}, {"exif": corpus._exif(6)})
        return [pillow("jpeg", picture, **w) for w in ways] + [pillow("jpeg", Image.fromarray(picture).convert("CMYK"))]
    if name == "gif":
        frames = [Image.fromarray(picture // k).quantize(8) for k in (1, 2)]
        more = pillow("gif", frames[0], save_all=True, append_images=frames[1:], transparency=1)
        return [pillow("gif", frames[0]), pillow("gif", gray), more]
    if name == "webp":
        made = [pillow("webp", picture, lossless=True), pillow("webp", picture), pillow("webp", clear)]
        return [*made, pillow("webp", clear, lossless=True, exact=True, exif=corpus._exif(3))]
    if name == "tiff":
        deep = picture.astype(np.uint16) * 257
        plain = [corpus.tiff(picture), corpus.tiff(deep, order=">", big=True), corpus.tiff(picture, planar=True)]
        packs = [pillow("tiff", picture, compression=c) for c in ("tiff_lzw", "tiff_adobe_deflate", "packbits", "jpeg")]
        return [*plain, *packs, pillow("tiff", Image.fromarray(gray).convert("1"), compression="group4"), corpus.tiff(
            picture.astype(np.float32))]  # fmt: skip
    if name == "tga":
        return [pillow("tga", picture), pillow("tga", clear, compression="tga_rle"), pillow(
            "tga", Image.fromarray(picture).quantize(8))]  # fmt: skip
    if name == "bmp":
        image = Image.fromarray(picture)
        return [pillow("bmp", p) for p in (image, image.quantize(8), image.convert("1"), Image.fromarray(clear))]
    if name == "pnm":
        rows = bytes(range(216))
        floats = b"PF 3 3 -1\n" + picture[:3, :3].astype("<f4").tobytes()
        return [b"P5 9 8 255\n" + rows, b"P6 9 8 255\n" + rows, b"P6 #c\n4 9 65535\n" + rows, floats]
    return [_described(corpus, name), corpus.exr(8, 9) if name == "exr" else _described(corpus, name, 1)]


def _described(corpus: object, name: str, channels: int = 3) -> bytes:
    import numpy as np
    from corpus import picture

    from intarsia.files import encode
    from intarsia.model.image import Plane

    pixels = picture(9, 8, channels if name != "hdr" else 3)
    return encode(Plane(pixels / np.float32(255) if name in ("exr", "hdr") else pixels), name, '{"seed": 1}')


def mutant(data: bytes, draw: Random) -> bytes:
    """Change a few things of some bytes."""
    bent = bytearray(data)
    for _ in range(draw.choice((1, 1, 1, 2, 3, 8, 30))):
        at, way = draw.randrange(max(len(bent), 1)), draw.randrange(9)
        if way < 3:
            bent[at : at + 1] = bytes([draw.randrange(256)])
        elif way == 3 and bent:
            bent[at] ^= 1 << draw.randrange(8)
        elif way < 6:
            size = draw.choice((1, 2, 4))
            number = draw.choice(ODD) % (1 << 8 * size)
            bent[at : at + size] = number.to_bytes(size, draw.choice(("little", "big")))
        elif way == 6:
            del bent[at : at + draw.choice((1, 2, 4, 20, 1 << 30))]
        elif way == 7:
            bent[at:at] = bent[at : at + draw.choice((1, 4, 12, 40))] * draw.choice((1, 1, 2, 50))
        else:
            bent[at:at] = draw.randbytes(draw.choice((1, 3, 10)))
    return bytes(bent[:200_000])


def mended(data: bytes) -> bytes:
    """The same PNG with right checksums, as far as its parts can be told apart."""
    out, at = bytearray(data), 8
    while at + 12 <= len(out):
        end = at + 12 + int.from_bytes(out[at : at + 4], "big")
        if end > len(out):
            break
        out[end - 4 : end] = zlib.crc32(out[at + 4 : end - 4]).to_bytes(4, "big")
        at = end
    return bytes(out)


def repacked(data: bytes, draw: Random) -> bytes:
    """A sound PNG with other pixels, filters and numbers of rows than its header says."""
    at = data.index(b"IDAT")
    stop = at + 4 + int.from_bytes(data[at - 4 : at], "big")
    body = zlib.compress(mutant(zlib.decompress(data[at + 4 : stop]), draw), 1)
    return mended(data[: at - 4] + len(body).to_bytes(4, "big") + b"IDAT" + body + data[stop:])


def worker(name: str, count: int, seed: int, keep: Path) -> None:
    """Try the mutants of one format; print a line of JSON at the end, and whenever one fails."""
    import intarsia as ia
    from intarsia import files
    from intarsia.foundation import InputError, ResourceError

    voice = os.dup(1)
    spoken = tempfile.TemporaryFile()  # noqa: SIM115
    os.dup2(spoken.fileno(), 1)
    os.dup2(spoken.fileno(), 2)
    folder = str(keep / f"{name}.now")
    os.makedirs(folder, exist_ok=True)
    tempfile.tempdir = os.path.abspath(folder)
    sound, draw = seeds(name), Random(f"{name} {seed}")
    for data in sound:
        files.read_plane(data)
    path, told = os.path.join(folder, f"m.{name}"), dict.fromkeys(("read", "refused", "failed"), 0)
    spoke, most, before = 0, 0.0, None

    def say(facts: dict[str, object]) -> None:
        os.write(voice, json.dumps(facts).encode() + b"\n")

    for number in range(count):
        seed_of = sound[number % len(sound)]
        if name == "png" and number // len(sound) % 3 == 2:
            data = repacked(seed_of, draw)
        else:
            data = mutant(seed_of, draw)
            data = mended(data) if name == "png" and number // len(sound) % 3 else data
        with open(path, "wb") as file:
            file.write(data)  # should the process die, this is the mutant that killed it
        wrong, began = "", time.process_time()
        try:
            ia.read(path)
            told["read"] += 1
        except (InputError, ResourceError) as e:
            told["refused"] += 1
            if not str(e).isprintable() or len(str(e)) > 2000:
                wrong = f"message {str(e)!r}"
        except BaseException as e:
            wrong = f"foreign {type(e).__name__}: {e}"
        took = time.process_time() - began
        most = max(most, took)
        if took > SLOW:
            wrong = wrong or f"slow: {took:.1f} s"
        if (now := os.fstat(spoken.fileno()).st_size) > spoke:
            wrong, spoke = wrong or "spoke on stdout or stderr", now
        if os.listdir(folder) != [os.path.basename(path)]:
            wrong = wrong or "left files"
        if wrong:
            told["failed"] += 1
            (keep / f"{name}-{seed}-{number}").write_bytes(data)
            say({"format": name, "mutant": number, "wrong": wrong[:300]})
        if number == 200:
            before = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else None
    leaked = 0 if before is None else len(os.listdir("/proc/self/fd")) - before
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    os.unlink(path)
    os.rmdir(folder)
    say({"format": name, "mutants": count, **told, "spoke": spoke, "leaked": leaked, "peak_mib": peak >> 10,
         "slowest": round(most, 2), "cpu": round(time.process_time(), 1), "large": peak > LARGE})  # fmt: skip


FORMATS = ("png", "jpeg", "tiff", "exr", "webp", "tga", "bmp", "hdr", "pnm", "gif")


def main(argv: list[str] | None = None) -> int:
    """Try `--count` mutants of every format; return how many things failed."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--formats", default=",".join(FORMATS))
    parser.add_argument("--worker", help=argparse.SUPPRESS)
    given = parser.parse_args(argv)
    keep = Path("fuzz")
    keep.mkdir(exist_ok=True)
    if given.worker:
        worker(given.worker, given.count, given.seed, keep)
        return 0
    failed = 0
    for name in given.formats.split(","):
        words = [sys.executable, "-m", "hostile.mutants", "--worker", name, "--count", str(given.count)]
        done = subprocess.run([*words, "--seed", str(given.seed)], stdout=subprocess.PIPE, text=True, check=False)
        lines = done.stdout.splitlines()
        print("\n".join(lines), flush=True)
        last = json.loads(lines[-1]) if lines else {}
        if done.returncode or "mutants" not in last:
            print(f"{name}: ended with {done.returncode}; its last mutant lies in {keep / name}.now", flush=True)
            failed += 1
        else:
            failed += last["failed"] + (last["leaked"] > 2) + last["large"]
    return failed


if __name__ == "__main__":
    sys.exit(min(main(), 100))
