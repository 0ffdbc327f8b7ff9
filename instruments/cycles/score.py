"""Blurs the plates of scenes.py by the command and prints the PSNR against their truths.

    python score.py FOLDER SEIDEL [PICTURE.png] [-- OPTION...]

Needs numpy, OpenEXR and Pillow from PyPI. Samples are limited to 1, and 24 px of border and what shines past a surface that hides it from
the pinhole are left out. The picture has a row for each scene, at 300 %: plate, truth, Seidel, and three times the difference of Seidel and the truth
about grey. Options after `--` go to `seidel apply`.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image, ImageDraw, ImageFont

BORDER = 24
# Parts shown: column and row of the first pixel.
SHOWN = {"lamps": (300, 80), "leaves": (150, 60), "grass": (150, 150), "hair": (270, 90), "street": (190, 70)}
PART = 96
ENLARGEMENT = 3
COLUMNS = ("plate", "Cycles, open aperture", "Seidel", "3 x difference about grey")
LINE_PX = 24
# Light of a lamp behind the box.
HIDDEN = {"lamps": np.s_[100:150, 265:300]}


def read(path):
    """Returns the planes R, G, B and Z of a file, Z where there is one."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: channel.pixels for part in file.parts for name, channel in part.channels.items()}
    last = {name.split(".")[-1]: np.asarray(plane, np.float32) for name, plane in channels.items() if "Position" not in name}
    return {name: last[name] for name in "RGBZ" if name in last}


def lens(camera):
    """Returns the profile of the thin lens of a camera."""
    def polynomial(*terms):
        return {"coefficients": list(terms), "sigma": [0.0] * len(terms)}

    zeros = ("beta", "gamma", "delta", "phi", "blur_variance_px2", "magnification", "distortion")
    slope = camera["px_per_vergence"]
    channel = {name: polynomial(0.0) for name in zeros}
    channel |= {"alpha": polynomial(-slope / camera["focus_m"], slope), "measured_vergence_per_m": [0.0, 4.0], "effects": []}
    return {
        "format": "seidel-lens", "version": 1, "kind": "pupil", "image_size": camera["size"],
        "optical_axis": [size / 2 for size in camera["size"]], "pixel_pitch_um": camera["pitch_um"],
        "camera": {"focal_length_mm": camera["focal_mm"], "f_number": camera["f_number"], "focus_distance_m": camera["focus_m"]},
        "channels": [{"name": name} | channel for name in "RGB"],
        "provenance": {"program": "score.py", "sources": [], "settings": ""},
    }


def blurred(folder, name, camera, seidel, options):
    plate, result, profile = (folder / f"{name}_{part}" for part in ("depth.exr", "seidel.exr", "lens.json"))
    OpenEXR.File({}, dict(read(folder / f"{name}_plate.exr"))).write(str(plate))
    profile.write_text(json.dumps(lens(camera)))
    iris = ["--blades", str(camera["blades"]), "--rotation", "30"] if camera["blades"] else []
    command = [seidel, "apply", "--lens", profile, plate, "-o", result, "--expand", "off", *iris, *options]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    print(*(line for line in done.stderr.splitlines() if "doubtful" in line), sep="\n", end="")
    return read(result)


def pixels(planes):
    return np.stack([planes[name] for name in "RGB"], -1)


def main():
    words = sys.argv[1:]
    options = words[words.index("--") + 1:] if "--" in words else []
    folder, seidel, *picture = words[: words.index("--")] if "--" in words else words
    folder = Path(folder)
    rows = []
    for name, (column, row) in SHOWN.items():
        if not (folder / f"{name}_truth.exr").exists():
            continue
        camera = json.loads((folder / f"{name}.json").read_text())
        plate, truth = (pixels(read(folder / f"{name}_{part}.exr")) for part in ("plate", "truth"))
        result = pixels(blurred(folder, name, camera, seidel, options))
        kept = np.zeros(truth.shape[:2], bool)
        kept[BORDER:-BORDER, BORDER:-BORDER] = True
        if name in HIDDEN:
            kept[HIDDEN[name]] = False

        def decibels(other):
            return -10 * np.log10(np.mean((np.clip(other, 0, 1) - np.clip(truth, 0, 1))[kept] ** 2))

        print(f"{name}: {decibels(result):.2f} dB, unblurred {decibels(plate):.2f} dB")
        views = [np.clip(view, 0, 1) ** (1 / 2.2) for view in (plate, truth, result)]
        views.append(np.clip(0.5 + 3 * (result - truth), 0, 1))
        parts = [view[row:row + PART, column:column + PART].repeat(ENLARGEMENT, 0).repeat(ENLARGEMENT, 1) for view in views]
        rows.append(np.concatenate(parts, 1))
    if picture:
        shown = np.concatenate(rows, 0)
        labelled = Image.fromarray((255 * np.pad(shown, ((LINE_PX, 0), (0, 0), (0, 0))) + 0.5).astype(np.uint8))
        for column, label in enumerate(COLUMNS):
            place = (column * PART * ENLARGEMENT + 8, 3)
            ImageDraw.Draw(labelled).text(place, label, (226, 230, 236), ImageFont.load_default(16))
        labelled.save(picture[0])


main()
