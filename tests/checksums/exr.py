"""Reads and writes OpenEXR files: scan lines and single-level tiles, uncompressed or packed with RLE, ZIPS or ZIP."""

import math
import struct
import zlib
from array import array
from dataclasses import dataclass
from itertools import accumulate

UINT, HALF, FLOAT = 0, 1, 2
BYTES = {UINT: 4, HALF: 2, FLOAT: 4}
# Scan lines in a chunk, by compression.
NONE, RLE, ZIPS, ZIP = 0, 1, 2, 3
LINES = {NONE: 1, RLE: 1, ZIPS: 1, ZIP: 16}

TILED, DEEP, MULTIPART = 0x200, 0x800, 0x1000
FLIP_HIGH_BIT = bytes(value ^ 0x80 for value in range(256))


@dataclass
class Channel:
    """A channel: its name, the type of its samples, and the samples, row by row, little-endian."""

    name: str
    kind: int
    samples: bytes


@dataclass
class Part:
    """A part of a file. Windows are (left, top, right, bottom), inclusive."""

    name: str
    data_window: tuple
    display_window: tuple
    pixel_aspect: float
    channels: list

    @property
    def width(self):
        return self.data_window[2] - self.data_window[0] + 1

    @property
    def height(self):
        return self.data_window[3] - self.data_window[1] + 1

    def floats(self, name):
        """Returns the samples of the channel `name` as an array of 32-bit floats."""
        channel = next(one for one in self.channels if one.name == name)
        return floats(channel)


def floats(channel):
    """Returns the samples of a channel as an array of 32-bit floats, or of unsigned integers for a UINT channel."""
    if channel.kind == HALF:
        count = len(channel.samples) // 2
        return array("f", struct.unpack(f"<{count}e", channel.samples))
    values = array("f" if channel.kind == FLOAT else "I")
    values.frombytes(channel.samples)
    return values


def read(path):
    """Returns the parts of the file at `path`."""
    data = path.read_bytes()
    magic, version = struct.unpack_from("<II", data)
    if magic != 20000630:
        raise ValueError(f"{path}: not an OpenEXR file")
    if version & DEEP:
        raise ValueError(f"{path}: deep data cannot be read")
    at = 8
    headers = []
    while True:
        header, at = _header(data, at)
        if not header:
            break
        headers.append(header)
        if not version & MULTIPART:
            break
    tiled = bool(version & TILED)
    return _read_chunks(path, data, at, headers, bool(version & MULTIPART), tiled)


def _header(data, at):
    attributes = {}
    while data[at]:
        end = data.index(b"\0", at)
        name = data[at:end].decode()
        at = end + 1
        end = data.index(b"\0", at)
        at = end + 1
        (size,) = struct.unpack_from("<i", data, at)
        at += 4
        attributes[name] = data[at : at + size]
        at += size
    return attributes, at + 1


def _channel_list(value):
    channels = []
    at = 0
    while value[at]:
        end = value.index(b"\0", at)
        kind, _, across, down = struct.unpack_from("<iIii", value, end + 1)
        if (across, down) != (1, 1):
            raise ValueError("subsampled channels cannot be read")
        channels.append((value[at:end].decode(), kind))
        at = end + 17
    return channels


