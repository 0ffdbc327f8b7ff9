"""OpenEXR files, written without compression and read with none or ZIP: enough to exchange samples with the command, without
another package."""

import struct
import zlib

import numpy as np

# By compression: none, ZIP of single rows, ZIP.
ROWS_OF_CHUNK = {0: 1, 2: 1, 3: 16}
SAMPLE_TYPES = {np.dtype("float16"): 1, np.dtype("float32"): 2}


def write(path, channels, display_window=None):
    """Writes ``channels``, arrays of rows x columns by name, all of one sample type.

    ``display_window`` is (x, y, width, height) in pixels from the corner of the arrays, or that of the arrays.
    """
    names = sorted(channels)
    planes = [np.ascontiguousarray(channels[name]) for name in names]
    height, width = planes[0].shape
    listing = b"".join(
        name.encode() + b"\0" + struct.pack("<iB3xii", SAMPLE_TYPES[plane.dtype], 0, 1, 1)
        for name, plane in zip(names, planes)
    )
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    x, y, columns, rows_shown = display_window or (0, 0, width, height)
    display = struct.pack("<4i", x, y, x + columns - 1, y + rows_shown - 1)
    attributes = [
        ("channels", "chlist", listing + b"\0"),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", display),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    ]
    head = struct.pack("<II", 20000630, 2)
    for name, kind, value in attributes:
        head += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    head += b"\0"
    rows = [b"".join(plane[y].tobytes() for plane in planes) for y in range(height)]
    first = len(head) + 8 * height
    step = 8 + len(rows[0])
    offsets = struct.pack(f"<{height}Q", *(first + step * y for y in range(height)))
    lines = b"".join(struct.pack("<ii", y, len(row)) + row for y, row in enumerate(rows))
    path.write_bytes(head + offsets + lines)


def read(path):
    """Returns the channels of a file, arrays of rows x columns by name."""
    data = path.read_bytes()
    assert struct.unpack_from("<II", data) == (20000630, 2)
    at, attributes = 8, {}
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    rows_of_chunk = ROWS_OF_CHUNK[attributes["compression"][0]]
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    channels = _channels(attributes["channels"])
    planes = {name: np.empty((height, width), kind) for name, kind in channels}
    row_size = width * sum(kind.itemsize for _, kind in channels)
    chunks = -(-height // rows_of_chunk)
    for offset in struct.unpack_from(f"<{chunks}Q", data, at + 1):
        y, size = struct.unpack_from("<ii", data, offset)
        rows = min(rows_of_chunk, bottom + 1 - y)
        samples = _unpacked(data[offset + 8 : offset + 8 + size], rows * row_size)
        at_sample = 0
        for row in range(y - top, y - top + rows):
            for name, kind in channels:
                planes[name][row] = np.frombuffer(samples, kind, width, at_sample)
                at_sample += width * kind.itemsize
    return planes


def _unpacked(chunk, size):
    """Returns the samples of a chunk, which is smaller than they are if it is compressed."""
    if len(chunk) == size:
        return chunk
    steps = np.frombuffer(zlib.decompress(chunk), np.uint8).astype(np.int64)
    steps[1:] -= 128
    halves = np.cumsum(steps).astype(np.uint8)
    whole = np.empty(size, np.uint8)
    whole[::2], whole[1::2] = halves[: (size + 1) // 2], halves[(size + 1) // 2 :]
    return whole.tobytes()


def write_image(path, image, display_window=None):
    """Writes an array of rows x columns x channels as Y, YA, RGB or RGBA."""
    planes = {name: image[..., k] for k, name in enumerate(_names(image.shape[2]))}
    write(path, planes, display_window)


def read_image(path, channels):
    """Returns an image of so many ``channels`` as an array of rows x columns x channels."""
    planes = read(path)
    return np.stack([planes[name] for name in _names(channels)], axis=-1)


def _names(channels):
    return {1: ["Y"], 2: ["Y", "A"], 3: ["R", "G", "B"], 4: ["R", "G", "B", "A"]}[channels]


def _channels(listing):
    at, channels = 0, []
    while listing[at]:
        name, at = _text(listing, at)
        (kind,) = struct.unpack_from("<i", listing, at)
        kinds = {number: dtype for dtype, number in SAMPLE_TYPES.items()}
        channels.append((name, kinds[kind]))
        at += 16
    return channels


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1
