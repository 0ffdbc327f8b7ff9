"""Raw photographs of point lights, made here."""

import numpy as np

WIDTH, HEIGHT = 320, 240
BLACK, WHITE = 512, 16383


def raw_lights(seed=2):
    """Returns an RGGB mosaic of counts, ``uint16``: 24 lights of Gaussian shape on a dark ground, and one that clips."""
    random = np.random.default_rng(seed)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    widths = np.array([[1.9, 1.7], [1.7, 1.6]])  # R, G, G, B
    sigma = widths[np.arange(HEIGHT)[:, None] % 2, np.arange(WIDTH)[None, :] % 2]
    light = np.full((HEIGHT, WIDTH), 6.0)
    for row in range(4):
        for column in range(6):
            centre = np.array([30.0 + 52.0 * column, 30.0 + 58.0 * row]) + random.uniform(-2, 2, 2)
            peak = 40000.0 if (row, column) == (1, 1) else 6000.0
            squares = (x - centre[0]) ** 2 + (y - centre[1]) ** 2
            light += peak * np.exp(-squares / (2.0 * sigma**2))
    noisy = light + random.normal(0.0, 1.0, light.shape) * np.sqrt(0.5 * light + 4.0)
    return np.clip(np.round(BLACK + noisy), 0, WHITE).astype(np.uint16)


def write_pgm(path, counts):
    """Writes counts as a PGM of 16 bits."""
    height, width = counts.shape
    path.write_bytes(b"P5\n%d %d\n65535\n" % (width, height) + counts.astype(">u2").tobytes())
