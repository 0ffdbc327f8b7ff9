"""Calls libseidel through its C ABI and writes what it returns as files of 32-bit floats and JSON.

    c_abi.py kernels LIBRARY LENS OUT     kernels on a grid of field positions, by channel and distance
    c_abi.py plates LIBRARY LENS OUT PLATE.exr      apply in several forms, on a plate with R, G, B and Z
    c_abi.py removal LIBRARY LENS OTHER OUT PLATE.exr      remove and relens

The structures are those of plugin/include/seidel.h; those that a render needs are imported from plugin/examples/apply.py.
"""

import ctypes as c
import json
import math
import struct
import sys
from array import array
from pathlib import Path

import exr

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "plugin" / "examples"))
from apply import Image, Plate, Rect, Settings

FLOAT, HALF = 2, 1
TOO_SMALL = 7


class Kernel(c.Structure):
    _fields_ = [
        ("size", c.c_uint64), ("weights", c.POINTER(c.c_float)), ("capacity", c.c_uint64),
        ("left", c.c_int32), ("top", c.c_int32), ("width", c.c_uint32), ("height", c.c_uint32),
    ]


class LensInfo(c.Structure):
    _fields_ = [
        ("size", c.c_uint64), ("kind", c.c_uint32), ("channels", c.c_uint32), ("models", c.c_uint32),
        ("knows_depth", c.c_uint32), ("frame_width", c.c_uint32), ("frame_height", c.c_uint32),
        ("axis_x", c.c_double), ("axis_y", c.c_double), ("pixel_pitch_um", c.c_double),
        ("focal_length_mm", c.c_double), ("f_number", c.c_double), ("focus_distance", c.c_double),
        ("nearest", c.c_double), ("farthest", c.c_double),
    ]


class Findings(c.Structure):
    _fields_ = [
        ("size", c.c_uint64), ("confidence", c.POINTER(Image)), ("noise_gain", c.POINTER(Image)), ("found", Rect),
        ("noise", c.c_double * 3), ("misfit", c.c_double * 3), ("clip_level", c.c_double * 3),
        ("clipped", c.c_uint64 * 3),
    ]


def sized(kind, **values):
    return kind(size=c.sizeof(kind), **values)


class Library:
    """The library, with every status checked."""

    def __init__(self, path):
        self.calls = c.CDLL(path)
        self.calls.seidel_last_error.restype = c.c_size_t

    def call(self, name, *arguments, allowed=()):
        status = getattr(self.calls, name)(*arguments)
        if status != 0 and status not in allowed:
            text = c.create_string_buffer(1024)
            self.calls.seidel_last_error(text, c.c_size_t(len(text)))
            sys.exit(f"{name}: status {status}: {text.value.decode()}")
        return status

    def lens(self, path):
        handle = c.c_void_p()
        self.call("seidel_lens_open", path.encode(), c.byref(handle))
        return handle

    def settings(self, **values):
        settings = sized(Settings)
        self.call("seidel_settings_init", c.byref(settings))
        for name, value in values.items():
            setattr(settings, name, value)
        return settings


def finite(value):
    """Returns the value, or None where it is not finite and JSON has no number for it."""
    return value if math.isfinite(value) else None


class Buffer:
    """Interleaved 32-bit samples of `channels` planes over a rectangle."""

    def __init__(self, rect, channels, planes=None):
        self.rect = rect
        self.channels = channels
        count = rect.width * rect.height
        self.values = (c.c_float * (count * channels))()
        for index, plane in enumerate(planes or []):
            self.values[index::channels] = plane.tolist()

    def image(self):
        row = 4 * self.channels * self.rect.width
        return sized(Image, data=c.addressof(self.values), row_bytes=row, pixel_bytes=0, channels=self.channels,
                     sample=FLOAT, rect=self.rect)

    def flipped(self):
        """Returns the image with rows stored from the bottom up."""
        image = self.image()
        image.data += image.row_bytes * (self.rect.height - 1)
        image.row_bytes = -image.row_bytes
        return image

    def write(self, path):
        path.write_bytes(bytes(self.values))


def halves(buffer):
    """Returns an image of 16-bit samples with the values of `buffer`, and the memory it needs."""
    memory = c.create_string_buffer(struct.pack(f"<{len(buffer.values)}e", *buffer.values))
    image = buffer.image()
    image.data, image.row_bytes, image.sample = c.addressof(memory), image.row_bytes // 2, HALF
    return image, memory