class _Plane:
    """A part while its chunks are read."""

    def __init__(self, header, multipart, tiled):
        self.window = struct.unpack("<4i", header["dataWindow"])
        self.display = struct.unpack("<4i", header["displayWindow"])
        self.aspect = struct.unpack("<f", header["pixelAspectRatio"])[0]
        self.compression = header["compression"][0]
        if self.compression not in LINES:
            raise ValueError(f"compression {self.compression} cannot be read")
        self.name = header.get("name", b"").decode()
        self.channels = _channel_list(header["channels"])
        self.width = self.window[2] - self.window[0] + 1
        self.height = self.window[3] - self.window[1] + 1
        self.tile = None
        if header.get("type", b"") == b"tiledimage" if multipart else tiled:
            across, down, mode = struct.unpack("<IIB", header["tiles"])
            if mode & 15:
                raise ValueError("mip maps cannot be read")
            self.tile = (across, down)
        self.rows = {name: bytearray(self.width * self.height * BYTES[kind]) for name, kind in self.channels}

    def chunks(self):
        """Returns how many chunks the part has."""
        if self.tile:
            return math.ceil(self.width / self.tile[0]) * math.ceil(self.height / self.tile[1])
        return math.ceil(self.height / LINES[self.compression])

    def put(self, left, top, width, height, packed):
        """Stores the samples of a block; `left` and `top` count from the data window's corner."""
        size = sum(BYTES[kind] for _, kind in self.channels) * width * height
        raw = packed if len(packed) == size else _unpacked(self.compression, packed)
        if len(raw) != size:
            raise ValueError("a chunk is cut short")
        at = 0
        for row in range(top, top + height):
            for name, kind in self.channels:
                length = width * BYTES[kind]
                place = (row * self.width + left) * BYTES[kind]
                self.rows[name][place : place + length] = raw[at : at + length]
                at += length

    def part(self):
        channels = [Channel(name, kind, bytes(self.rows[name])) for name, kind in self.channels]
        return Part(self.name, self.window, self.display, self.aspect, channels)


def _read_chunks(path, data, at, headers, multipart, tiled):
    try:
        planes = [_Plane(header, multipart, tiled) for header in headers]
        total = sum(plane.chunks() for plane in planes)
        for offset in struct.unpack_from(f"<{total}Q", data, at):
            plane = planes[0]
            if multipart:
                plane = planes[struct.unpack_from("<i", data, offset)[0]]
                offset += 4
            if plane.tile:
                column, row, _, _, size = struct.unpack_from("<5i", data, offset)
                offset += 20
                left, top = column * plane.tile[0], row * plane.tile[1]
                width = min(plane.tile[0], plane.width - left)
                height = min(plane.tile[1], plane.height - top)
            else:
                line, size = struct.unpack_from("<2i", data, offset)
                offset += 8
                left, top, width = 0, line - plane.window[1], plane.width
                height = min(LINES[plane.compression], plane.height - top)
            plane.put(left, top, width, height, data[offset : offset + size])
    except ValueError as why:
        raise ValueError(f"{path}: {why}") from why
    return [plane.part() for plane in planes]


def _unpacked(compression, packed):
    if compression == RLE:
        encoded = _run_lengths(packed)
    else:
        encoded = zlib.decompress(packed)
    # Each byte is stored as its difference to the one before, plus 128. In a running sum these offsets cancel at even
    # places and flip the highest bit at odd ones.
    sums = array("Q", accumulate(encoded)).tobytes()
    plain = bytearray(sums[::8])
    plain[1::2] = plain[1::2].translate(FLIP_HIGH_BIT)
    half = (len(plain) + 1) // 2
    woven = bytearray(len(plain))
    woven[::2] = plain[:half]
    woven[1::2] = plain[half:]
    return bytes(woven)


def _run_lengths(packed):
    out = bytearray()
    at = 0
    while at < len(packed):
        count = struct.unpack_from("<b", packed, at)[0]
        if count < 0:
            out += packed[at + 1 : at + 1 - count]
            at += 1 - count
        else:
            out += packed[at + 1 : at + 2] * (count + 1)
            at += 2
    return out


def write(path, width, height, channels):
    """Writes an uncompressed file of one part; `channels` has an array of floats for each name."""
    names = sorted(channels)
    listed = b"".join(name.encode() + b"\0" + struct.pack("<iIii", FLOAT, 0, 1, 1) for name in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = [
        ("channels", "chlist", listed),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    ]
    head = struct.pack("<II", 20000630, 2)
    for name, kind, value in attributes:
        head += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    head += b"\0"
    line = 8 + 4 * width * len(names)
    first = len(head) + 8 * height
    table = struct.pack(f"<{height}Q", *(first + line * row for row in range(height)))
    body = bytearray()
    planes = [array("f", channels[name]).tobytes() for name in names]
    for row in range(height):
        body += struct.pack("<2i", row, 4 * width * len(names))
        for plane in planes:
            body += plane[4 * width * row : 4 * width * (row + 1)]
    path.write_bytes(head + table + body)
