"""Reads the outputs of a case as numbers: what is hashed, and what is kept for later comparison.

Every reader returns an `Output`: the bytes to hash, and the numbers by path or the samples by channel.
"""

import hashlib
import json
import re
import struct
import zlib
from array import array
from dataclasses import dataclass, field

import exr

# Strings in JSON that are part of the format. All others are prose, names of files or of the program, and may change.
IDENTIFIERS = {
    "added",
    "channel",
    "effect",
    "effects",
    "equivalents",
    "format",
    "id",
    "kind",
    "name",
    "verdict",
}
# Numbers that differ from run to run.
VOLATILE = {"seconds"}


@dataclass
class Output:
    """The content of an output file."""

    hashed: bytes
    numbers: dict = field(default_factory=dict)
    samples: dict = field(default_factory=dict)

    def sha256(self):
        return hashlib.sha256(self.hashed).hexdigest()


def read(path):
    """Returns the content of an output file, or None where it holds prose or lettering and is not compared."""
    readers = {
        ".exr": _read_exr,
        ".json": _read_json,
        ".png": _read_png,
        ".dpx": _read_dpx,
        ".tif": _read_tiff,
        ".hdr": _read_hdr,
        ".cube": _read_table,
        ".spi1d": _read_table,
        ".bin": _read_bytes,
    }
    reader = readers.get(path.suffix)
    return reader(path) if reader else None


def joined(outputs):
    """Returns several pictures as one output; the samples of a channel follow each other."""
    samples = {}
    for output in outputs:
        for channel, values in output.samples.items():
            samples.setdefault(channel, array(values.typecode)).extend(values)
    return Output(b"".join(output.hashed for output in outputs), samples=samples)


def _read_exr(path):
    hashed = bytearray()
    samples = {}
    for part in exr.read(path):
        shape = [part.name, part.data_window, part.display_window, part.pixel_aspect]
        hashed += json.dumps(shape).encode()
        for channel in part.channels:
            hashed += json.dumps([channel.name, channel.kind]).encode() + channel.samples
            name = f"{part.name}.{channel.name}" if part.name else channel.name
            samples[name] = exr.floats(channel)
    return Output(bytes(hashed), samples=samples)


def _read_json(path):
    numbers = {}
    _flatten("", json.loads(path.read_text(encoding="utf-8")), numbers)
    return _of_numbers(numbers)


def _of_numbers(numbers):
    lines = (f"{name} {_written(value)}\n" for name, value in sorted(numbers.items()))
    return Output("".join(lines).encode(), numbers=numbers)


def _written(value):
    return repr(value) if isinstance(value, float) else json.dumps(value)


def _flatten(path, value, numbers, identifier=False):
    """Stores the numbers, truth values, nulls and identifiers below `path`."""
    if isinstance(value, dict):
        for key, item in value.items():
            if key not in VOLATILE:
                _flatten(f"{path}/{key}", item, numbers, key in IDENTIFIERS)
    elif isinstance(value, list):
        numbers[f"{path}#"] = float(len(value))
        for index, item in enumerate(value):
            _flatten(f"{path}/{index}", item, numbers, identifier)
    elif isinstance(value, str):
        if identifier:
            numbers[path] = value
    elif value is None or isinstance(value, bool):
        numbers[path] = value
    else:
        numbers[path] = float(value)


def _read_table(path):
    """Look-up tables as text: the rows of numbers, and keywords followed by numbers."""
    numbers = {}
    for row, line in enumerate(path.read_text(encoding="utf-8").splitlines()):
        keyword = re.match(r"[A-Za-z_0-9]*[A-Za-z_]\s", line)
        if line.startswith(("#", "TITLE")):
            continue
        for column, word in enumerate(line.split()):
            try:
                value = float(word)
            except ValueError:
                continue
            place = keyword.group().strip() if keyword else str(row)
            numbers[f"/{place}/{column}"] = value
    return _of_numbers(numbers)


def _read_bytes(path):
    """32-bit floats, little-endian."""
    data = path.read_bytes()
    values = array("f")
    values.frombytes(data)
    return Output(data, samples={"values": values})


def _read_png(path):
    """The decoded pixels of a PNG of 8 or 16 bits, not interlaced."""
    data = path.read_bytes()
    at = 8
    packed = bytearray()
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height, bits, colour, _, _, interlaced = struct.unpack_from(">IIBBBBB", data, at + 8)
        elif kind == b"IDAT":
            packed += data[at + 8 : at + 8 + size]
        at += 12 + size
    channels = {0: 1, 2: 3, 4: 2, 6: 4}.get(colour)
    if channels is None or bits < 8 or interlaced:
        raise ValueError(f"{path}: a PNG of a kind that cannot be read")
    pixel = channels * bits // 8
    pixels = _unfiltered(zlib.decompress(packed), width * pixel, height, pixel)
    shape = struct.pack("<IIII", width, height, bits, channels)
    values = array("H", pixels) if bits == 8 else array("H", struct.unpack(f">{len(pixels) // 2}H", pixels))
    return Output(shape + pixels, samples={"codes": values})


def _unfiltered(raw, stride, height, pixel):
    rows = bytearray()
    before = bytearray(stride)
    for row in range(height):
        start = row * (stride + 1)
        kind, line = raw[start], bytearray(raw[start + 1 : start + 1 + stride])
        for k in range(stride if kind else 0):
            left = line[k - pixel] if k >= pixel else 0
            up = before[k]
            if kind == 1:
                guess = left
            elif kind == 2:
                guess = up
            elif kind == 3:
                guess = (left + up) >> 1
            else:
                corner = before[k - pixel] if k >= pixel else 0
                guess = _paeth(left, up, corner)
            line[k] = (line[k] + guess) & 255
        rows += line
        before = line
    return bytes(rows)


def _paeth(left, up, corner):
    by_left, by_up, by_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
    if by_left <= by_up and by_left <= by_corner:
        return left
    return up if by_up <= by_corner else corner


def _read_dpx(path):
    """The image data of a DPX file; headers hold names and dates."""
    data = path.read_bytes()
    order = ">" if data[:4] == b"SDPX" else "<"
    (offset,) = struct.unpack_from(f"{order}I", data, 4)
    return Output(data[772:780] + data[offset:])


def _read_hdr(path):
    """The resolution line and pixels of a Radiance file."""
    data = path.read_bytes()
    return Output(data[data.index(b"\n\n") + 2 :])


def _read_tiff(path):
    """The decoded strips of a TIFF, uncompressed or deflated."""
    data = path.read_bytes()
    order = "<" if data[:2] == b"II" else ">"
    (at,) = struct.unpack_from(f"{order}I", data, 4)
    (count,) = struct.unpack_from(f"{order}H", data, at)
    tags = {}
    for entry in range(at + 2, at + 2 + 12 * count, 12):
        tag, kind, length = struct.unpack_from(f"{order}HHI", data, entry)
        letter = {3: "H", 4: "I"}.get(kind)
        if letter:
            size = struct.calcsize(letter) * length
            place = entry + 8 if size <= 4 else struct.unpack_from(f"{order}I", data, entry + 8)[0]
            tags[tag] = struct.unpack_from(f"{order}{length}{letter}", data, place)
    hashed = json.dumps([tags.get(tag) for tag in (256, 257, 258, 277, 317, 339)]).encode()
    for offset, size in zip(tags[273], tags[279]):
        strip = data[offset : offset + size]
        compression = tags[259][0]
        if compression in (8, 32946):
            strip = zlib.decompress(strip)
        elif compression != 1:
            raise ValueError(f"{path}: TIFF compression {compression} cannot be read")
        hashed += strip
    return Output(hashed)
