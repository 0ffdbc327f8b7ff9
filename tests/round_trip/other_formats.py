"""Checks with another reader that `seidel apply --amount 0` keeps samples and metadata of DPX, HDR, PNG and TIFF files.

Writes files of different kinds with OpenImageIO (PyPI OpenImageIO and numpy), runs the command on each, and compares
input and output as OpenImageIO reads them. Also converts an EXR to DPX and back. Prints one line per file; exit status 1
if anything differs or is refused.

    python3 tests/round_trip/other_formats.py target/release/seidel LENS.json
"""

import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

WIDTH, HEIGHT = 53, 37

# Storage attributes, which may change: TIFF is written as deflated strips (docs/guide/files.md).
STORAGE = {
    "compression",
    "planarconfig",
    "oiio:RowsPerChunk",
    "tiff:Compression",
    "tiff:PlanarConfiguration",
    "tiff:RowsPerStrip",
    "tiff:Predictor",
}


def typed(kind, value):
    """A value of a type that Python has no class for."""
    return (oiio.TypeDesc(kind), value)


TIME = {"smpte:TimeCode": typed("timecode", (0x01020344, 0x12345678))}
USUAL = {
    "Copyright": "nobody",
    "DateTime": "2026:11:22 10:00:00",
    "Software": "a test",
    "DocumentName": "a document",
    "ImageDescription": "a description",
}
SIZE = {"XResolution": 300.5, "YResolution": 299.0, "ResolutionUnit": "in", "PixelAspectRatio": 299.0 / 300.5}
DPX = {
    **USUAL,
    **TIME,
    "smpte:KeyCode": typed("keycode", (1, 2, 345678, 9, 10, 4, 64)),
    "dpx:FrameRate": 24.0,
    "dpx:TemporalFrameRate": 24.0,
    "dpx:ShutterAngle": 172.8,
    "dpx:InputDevice": "a camera",
    "dpx:InputDeviceSerialNumber": "007",
    "dpx:SlateInfo": "slate",
    "dpx:SourceDateTime": "2025:01:02 03:04:05",
}
TIFF = {
    **USUAL,
    **SIZE,
    "Artist": "an artist",
    "Make": "a maker",
    "Model": "a model",
    "HostComputer": "a computer",
    "Exif:LensModel": "a lens",
    "ExposureTime": 0.02,
    "GPS:LatitudeRef": "N",
}


def samples(seed, channels, lift=0.0):
    """Random samples, 0 to 1; with `lift` also negative ones and some above one."""
    rng = np.random.default_rng(seed)
    values = rng.random((HEIGHT, WIDTH, channels))
    return (values * (1 + 3 * lift) - lift).astype(np.float32)


def write(path, kind, channels, attributes, bits=None, tile=None, lift=0.0):
    """Writes a file by OpenImageIO; returns its path."""
    spec = oiio.ImageSpec(WIDTH, HEIGHT, channels, kind)
    if channels == 2:
        spec.channelnames, spec.alpha_channel = ("Y", "A"), 1
    if tile:
        spec.tile_width = spec.tile_height = tile
    if bits:
        spec.attribute("oiio:BitsPerSample", bits)
    for name, value in attributes.items():
        if isinstance(value, tuple):
            spec.attribute(name, *value)
        elif value is not None:
            spec.attribute(name, value)
    out = oiio.ImageOutput.create(str(path))
    if not out.open(str(path), spec):
        raise RuntimeError(f"{path.name}: {out.geterror()}")
    full = samples(hash_of(path.name), channels, lift)
    done = out.write_image(full)
    out.close()
    if not done:
        raise RuntimeError(f"{path.name}: {out.geterror()}")
    return path


def hash_of(name):
    """A seed that depends on the name only."""
    return sum(ord(letter) * (at + 1) for at, letter in enumerate(name))


def half_tiff(path):
    """Writes a TIFF of half floats, which OpenImageIO would write as floats; returns its path."""
    halves = samples(7, 3, 1.0).astype("<f2").tobytes()
    text = b"half floats\0"
    entries = [
        (256, 4, 1, WIDTH),
        (257, 4, 1, HEIGHT),
        (258, 3, 3, None),
        (259, 3, 1, 1),
        (262, 3, 1, 2),
        (270, 2, len(text), None),
        (273, 4, 1, None),
        (277, 3, 1, 3),
        (278, 4, 1, HEIGHT),
        (279, 4, 1, len(halves)),
        (339, 3, 3, None),
    ]
    beside = 8 + 2 + len(entries) * 12 + 4
    places = {258: beside, 339: beside + 6, 270: beside + 12, 273: beside + 12 + len(text)}
    file = b"II*\0" + struct.pack("<IH", 8, len(entries))
    for tag, kind, count, value in entries:
        file += struct.pack("<HHII", tag, kind, count, places.get(tag, value))
    file += bytes(4) + struct.pack("<6H", 16, 16, 16, 3, 3, 3) + text + halves
    path.write_bytes(file)
    return path


