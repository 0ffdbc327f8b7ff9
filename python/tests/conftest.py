"""A small lens, plates and PSFs, all made here, and the command."""

import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import seidel

sys.path.insert(0, str(pathlib.Path(__file__).parent))

REPOSITORY = pathlib.Path(__file__).parents[2]
LENS = REPOSITORY / "core/tests/data/lens.json"
WIDTH, HEIGHT = 96, 54


@pytest.fixture(scope="session")
def lens():
    """A lens traced ray by ray, whose blur depends on distance."""
    return seidel.Lens.load(LENS)


@pytest.fixture(scope="session")
def image():
    """An RGB image: texture, edges and small lights. Its noise comes from a seed."""
    random = np.random.default_rng(3)
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH]
    grey = 0.2 + 0.1 * np.sin(columns / 3.0) * np.cos(rows / 4.0) + 0.4 * (columns > 60)
    image = np.stack([grey, 0.8 * grey, 0.6 * grey], axis=-1)
    image += random.normal(0.0, 0.01, image.shape)
    image[10, 20], image[40, 75] = (30.0, 25.0, 20.0), (8.0, 9.0, 12.0)
    return image.astype(np.float32)


@pytest.fixture(scope="session")
def depth():
    """Object distance in metres: a wall, and a post in front of it."""
    depth = np.full((HEIGHT, WIDTH), 4.0, np.float32)
    depth[:, 30:42] = 1.6
    return depth


@pytest.fixture(scope="session")
def observations():
    """PSFs of Gaussian shape that grow towards the corners, at three distances, with a little noise."""
    random = np.random.default_rng(5)
    y, x = np.mgrid[-10:11, -10:11]
    found = []
    for distance in (2.0, 3.0, 6.0):
        for row in range(5):
            for column in range(7):
                centre = (40.0 + column * 93.0, 36.0 + row * 72.0)
                radius = np.hypot(centre[0] - 320.0, centre[1] - 180.0) / 320.0
                variances = [1.5 + 4.0 / distance + radius**2 + 0.2 * k for k in range(3)]
                tile = np.stack([np.exp(-(x**2 + y**2) / (2.0 * v)) for v in variances], axis=-1)
                tile += random.normal(0.0, 1e-4, tile.shape)
                found.append(seidel.Observation(*centre, distance, tile.astype(np.float32)))
    return seidel.ObservationSet((640, 360), ["R", "G", "B"], found)


@pytest.fixture(scope="session")
def command():
    """Returns a function that runs the command, or skips the test."""
    path = os.environ.get("SEIDEL_COMMAND")
    if not path:
        pytest.skip("SEIDEL_COMMAND does not name the command, so nothing is compared with it")
    if not pathlib.Path(path).is_file():
        pytest.fail(f"SEIDEL_COMMAND: {path} does not exist; build the command")

    def run(*arguments):
        done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run
