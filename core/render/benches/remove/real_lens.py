"""Removes the blur of a measured lens from lamps on a flat ground, and prints what is left beside each.

    pip install numpy OpenEXR
    cargo build --release --bin seidel
    seidel fit SET -o lens.json
    python3 core/render/benches/remove/real_lens.py --seidel target/release/seidel --lens lens.json --distance 4.05

Discs of 3 px radius on a ground of 0.18 are blurred by the exact renderer. Undershoot and overshoot are the largest errors
of means over 3 x 3 px, 3 to 24 px from the disc, in per cent of the ground; light is that within 4.5 px of the centre over
all the disc's light, in plate and result.
"""

import argparse
import pathlib
import subprocess
import tempfile

import numpy as np
import OpenEXR

WIDTH, HEIGHT = 960, 640
GROUND, RADIUS = 0.18, 3.0
LAMPS = (3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)


def centre(index):
    """Returns the centre of a lamp, px."""
    return 160.5 + 320 * (index % 3), 160.5 + 320 * (index // 3)


def distance_from(index):
    """Returns the distance of each pixel from the centre of a lamp, px."""
    down, across = np.mgrid[:HEIGHT, :WIDTH]
    x, y = centre(index)
    return np.hypot(across - x, down - y)


def sharp_picture():
    """Returns the discs, each pixel the mean of 8 x 8 samples."""
    picture = np.full((HEIGHT, WIDTH), GROUND)
    offsets = (np.arange(8) + 0.5) / 8 - 0.5
    down, across = np.mgrid[:HEIGHT, :WIDTH]
    for index, light in enumerate(LAMPS):
        x, y = centre(index)
        inside = [np.hypot(across + u - x, down + v - y) < RADIUS for u in offsets for v in offsets]
        picture += np.mean(inside, axis=0) * (light - GROUND)
    return picture.astype(np.float32)


def write(path, picture):
    """Writes a picture as R, G and B."""
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    channels = {name: np.ascontiguousarray(picture) for name in "RGB"}
    OpenEXR.File(header, channels).write(str(path))


def read_green(path):
    """Returns G of a file."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return file.channels()["G"].pixels.astype(float)


def means(picture):
    """Returns means over 3 x 3 px."""
    padded = np.pad(picture, 1, mode="edge")
    shifted = [padded[v : v + HEIGHT, u : u + WIDTH] for u in range(3) for v in range(3)]
    return np.mean(shifted, axis=0)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seidel", default="seidel")
    parser.add_argument("--lens", required=True)
    parser.add_argument("--distance", required=True)
    parser.add_argument("--noise", type=float, default=0.001)
    parser.add_argument("--remove", nargs="*", default=[], help="more options of seidel remove, without dashes")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        lens = ["--lens", options.lens, "--distance", options.distance]
        truth = sharp_picture()
        write(folder / "sharp.exr", truth)
        apply = ["apply", folder / "sharp.exr", *lens, "--quality", "exact", "-o", folder / "blurred.exr"]
        subprocess.run([options.seidel, *apply], check=True)
        noise = np.random.default_rng(1).normal(0, options.noise, (HEIGHT, WIDTH))
        plate = (read_green(folder / "blurred.exr") + noise).astype(np.float32)
        write(folder / "plate.exr", plate)
        remove = ["remove", folder / "plate.exr", *lens, *(f"--{o}" for o in options.remove), "--grain", "solved", "--lens-check", "off", "--no-overscan", "-o", folder / "result.exr"]
        subprocess.run([options.seidel, *remove], check=True)
        result = read_green(folder / "result.exr")
    print("| lamp | undershoot | overshoot | light in the plate | in the result |")
    print("| --- | --- | --- | --- | --- |")
    smooth = means(result)
    flat = np.ones((HEIGHT, WIDTH), bool)
    flat[:32], flat[-32:], flat[:, :32], flat[:, -32:] = 0, 0, 0, 0
    for index, light in enumerate(LAMPS):
        far = distance_from(index)
        flat &= far > RADIUS + 60
        beside = smooth[(far > RADIUS + 3) & (far < RADIUS + 24)] / GROUND - 1
        whole = (truth - GROUND)[far < 20].sum()
        near = [100 * (p - GROUND)[far < RADIUS + 1.5].sum() / whole for p in (plate, result)]
        print(
            f"| {light:g} | {max(0, -100 * beside.min()):.1f} % | {max(0, 100 * beside.max()):.1f} % "
            f"| {near[0]:.0f} % | {near[1]:.0f} % |"
        )
    print(f"\nDeviation of the ground: {result[flat].std():.5f}, of the plate's: {plate[flat].std():.5f}")


main()
