"""Blurs a small image with a lens: a gradient with a point light.

    python3 plugin/examples/apply.py target/release/libseidel_c.so lens.json
"""

import ctypes as c
import math
import sys

WIDTH, HEIGHT = 96, 64
FLOAT = 2


class Rect(c.Structure):
    _fields_ = [(name, c.c_int32) for name in ("left", "top", "width", "height")]


class Image(c.Structure):
    _fields_ = [
        ("size", c.c_uint64), ("data", c.c_void_p), ("row_bytes", c.c_int64),
        ("pixel_bytes", c.c_uint32), ("channels", c.c_uint32), ("sample", c.c_uint32),
        ("reserved", c.c_uint32), ("rect", Rect),
    ]


class Plate(c.Structure):
    _fields_ = [
        ("size", c.c_uint64), ("format", Rect), ("extent", Rect),
        ("source", c.POINTER(Image)), ("depth", c.POINTER(Image)), ("matte", c.POINTER(Image)),
        ("matte_depth", c.POINTER(Image)), ("alphas", c.POINTER(Image)),
    ]


class Settings(c.Structure):
    _fields_ = [
        ("size", c.c_uint64), ("amount", c.c_double), ("channel_scales", c.POINTER(c.c_double)),
        ("channel_scale_count", c.c_uint32), ("geometry", c.c_uint32),
        ("axis_offset_x", c.c_double), ("axis_offset_y", c.c_double), ("psf_model", c.c_char_p),
        ("focus_distance", c.c_double), ("f_number", c.c_double), ("sensor_shift_um", c.c_double),
        ("depth_of_field", c.c_double), ("front_multiplier", c.c_double),
        ("back_multiplier", c.c_double), ("maximum_size", c.c_double),
        ("quality", c.c_uint32), ("edges", c.c_uint32), ("occlusion", c.c_uint32),
        ("fill_foreground", c.c_uint32), ("blur_inside", c.c_uint32), ("alpha", c.c_uint32),
        ("alpha_per_channel", c.c_uint32), ("scrub", c.c_uint32), ("lens_scale", c.c_double),
        ("pixel_aspect", c.c_double), ("distance", c.c_double), ("depth_unit", c.c_double),
        ("depth_near", c.c_double), ("depth_far", c.c_double), ("along_ray", c.c_double),
        ("depth_kind", c.c_uint32), ("clip", c.c_uint32), ("clip_level", c.c_double),
        ("noise", c.c_double * 4), ("strength", c.c_double), ("grain", c.c_uint32),
        ("threads", c.c_uint32), ("memory", c.c_uint64),
    ]


PROGRESS = c.CFUNCTYPE(c.c_int32, c.c_void_p, c.c_double)


class Callbacks(c.Structure):
    _fields_ = [("size", c.c_uint64), ("user", c.c_void_p), ("progress", PROGRESS)]


def main(library, profile):
    seidel = c.CDLL(library)
    seidel.seidel_version.restype = c.c_char_p
    seidel.seidel_last_error.restype = c.c_size_t

    def check(status):
        if status != 0:
            error = c.create_string_buffer(512)
            seidel.seidel_last_error(error, c.c_size_t(len(error)))
            sys.exit(f"status {status}: {error.value.decode()}")

    def sized(kind, **values):
        return kind(size=c.sizeof(kind), **values)

    lens = c.c_void_p()
    check(seidel.seidel_lens_open(profile.encode(), c.byref(lens)))
    settings = sized(Settings)
    check(seidel.seidel_settings_init(c.byref(settings)))
    settings.distance = 2.0  # metres; not used with a depth image

    samples = (c.c_float * (WIDTH * HEIGHT))()
    for k in range(WIDTH * HEIGHT):
        samples[k] = 0.2 + 0.5 * (k % WIDTH) / WIDTH
    samples[20 * WIDTH + 30] = 50.0
    blurred = (c.c_float * (WIDTH * HEIGHT))()
    area = Rect(0, 0, WIDTH, HEIGHT)

    def image(samples):
        return sized(Image, data=c.addressof(samples), row_bytes=4 * WIDTH, channels=1,
                     sample=FLOAT, rect=area)

    source, output = image(samples), image(blurred)
    plate = sized(Plate, format=area, extent=area, source=c.pointer(source))
    shares = []
    progress = PROGRESS(lambda _, share: shares.append(share) or 0)
    callbacks = sized(Callbacks, progress=progress)
    check(seidel.seidel_apply(lens, c.byref(settings), c.byref(plate), c.byref(output), None,
                              c.byref(callbacks)))
    check(seidel.seidel_lens_release(lens))
    before, after = math.fsum(samples), math.fsum(blurred)
    print(f"seidel {seidel.seidel_version().decode()}: light {before:.3f} -> {after:.3f}, "
          f"point 50 -> {blurred[20 * WIDTH + 30]:.3f}, {len(shares)} progress reports")
    # Mirrored edges preserve the sum of the light.
    sys.exit(0 if abs(after / before - 1) < 1e-3 and blurred[20 * WIDTH + 30] < 50 else 1)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
