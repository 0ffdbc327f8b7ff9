"""Compares Seidel's blur removal with other deconvolution methods on photographs.

    pip install numpy scipy scikit-image
    python3 core/render/benches/remove/peers.py [--rounds N] [PICTURE ...]

The photographs come with scikit-image. The benchmark `remove` blurs them and removes the blur; the other methods get the
same plates. The output is a table of the gain of each method. The free parameters of the others are chosen with the truth
at hand, which favours them; Seidel gets the lens only.
"""

import argparse
import math
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np
import scipy.fft
import scipy.ndimage
import skimage.color
import skimage.data
import skimage.restoration

SIDE = 512
BORDER = 32
NOISES = ("0.001", "0.01")
PICTURES = ("astronaut", "camera", "coffee", "chelsea", "rocket", "brick", "grass", "gravel")
# Number of kernels along each axis that the benchmark writes, and side of a kernel, px.
PLACES, KERNEL = 33, 65
# Sides of the tiles of the tile-wise Wiener filter, px.
TILES = (64, 96, 128)


def linear(encoded):
    """Returns the linear light of sRGB values."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def picture(name):
    """Returns the luminance of the central square of a photograph, 0 to 1."""
    samples = getattr(skimage.data, name)()
    if samples.ndim == 3:
        samples = linear(samples[..., :3] / 255.0) @ np.array([0.2126, 0.7152, 0.0722])
    else:
        samples = linear(samples / 255.0)
    if min(samples.shape) < SIDE:
        scale = SIDE / min(samples.shape)
        samples = scipy.ndimage.zoom(samples, scale * (1 + 1e-9), order=1).clip(0.0, 1.0)
    top, left = ((size - SIDE) // 2 for size in samples.shape)
    return samples[top : top + SIDE, left : left + SIDE].astype("<f4")


def psnr(found, truth):
    """Returns the peak signal-to-noise ratio without the border, dB, for a peak of one."""
    inside = (slice(BORDER, -BORDER),) * 2
    return -10.0 * math.log10(np.mean((found[inside].astype(float) - truth[inside]) ** 2))


def transfer(kernel, side):
    """Returns the transfer function of a kernel on a tile."""
    tile = np.zeros((side, side))
    half = KERNEL // 2
    across = np.arange(-half, half + 1) % side
    np.add.at(tile, (across[:, None], across[None, :]), kernel)
    return scipy.fft.rfft2(tile)


def laplacian_power(side):
    """Returns the power response of the discrete Laplace operator on a tile."""
    down, across = np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side)[None, :]
    return (4.0 - 2.0 * np.cos(2 * np.pi * down) - 2.0 * np.cos(2 * np.pi * across)) ** 2


class TileWise:
    """Wiener filters on tiles that overlap by half, each with the kernel at its centre."""

    def __init__(self, kernels, tile):
        self.tile, self.hop = tile, tile // 2
        starts = range(-self.hop, SIDE, self.hop)
        self.sine = np.sin(np.pi * (np.arange(tile) + 0.5) / tile)
        nearest = lambda start: round(min(max(start + self.hop, 0), SIDE) * (PLACES - 1) / SIDE)
        self.spectra = {(y, x): transfer(kernels[nearest(y), nearest(x)], tile) for y in starts for x in starts}

    def __call__(self, plate, strength, flat, twice):
        """Filters `plate` with the noise-to-signal ratio `strength`, the same at all frequencies (`flat`) or times the power
        response of the Laplace operator. Tiles are windowed after filtering, or before and after (`twice`)."""
        tile = self.tile
        prior = strength * (1.0 if flat else laplacian_power(tile))
        half = self.sine[:, None] * self.sine[None, :]
        before, after = (half, half) if twice else (1.0, half**2)
        wide = np.pad(plate, tile, mode="symmetric")
        out = np.zeros_like(wide)
        for (y, x), h in self.spectra.items():
            part = (slice(y + tile, y + 2 * tile), slice(x + tile, x + 2 * tile))
            spectrum = scipy.fft.rfft2(wide[part] * before)
            filtered = spectrum * np.conj(h) / (np.abs(h) ** 2 + prior)
            out[part] += scipy.fft.irfft2(filtered, s=(tile, tile)) * after
        return out[tile:-tile, tile:-tile]


def means(kernels):
    """Yields the mean kernel of the whole plate, of its central half, and the kernel at its centre."""
    for edge in (0, PLACES // 4, PLACES // 2):
        mean = kernels[edge : PLACES - edge, edge : PLACES - edge].mean(axis=(0, 1))
        yield mean / mean.sum()


def best(results, truth):
    """Returns the best PSNR of the results, and its time in seconds."""
    return max((psnr(found, truth), seconds) for found, seconds in results)


def timed(work):
    start = time.process_time()
    return work(), time.process_time() - start


def peers(plate, truth, kernels, tiles):
    """Yields the name, PSNR and time of each method with its best parameters."""
    positive = plate.clip(1e-6, None)
    lucy = lambda mean, count: skimage.restoration.richardson_lucy(positive, mean, num_iter=count, clip=False)
    tried = (timed(lambda: lucy(mean, count)) for mean in means(kernels) for count in (5, 10, 20, 40, 80))
    yield "Richardson-Lucy", *best(tried, truth)
    unsupervised = lambda mean: skimage.restoration.unsupervised_wiener(plate, mean, clip=False, rng=1)[0]
    yield "unsupervised Wiener", *best((timed(lambda: unsupervised(mean)) for mean in means(kernels)), truth)
    tried = (
        timed(lambda: tile(plate, 10.0**power, flat, twice))
        for tile in tiles
        for flat in (False, True)
        for twice in (False, True)
        for power in np.arange(-5.0, 0.01, 0.25)
    )
    yield "tile-wise Wiener", *best(tried, truth)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--rounds", default="3", help="number of timings of Seidel")
    options.add_argument("picture", nargs="*", default=PICTURES)
    options = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        images, results = folder / "images", folder / "results"
        images.mkdir()
        results.mkdir()
        truths = {name: picture(name) for name in options.picture}
        for name, samples in truths.items():
            samples.tofile(images / f"{name}.f32")
        command = ["cargo", "bench", "-q", "-p", "seidel-render", "--bench", "remove", "--", "--images", images]
        command += ["--out", results, "--rounds", options.rounds, "--noise", ",".join(NOISES)]
        print(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
        read = lambda name, *shape: np.fromfile(results / f"{name}.f32", "<f4").reshape(shape)
        kernels = read("kernels", PLACES, PLACES, KERNEL, KERNEL).astype(float)
        tiles = [TileWise(kernels, tile) for tile in TILES]
        head = None
        for name, truth in truths.items():
            for noise in NOISES:
                plate = read(f"{name}-{noise}-plate", SIDE, SIDE).astype(float)
                before = psnr(plate, truth)
                found = [("Seidel", psnr(read(f"{name}-{noise}-seidel", SIDE, SIDE), truth), None)]
                found += peers(plate, truth, kernels, tiles)
                if head is None:
                    head = [peer for peer, _, _ in found]
                    print("| picture | noise | " + " | ".join(f"{peer} dB" for peer in head) + " | CPU s of peers |")
                    print("|" + " --- |" * (len(head) + 3))
                gains = " | ".join(f"{after - before:+.2f}" for _, after, _ in found)
                seconds = ", ".join(f"{s:.2f}" for _, _, s in found if s is not None)
                print(f"| {name} | {noise} | {gains} | {seconds} |")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