def files(folder):
    """Writes files of different kinds; returns their paths."""
    paths = []
    for bits in (8, 10, 12, 16):
        kind = "uint8" if bits == 8 else "uint16"
        for order in ("big", "little"):
            for channels, name in ((1, "y"), (3, "rgb"), (4, "rgba")):
                for packing in ("Filled, method A", "Filled, method B", "Packed"):
                    if bits in (8, 16) and packing != "Filled, method A":
                        continue
                    path = folder / f"{bits}-{name}-{order}-{packing[-1].lower()}.dpx"
                    more = {"oiio:Endian": order, "dpx:Packing": packing}
                    paths.append(write(path, kind, channels, {**DPX, **more}, bits))
    paths.append(write(folder / "rgb.hdr", "float", 3, {"Software": "a test", "hdr:exposure": 1.0}))
    names = {1: "y", 2: "ya", 3: "rgb", 4: "rgba"}
    spaces = {"srgb": "srgb_rec709_scene", "linear": "lin_rec709_scene", "gamma": "g22_rec709_scene", "none": None}
    for channels, name in names.items():
        for kind in ("uint8", "uint16"):
            for suffix, space in spaces.items():
                attributes = {**USUAL, **SIZE, "oiio:ColorSpace": space}
                path = folder / f"{kind}-{name}-{suffix}.png"
                paths.append(write(path, kind, channels, attributes))
    for channels, name in names.items():
        for kind in ("uint8", "uint16", "float"):
            for tile in (None, 16):
                stored = "tiles" if tile else "strips"
                path = folder / f"{kind}-{name}-{stored}.tif"
                lift = 1.0 if kind == "float" else 0.0
                packed = {"compression": "lzw" if tile else "zip"}
                paths.append(write(path, kind, channels, {**TIFF, **packed}, tile=tile, lift=lift))
    plain = {"compression": "none", "planarconfig": "separate"}
    paths.append(write(folder / "planes.tif", "uint16", 3, {**plain, "ResolutionUnit": "cm", "XResolution": 10.0}))
    paths.append(write(folder / "bare.tif", "uint16", 3, {}))
    paths.append(half_tiff(folder / "half.tif"))
    return paths


def read(path):
    """Shape, stored samples and attributes of a file."""
    plain = oiio.ImageSpec()
    plain.attribute("oiio:UnassociatedAlpha", 1)
    file = oiio.ImageInput.open(str(path), plain)
    if file is None:
        raise RuntimeError(f"{path.name}: {oiio.geterror()}")
    spec = file.spec()
    pixels = file.read_image(spec.format)
    attributes = {own.name: (str(own.type), own.value) for own in spec.extra_attribs}
    shape = (str(spec.format), spec.width, spec.height, tuple(spec.channelnames), spec.alpha_channel)
    file.close()
    return shape, pixels, attributes


def same(a, b):
    """Whether two attribute values are equal."""
    if isinstance(a[1], np.ndarray) or isinstance(b[1], np.ndarray):
        return a[0] == b[0] and np.array_equal(a[1], b[1])
    return a == b


def differences(before, after):
    """Differences between two files, and the number of attributes compared."""
    (shape, pixels, attributes), (new_shape, new_pixels, new_attributes) = read(before), read(after)
    wrong = []
    if shape != new_shape:
        wrong.append(f"{shape} is {new_shape}")
    elif pixels.tobytes() != new_pixels.tobytes():
        wrong.append(f"{np.count_nonzero(pixels != new_pixels)} samples")
    for name in sorted((set(attributes) | set(new_attributes)) - STORAGE):
        if name not in attributes or name not in new_attributes:
            wrong.append(f"{name} is in one only")
        elif not same(attributes[name], new_attributes[name]):
            wrong.append(f"{name}: {attributes[name][1]} is {new_attributes[name][1]}")
    return wrong, len(attributes)


def through_dpx(folder, run):
    """Converts an EXR to DPX and back; returns the attributes that changed."""
    attributes = {
        **TIME,
        "FramesPerSecond": typed("rational", (24000, 1001)),
        "Copyright": "nobody",
        "DateTime": "2026:11:22 10:00:00",
        "cameraModel": "a camera",
        "cameraSerialNumber": "007",
        "PixelAspectRatio": 2.0,
    }
    first = write(folder / "first.exr", "half", 3, attributes)
    dpx, last = folder / "through.dpx", folder / "last.exr"
    problem = run(first, dpx) or run(dpx, last)
    if problem:
        return [problem]
    (_, _, one), (_, _, two), (_, _, three) = read(first), read(dpx), read(last)
    # OpenImageIO writes this attribute under another name than it reads.
    names = {name: name for name in attributes} | {"FramesPerSecond": "framesPerSecond"}
    nothing = ("", None)
    wrong = [f"EXR {name}" for name, new in names.items() if not same(one[name], three.get(new, nothing))]
    for name in ("smpte:TimeCode", "Copyright", "DateTime", "PixelAspectRatio"):
        if not same(one[name], two.get(name, nothing)):
            wrong.append(f"DPX {name}")
    rate = np.float32(24000 / 1001)
    for name in ("dpx:FrameRate", "dpx:TemporalFrameRate"):
        if np.float32(two.get(name, ("", 0.0))[1]) != rate:
            wrong.append(f"DPX {name}")
    if two.get("dpx:InputDevice", ("", ""))[1] != "a camera":
        wrong.append("DPX dpx:InputDevice")
    return wrong


def main(seidel, lens):
    def run(source, target):
        line = [seidel, "apply", source, "-o", target, "--lens", lens, "--distance", "2", "--amount", "0"]
        done = subprocess.run([*line, "--no-provenance"], capture_output=True, text=True, check=False)
        return done.stderr.strip() if done.returncode else ""

    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for path in files(folder):
            out = folder / f"out-{path.name}"
            problem = run(path, out)
            if problem:
                state, wrong, bad = "fails", [problem], bad + 1
            else:
                wrong, count = differences(path, out)
                state, bad = ("differs", bad + 1) if wrong else ("same", bad)
                wrong = wrong or [f"{count} attributes"]
            print(f"{path.name:28} {state:8} {'; '.join(wrong)}")
        wrong = through_dpx(folder, run)
        bad += bool(wrong)
        print(f"{'EXR to DPX and back':28} {'differs' if wrong else 'same':8} {'; '.join(wrong)}")
    return 1 if bad else 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
