"""Golden values from OpenColorIO itself: what curves and spaces of this folder are checked against.

    pip install opencolorio numpy
    python luts/golden.py

Writes golden/curves.json (codes and linear values of each curve) and golden/acescg.json (colours of each space and of
ACEScg), in single precision, with the versions they came from. Nothing of this folder goes into them: the spaces are
those of OpenColorIO's own studio config.
"""

import json
import os

import numpy
import PyOpenColorIO

CONFIG = "studio-config-v2.1.0_aces-v1.3_ocio-v2.3"

# Curves by their names in curves.toml, each with two spaces that it alone lies between.
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

# Where OpenColorIO has a table or clamps, it says nothing of codes outside.
ONLY_0_TO_1 = {"canon-log3", "bt1886"}
FROM_ZERO_LIGHT = {"acescc"}

COUNT = 81
PIXELS = 48


def numbers(values):
    """As short as single precision allows."""
    return [float(str(numpy.float32(v))) for v in values]


def applied(config, source, target, pixels):
    pixels = numpy.ascontiguousarray(pixels, dtype=numpy.float32)
    # Without this logarithms and powers are good to about 1e-5 only.
    exact = PyOpenColorIO.OPTIMIZATION_LOSSLESS
    config.getProcessor(source, target).getOptimizedCPUProcessor(exact).applyRGB(pixels)
    return pixels


def codes_of(name):
    if name in ONLY_0_TO_1:
        return numpy.linspace(0, 1, COUNT)
    low = -0.35 if name in FROM_ZERO_LIGHT else -0.125
    return numpy.linspace(low, 1.125, COUNT)


def curves(config):
    made = {}
    for name, (log, linear) in CURVES.items():
        codes = codes_of(name).astype(numpy.float32)
        grey = numpy.repeat(codes[:, None], 3, axis=1)
        light = applied(config, log, linear, grey)[:, 1]
        made[name] = {"spaces": [log, linear], "code": numbers(codes), "linear": numbers(light)}
    return made


def spaces(config):
    made = {}
    random = numpy.random.default_rng(8)
    names = sorted({name for pair in CURVES.values() for name in pair} | {"ACES2065-1"})
    for name in names:
        codes = random.uniform(-0.05, 1.05, (PIXELS, 3)).astype(numpy.float32)
        light = numpy.exp2(random.uniform(-10, 6, (PIXELS, 3)))
        light = (light * random.choice([1, 1, 1, -0.1], (PIXELS, 3))).astype(numpy.float32)
        made[name] = {
            "in": [numbers(p) for p in codes],
            "acescg": [numbers(p) for p in applied(config, name, "ACEScg", codes.copy())],
            "light": [numbers(p) for p in light],
            "out": [numbers(p) for p in applied(config, "ACEScg", name, light.copy())],
        }
    return made


def write(folder, name, what, values):
    made = {"opencolorio": PyOpenColorIO.__version__, "config": CONFIG, what: values}
    with open(os.path.join(folder, name), "w", encoding="ascii", newline="\n") as file:
        json.dump(made, file, indent=1)
        file.write("\n")


def main():
    folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "golden")
    os.makedirs(folder, exist_ok=True)
    config = PyOpenColorIO.Config.CreateFromBuiltinConfig(CONFIG)
    write(folder, "curves.json", "curves", curves(config))
    write(folder, "acescg.json", "spaces", spaces(config))


main()
