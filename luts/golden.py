"""Computes reference values with OpenColorIO, against which the curves and spaces of this folder are tested.

    pip install opencolorio numpy
    python luts/golden.py

Writes golden/curves.json (codes and linear values of each curve) and golden/acescg.json (colours of each space and of
ACEScg) in single precision, with the version of OpenColorIO. The spaces are those of OpenColorIO's own studio config;
no file of this folder is read.
"""

import json
import os

import numpy
import PyOpenColorIO

CONFIG = "studio-config-v2.1.0_aces-v1.3_ocio-v2.3"

# Names of curves in curves.toml, each with two spaces whose only difference is this curve.
CURVES = {
    "logc3-ei800": ("ARRI LogC3 (EI800)", "Linear ARRI Wide Gamut 3"),
    "logc4": ("ARRI LogC4", "Linear ARRI Wide Gamut 4"),
    "slog3": ("S-Log3 S-Gamut3", "Linear S-Gamut3"),
    "log3g10": ("Log3G10 REDWideGamutRGB", "Linear REDWideGamutRGB"),
    "canon-log3": ("CanonLog3 CinemaGamut D55", "Linear CinemaGamut D55"),
    "vlog": ("V-Log V-Gamut", "Linear V-Gamut"),
    "bmdfilm-gen5": ("BMDFilm WideGamut Gen5", "Linear BMD WideGamut Gen5"),
    "davinci-intermediate": ("DaVinci Intermediate WideGamut", "Linear DaVinci WideGamut"),
    "acescct": ("ACEScct", "ACEScg"),
    "acescc": ("ACEScc", "ACEScg"),
    "srgb": ("sRGB - Texture", "Linear Rec.709 (sRGB)"),
    "bt1886": ("Gamma 2.4 Rec.709 - Texture", "Linear Rec.709 (sRGB)"),
}

# Curves that OpenColorIO clamps: reference values inside the range only.
ONLY_0_TO_1 = {"canon-log3", "bt1886"}
FROM_ZERO_LIGHT = {"acescc"}

COUNT = 81
PIXELS = 48


def numbers(values):
    """Values rounded to single precision, with as few digits as that needs."""
    return [float(str(numpy.float32(v))) for v in values]


def apply(config, source, target, pixels):
    pixels = numpy.ascontiguousarray(pixels, dtype=numpy.float32)
    # The default optimisation approximates logarithms and powers to about 1e-5.
    exact = PyOpenColorIO.OPTIMIZATION_LOSSLESS
    config.getProcessor(source, target).getOptimizedCPUProcessor(exact).applyRGB(pixels)
    return pixels


def codes_of(name):
    if name in ONLY_0_TO_1:
        return numpy.linspace(0, 1, COUNT)
    low = -0.35 if name in FROM_ZERO_LIGHT else -0.125
    return numpy.linspace(low, 1.125, COUNT)


def curves(config):
    values = {}
    for name, (log, linear) in CURVES.items():
        codes = codes_of(name).astype(numpy.float32)
        grey = numpy.repeat(codes[:, None], 3, axis=1)
        light = apply(config, log, linear, grey)[:, 1]
        values[name] = {"spaces": [log, linear], "code": numbers(codes), "linear": numbers(light)}
    return values


def spaces(config):
    values = {}
    random = numpy.random.default_rng(8)
    names = sorted({name for pair in CURVES.values() for name in pair} | {"ACES2065-1"})
    for name in names:
        codes = random.uniform(-0.05, 1.05, (PIXELS, 3)).astype(numpy.float32)
        light = numpy.exp2(random.uniform(-10, 6, (PIXELS, 3)))
        light = (light * random.choice([1, 1, 1, -0.1], (PIXELS, 3))).astype(numpy.float32)
        values[name] = {
            "in": [numbers(p) for p in codes],
            "acescg": [numbers(p) for p in apply(config, name, "ACEScg", codes.copy())],
            "light": [numbers(p) for p in light],
            "out": [numbers(p) for p in apply(config, "ACEScg", name, light.copy())],
        }
    return values


def write(folder, name, key, values):
    document = {"opencolorio": PyOpenColorIO.__version__, "config": CONFIG, key: values}
    with open(os.path.join(folder, name), "w", encoding="ascii", newline="\n") as file:
        json.dump(document, file, indent=1)
        file.write("\n")


def main():
    folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "golden")
    os.makedirs(folder, exist_ok=True)
    config = PyOpenColorIO.Config.CreateFromBuiltinConfig(CONFIG)
    write(folder, "curves.json", "curves", curves(config))
    write(folder, "acescg.json", "spaces", spaces(config))


main()
