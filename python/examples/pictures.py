"""Draws the picture of docs/guide/python.md by running the examples of the page. Needs Pillow.

    python python/examples/pictures.py LENS.json docs/pictures/python.png
"""

import os
import pathlib
import re
import shutil
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw

PAGE = pathlib.Path(__file__).parents[2] / "docs/guide/python.md"
LABEL_PX = 18
SCALE = 2


def values(lens):
    """Runs the examples up to the change of lenses; returns their variables."""
    text = PAGE.read_text(encoding="utf-8").split("## Progress")[0]
    before, names = pathlib.Path.cwd(), {}
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "demo").mkdir()
        shutil.copy(lens, pathlib.Path(folder) / "demo/lens.json")
        os.chdir(folder)
        try:
            for code in re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
                exec(code, names)
        finally:
            os.chdir(before)
    return names


def panel(image, label):
    """Returns an image for display, enlarged, with a label above it."""
    codes = (255.0 * np.clip(image, 0.0, 1.0) ** (1.0 / 2.2)).astype(np.uint8)
    codes = codes.repeat(SCALE, axis=0).repeat(SCALE, axis=1)
    framed = Image.new("RGB", (codes.shape[1], codes.shape[0] + LABEL_PX), "white")
    framed.paste(Image.fromarray(codes), (0, LABEL_PX))
    ImageDraw.Draw(framed).text((4, 3), label, fill="black")
    return np.asarray(framed)


def main(lens, output):
    names = values(lens)
    panels = [
        panel(names["image"], "image"),
        panel(names["blurred"], "apply(lens, image, depth)"),
        panel(names["soft"], "soft"),
        panel(names["sharp"], "remove(lens, soft, 3.5)"),
    ]
    rows = [np.concatenate(panels[k : k + 2], axis=1) for k in (0, 2)]
    Image.fromarray(np.concatenate(rows)).save(output, optimize=True)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]).resolve(), sys.argv[2])
