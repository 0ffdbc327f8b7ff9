"""Checks with another reader that `seidel apply --amount 0` keeps every pixel bit and every attribute of EXR files.

Writes files of different kinds with the OpenEXR library (PyPI OpenEXR and numpy), adds those named on the command line,
runs the command on each, and compares input and output. Exit status 1 if anything differs except the documented changes
of compression.

    python3 tests/round_trip/exr.py target/release/seidel LENS.json [PLATE.exr ...]
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

# Attributes that the library adds, and lossy compressions, which become ZIP (docs/guide/files.md).
ADDED = {"chunkCount"}
LOSSY = {
    OpenEXR.B44_COMPRESSION,
    OpenEXR.B44A_COMPRESSION,
    OpenEXR.DWAA_COMPRESSION,
    OpenEXR.DWAB_COMPRESSION,
}
WIDTH, HEIGHT = 53, 37


def noise(seed, kind):
    """Random samples over 24 powers of two, some negative, of a numpy type."""
    rng = np.random.default_rng(seed)
    values = np.exp2(rng.uniform(-12, 12, (HEIGHT, WIDTH)))
    values = values * np.where(rng.random((HEIGHT, WIDTH)) < 0.2, -1, 1)
    if kind == np.uint32:
        return rng.integers(0, 2**32, (HEIGHT, WIDTH), dtype=np.uint32)
    return values.astype(kind)


def colour(kind, names="RGBA"):
    return {name: noise(k, kind) for k, name in enumerate(names)}


def header(compression, **more):
    window = (np.array([-7, 5], np.int32), np.array([WIDTH - 8, HEIGHT + 4], np.int32))
    display = (np.array([0, 0], np.int32), np.array([63, 47], np.int32))
    return {
        "compression": compression,
        "type": OpenEXR.scanlineimage,
        "dataWindow": window,
        "displayWindow": display,
        **more,
    }


def attributes():
    """Attributes of every type."""
    return {
        "timeCode": OpenEXR.TimeCode(1, 2, 3, 4, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8),
        "chromaticities": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),
        "owner": "nobody in particular",
        "comments": "Grüße, 50 % gray",
        "capDate": "2026:11:22 10:00:00",
        "utcOffset": -3600.0,
        "focus": 2.5,
        "expTime": 0.02,
        "aperture": 2.8,
        "isoSpeed": 800.0,
        "camera/lens/serial": "A-1",
        "aDouble": np.array([1.0 / 3.0], np.float64),
        "anInt": 7,
        "aPoint": np.array([1, 2], np.int32),
        "aVector": np.array([1.5, -2.5, 3.5], np.float32),
        "aMatrix": np.arange(16, dtype=np.float32).reshape(4, 4),
        "multiView": ["left", "right"],
        "oiio:ColorSpace": "ACEScg",
    }


CRYPTO = {
    "cryptomatte/f834d0a/name": "crypto_object",
    "cryptomatte/f834d0a/hash": "MurmurHash3_32",
    "cryptomatte/f834d0a/conversion": "uint32_to_float32",
    "cryptomatte/f834d0a/manifest": '{"ball":"f2a5bc7d"}',
}


def files(folder):
    """Writes files of different kinds; returns their paths."""
    whole = {
        "half-zip-attributes": (header(OpenEXR.ZIP_COMPRESSION, **attributes()), colour(np.float16)),
        "float-piz": (header(OpenEXR.PIZ_COMPRESSION), colour(np.float32)),
        "half-none": (header(OpenEXR.NO_COMPRESSION), colour(np.float16)),
        "float-rle": (header(OpenEXR.RLE_COMPRESSION), colour(np.float32, "RGB")),
        "half-zips-decreasing": (
            header(OpenEXR.ZIPS_COMPRESSION, lineOrder=OpenEXR.DECREASING_Y),
            colour(np.float16),
        ),
        "half-pxr24": (header(OpenEXR.PXR24_COMPRESSION), colour(np.float16)),
        "half-dwaa": (header(OpenEXR.DWAA_COMPRESSION), colour(np.float16)),
        "half-b44": (header(OpenEXR.B44_COMPRESSION), colour(np.float16)),
        "luminance": (header(OpenEXR.ZIP_COMPRESSION), colour(np.float32, "Y")),
        "layers-ids-cryptomatte": (
            header(OpenEXR.ZIP_COMPRESSION, **CRYPTO),
            {
                **colour(np.float16),
                "diffuse.R": noise(10, np.float16),
                "depth.Z": noise(11, np.float32),
                "motion.x": noise(12, np.float32),
                "id": noise(13, np.uint32),
                **{f"crypto_object00.{c}": noise(14 + k, np.float32) for k, c in enumerate("RGBA")},
            },
        ),
        "tiled": (
            header(
                OpenEXR.ZIP_COMPRESSION,
                **{"type": OpenEXR.tiledimage, "tiles": tiles()},
            ),
            colour(np.float16),
        ),
        "key-code": (
            header(OpenEXR.ZIP_COMPRESSION, keyCode=OpenEXR.KeyCode(1, 2, 3, 4, 5, 6, 20)),
            colour(np.float16),
        ),
    }
    paths = []
    for name, (head, channels) in whole.items():
        path = folder / f"{name}.exr"
        OpenEXR.File(head, channels).write(str(path))
        paths.append(path)
    parts = [
        OpenEXR.Part(header(OpenEXR.ZIP_COMPRESSION), colour(np.float16), "beauty"),
        OpenEXR.Part(header(OpenEXR.ZIPS_COMPRESSION), {"Z": noise(20, np.float32)}, "depth"),
        OpenEXR.Part(header(OpenEXR.PIZ_COMPRESSION, **CRYPTO), {"id": noise(21, np.uint32)}, "ids"),
    ]
    path = folder / "parts.exr"
    OpenEXR.File(parts).write(str(path))
    return [*paths, path]


def tiles():
    description = OpenEXR.TileDescription()
    description.xSize, description.ySize = 16, 8
    return description


def same(a, b):
    """Whether two attribute values are equal."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return np.array_equal(np.asarray(a), np.asarray(b))
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b))
    if type(a).__module__.startswith("OpenEXR") and not isinstance(a, (int, str)):
        return type(a) is type(b) and (a == b or str(a) == str(b))
    return a == b


