"""Small inputs that cases need and that no data folder has. All follow from the data folder and fixed numbers."""

import json
from array import array

import exr

# Where the crop lies in motorcycle.exr, and its size: a wheel before a wall.
LEFT, TOP, WIDTH, HEIGHT = 300, 240, 96, 64
# Size of the textured picture: the frame of the demo's lens.
TEXTURE = (960, 540)


def make(name, data, folder):
    """Makes the input `name` in `folder` and returns its path."""
    path = folder / name
    if not path.exists():
        makers = {
            "crop.exr": _crop,
            "cutout.exr": _cutout,
            "inverse.exr": _inverse,
            "normalised.exr": _normalised,
            "matte.exr": _matte,
            "texture.exr": _texture,
            "frames": _frames,
            "values.csv": _values,
            "quarter.txt": _quarter,
        }
        makers[name](data, path)
    return path


def _crop_channels(data):
    part = exr.read(data / "plates/motorcycle.exr")[0]
    channels = {}
    for name in ("R", "G", "B", "Z"):
        plane = part.floats(name)
        rows = (TOP + row for row in range(HEIGHT))
        channels[name] = array("f")
        for row in rows:
            start = row * part.width + LEFT
            channels[name].extend(plane[start : start + WIDTH])
    return channels


def _crop(data, path):
    exr.write(path, WIDTH, HEIGHT, _crop_channels(data))


def _cutout(data, path):
    """The crop with an alpha that is 1 inside an ellipse and falls to 0 over a soft rim, premultiplied."""
    channels = _crop_channels(data)
    alpha = array("f", [0.0]) * (WIDTH * HEIGHT)
    for k in range(WIDTH * HEIGHT):
        x, y = (k % WIDTH + 0.5) / WIDTH - 0.5, (k // WIDTH + 0.5) / HEIGHT - 0.5
        alpha[k] = min(1.0, max(0.0, 6.0 * (0.2 - x * x - y * y)))
    for name in "RGB":
        channels[name] = array("f", (value * cover for value, cover in zip(channels[name], alpha)))
    channels["A"] = alpha
    exr.write(path, WIDTH, HEIGHT, channels)


def _depth(path, channels, convert):
    exr.write(path, WIDTH, HEIGHT, {"Z": array("f", map(convert, channels["Z"]))})


def _inverse(data, path):
    _depth(path, _crop_channels(data), lambda z: 1.0 / z)


def _normalised(data, path):
    """0 at 2 m, 1 at 6 m."""
    _depth(path, _crop_channels(data), lambda z: (z - 2.0) / 4.0)


def _matte(data, path):
    """A disc with a soft rim at 2.4 m, on the frame of motorcycle.exr."""
    width, height = 741, 500
    alpha = array("f")
    for k in range(width * height):
        x, y = k % width - 300.0, k // width - 260.0
        radius = (x * x + y * y) ** 0.5
        alpha.append(min(1.0, max(0.0, (120.0 - radius) / 8.0)))
    depth = array("f", [2.4]) * (width * height)
    exr.write(path, width, height, {"A": alpha, "Z": depth})


def _texture(_, path):
    """Fine texture: blocks of several sizes with values from a linear congruential generator."""
    width, height = TEXTURE
    state = 1
    plane = [0.0] * (width * height)
    for size in (1, 2, 4, 8, 16):
        across = -(-width // size)
        blocks = []
        for _ in range(across * -(-height // size)):
            state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
            blocks.append((state >> 40) / 2**24)
        for k in range(width * height):
            plane[k] += 0.2 * blocks[k // width // size * across + k % width // size]
    values = array("f", plane)
    exr.write(path, width, height, {name: values for name in "RGB"})


def _frames(data, path):
    """Three frames of the crop, ever brighter."""
    path.mkdir()
    channels = _crop_channels(data)
    for frame in (1, 2, 3):
        brighter = {name: array("f", (value * frame for value in channels[name])) for name in "RGB"}
        exr.write(path / f"crop.{frame:04}.exr", WIDTH, HEIGHT, {**brighter, "Z": channels["Z"]})


def _values(_, path):
    path.write_text("frame,amount,focus-distance,front-multiplier\n1,0.5,2.5,1\n3,1,4,2\n")


def _quarter(data, path):
    """The names of every fourth observation of zemax-dgauss28."""
    manifest = json.loads((data / "psf/zemax-dgauss28/manifest.json").read_text(encoding="utf-8"))
    files = [one["file"] for one in manifest["observations"]]
    path.write_text("\n".join(files[::4]) + "\n")