def kernels(library, lens_path, out):
    """Draws kernels at three by two field positions of a frame of 960 by 540, by each model."""
    out = Path(out)
    library = Library(library)
    lens = library.lens(lens_path)
    info = sized(LensInfo)
    library.call("seidel_lens_info", lens, c.byref(info))
    numbers = {name: finite(getattr(info, name)) for name, _ in LensInfo._fields_[1:]}
    (out / "info.json").write_text(json.dumps(numbers))
    frame = Rect(0, 0, 960, 540)
    plate = sized(Plate, format=frame, extent=frame)
    shapes = {}
    weights = array("f")
    models = [model_name(library, lens, index) for index in range(info.models)]
    for model in models:
        settings = library.settings(psf_model=model.encode())
        for channel in range(info.channels):
            for distance in (1.5, 2.5, 6.0, math.inf):
                for row in range(2):
                    for column in range(3):
                        x, y = 960 * (column + 0.37) / 3, 540 * (row + 0.71) / 2
                        kernel = sized(Kernel)
                        arguments = (lens, c.byref(settings), c.byref(plate), c.c_uint32(channel), c.c_double(x),
                                     c.c_double(y), c.c_double(distance), c.byref(kernel))
                        library.call("seidel_kernel", *arguments, allowed=(TOO_SMALL,))
                        room = (c.c_float * (kernel.width * kernel.height))()
                        kernel.weights, kernel.capacity = room, len(room)
                        library.call("seidel_kernel", *arguments)
                        key = f"{model} {channel} {distance} {column} {row}"
                        shapes[key] = [kernel.left, kernel.top, kernel.width, kernel.height]
                        weights.extend(room)
    (out / "kernels.bin").write_bytes(weights.tobytes())
    (out / "shapes.json").write_text(json.dumps(shapes))
    library.call("seidel_lens_release", lens)


def model_name(library, lens, index):
    text = c.create_string_buffer(64)
    library.call("seidel_lens_model", lens, c.c_uint32(index), text, c.c_size_t(len(text)), None)
    return text.value.decode()


def read_plate(path):
    part = exr.read(Path(path))[0]
    rect = Rect(0, 0, part.width, part.height)
    colour = Buffer(rect, 3, [part.floats(name) for name in "RGB"])
    depth = Buffer(rect, 1, [part.floats("Z")])
    return rect, colour, depth


def plates(library, lens_path, out, plate_path):
    """Applies the lens with depth, without, to halves, from the bottom up, and to a window."""
    out = Path(out)
    library = Library(library)
    lens = library.lens(lens_path)
    rect, colour, depth = read_plate(plate_path)
    depth_image = depth.image()
    half, memory = halves(colour)
    window = Rect(rect.width // 4, rect.height // 4, rect.width // 2, rect.height // 2)
    forms = {
        "depth": (colour.image(), depth_image, rect, {}),
        "draft": (colour.image(), depth_image, rect, {"quality": 0, "edges": 1}),
        "exact": (colour.image(), depth_image, rect, {"quality": 2, "occlusion": 0}),
        "flat": (colour.image(), None, rect, {"distance": 2.0, "edges": 2, "geometry": 2}),
        "halves": (half, depth_image, rect, {"focus_distance": 3.0, "maximum_size": 6.0}),
        "flipped": (colour.flipped(), depth_image, rect, {"amount": 0.6, "depth_of_field": 0.3}),
        "window": (colour.image(), depth_image, window, {"lens_scale": 0.5, "front_multiplier": 1.5}),
    }
    for name, (source, deep, place, values) in forms.items():
        settings = library.settings(**values)
        plate = sized(Plate, format=rect, extent=rect, source=c.pointer(source))
        if deep is not None:
            plate.depth = c.pointer(deep)
        output = Buffer(place, 3)
        image = output.image()
        library.call("seidel_apply", lens, c.byref(settings), c.byref(plate), c.byref(image), None, None)
        output.write(out / f"{name}.bin")
    del memory
    library.call("seidel_lens_release", lens)


def removal(library, lens_path, other_path, out, plate_path):
    """Removes the lens from a plate at one distance, and replaces it by another."""
    out = Path(out)
    library = Library(library)
    lens, other = library.lens(lens_path), library.lens(other_path)
    rect, colour, _ = read_plate(plate_path)
    source = colour.image()
    plate = sized(Plate, format=rect, extent=rect, source=c.pointer(source))
    settings = library.settings(distance=2.2)
    settings.noise[0] = 0.004
    output, confidence, gain = Buffer(rect, 3), Buffer(rect, 3), Buffer(rect, 3)
    images = [one.image() for one in (output, confidence, gain)]
    findings = sized(Findings, confidence=c.pointer(images[1]), noise_gain=c.pointer(images[2]))
    library.call("seidel_remove", lens, c.byref(settings), c.byref(plate), c.byref(images[0]), None,
                 c.byref(findings), None)
    output.write(out / "remove.bin")
    confidence.write(out / "confidence.bin")
    gain.write(out / "noise_gain.bin")
    share = c.c_double()
    library.call("seidel_check_lens", lens, c.byref(settings), c.byref(plate), c.byref(share), None)
    found = findings.found
    numbers = {
        "blur_share": share.value,
        "found": [found.left, found.top, found.width, found.height],
        "noise": list(findings.noise),
        "misfit": list(findings.misfit),
        "clip_level": [finite(value) for value in findings.clip_level],
        "clipped": list(findings.clipped),
    }
    (out / "findings.json").write_text(json.dumps(numbers))
    library.call("seidel_relens", lens, other, c.byref(settings), c.byref(plate), c.byref(images[0]), None, None)
    output.write(out / "relens.bin")
    for handle in (lens, other):
        library.call("seidel_lens_release", handle)


if __name__ == "__main__":
    tasks = {"kernels": kernels, "plates": plates, "removal": removal}
    if len(sys.argv) < 3 or sys.argv[1] not in tasks:
        sys.exit(__doc__)
    tasks[sys.argv[1]](*sys.argv[2:])