def differences(before, after):
    """Differences between two files: unexpected ones, and documented ones."""
    wrong, expected = [], []
    before, after = (OpenEXR.File(str(p), separate_channels=True) for p in (before, after))
    if len(before.parts) != len(after.parts):
        return [f"{len(before.parts)} parts are {len(after.parts)}"], expected
    for old, new in zip(before.parts, after.parts):
        is_lossy = old.header["compression"] in LOSSY
        for name in sorted(set(old.header) | set(new.header)):
            if name in ADDED or name == "channels":
                continue
            if name == "compression" and is_lossy:
                expected.append("lossy compression becomes ZIP")
            elif name not in old.header or name not in new.header:
                wrong.append(f"{name} is in one only")
            elif not same(old.header[name], new.header[name]):
                wrong.append(f"{name}: {old.header[name]} is {new.header[name]}")
        if set(old.channels) != set(new.channels):
            wrong.append(f"channels {set(old.channels) ^ set(new.channels)}")
            continue
        for name, channel in old.channels.items():
            pixels = new.channels[name].pixels
            if channel.pixels.dtype != pixels.dtype or channel.pixels.tobytes() != pixels.tobytes():
                wrong.append(f"pixels of {name}")
    return wrong, sorted(set(expected))


def main(seidel, lens, *plates):
    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for path in [*files(folder), *map(Path, plates)]:
            out = folder / f"out-{path.name}"
            line = [seidel, "apply", path, "-o", out, "--lens", lens, "--distance", "2", "--amount", "0"]
            done = subprocess.run([*line, "--no-provenance"], capture_output=True, text=True, check=False)
            wrong, expected = [done.stderr.strip()], []
            if done.returncode == 0:
                wrong, expected = differences(path, out)
            bad += bool(wrong)
            state = "differs" if wrong else "same"
            print(f"{path.name:32} {state} {'; '.join(wrong + expected)}")
    return 1 if bad else 0


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
