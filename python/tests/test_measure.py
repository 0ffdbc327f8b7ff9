"""PSFs measured in photographs."""

import json
import warnings

import numpy as np
import photographs
import pytest
from photographs import BLACK, HEIGHT, WHITE, WIDTH

import seidel

LEVELS = {"cfa": "RGGB", "black": BLACK, "white": WHITE}


@pytest.fixture(scope="module")
def counts():
    return photographs.raw_lights()


@pytest.fixture(scope="module")
def measured(counts):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return seidel.measure_lights(counts, distance=3.0, **LEVELS)


# What the command writes beside the set.
PAGES = ("left_out.json", "report.html", "sheet.png")


def files(folder):
    paths = [path.relative_to(folder) for path in folder.rglob("*.*")]
    return sorted(path for path in paths if path.name not in PAGES)


def test_the_set_is_that_of_the_command(counts, measured, command, tmp_path):
    photo = tmp_path / "photograph 0"
    photographs.write_pgm(photo, counts)
    levels = ["--cfa", "RGGB", "--black", BLACK, "--white", WHITE]
    out = tmp_path / "out"
    command("measure", "lights", photo, "--distance", "3", *levels, "--out", out)
    # Tiles are compared as one program compresses them.
    again = tmp_path / "again"
    seidel.ObservationSet.load(out).save(again)
    of_file = seidel.measure_lights(photo, distance=3.0, **LEVELS)
    for k, own in enumerate([measured, of_file]):
        own.observations.save(tmp_path / str(k))
        assert files(tmp_path / str(k)) == files(again) == files(out)
        for name in files(again):
            assert (tmp_path / str(k) / name).read_bytes() == (again / name).read_bytes(), name
        left_out = json.loads((out / "left_out.json").read_text())
        assert len(left_out) == len(own.left_out)
        for entry, light in zip(left_out, own.left_out):
            assert (entry["source"], entry["why"]) == (light.source, light.why)
            for key in ("x", "y", "value", "limit"):
                assert getattr(light, key) == pytest.approx(entry[key], abs=5e-5)


def test_lights_that_are_no_use_are_left_out_with_the_reason(measured):
    found = measured.observations
    assert found.frame_size == (WIDTH, HEIGHT) and found.channels == ["R", "G", "B"]
    assert found.distances == [3.0] and len(found) + len(measured.left_out) == 24
    assert len(found) >= 20 and measured.tile_size >= 7 and len(measured.hot_pixels) == 1
    clipped = [light for light in measured.left_out if light.why == "clipped"]
    assert len(clipped) == 1
    assert (clipped[0].x, clipped[0].y) == pytest.approx((82.0, 88.0), abs=2.5)
    assert clipped[0].value >= clipped[0].limit and "counts" in clipped[0].quantity
    assert "clipped" in repr(clipped[0])
    assert repr(measured) == f"<seidel.LightMeasurement: {len(found)} lights kept, {24 - len(found)} left out>"


def test_a_lens_is_fitted_to_measured_lights(measured):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        lens = seidel.Lens.fit(measured.observations, model="moments")
    psf = lens.psf(WIDTH / 2, HEIGHT / 2, 3.0)
    y, x = np.mgrid[-16:17, -16:17]
    for channel, sigma in enumerate([1.9, 1.7, 1.6]):
        variance = (psf[..., channel] * x**2).sum() / psf[..., channel].sum()
        assert variance == pytest.approx(sigma**2, rel=0.1)


def test_other_arrays(counts, measured):
    floats = counts.astype(np.float32)
    same = seidel.measure_lights(floats, distance=3.0, cfa="RGGB", black=BLACK, white=WHITE)
    assert len(same.observations) == len(measured.observations)
    dark = np.full_like(counts, BLACK)
    both = seidel.measure_lights([counts, counts], dark=dark, distance=[3.0, None], **LEVELS)
    assert len(both.observations) == 2 * len(measured.observations)
    grey = seidel.measure_lights(counts, cfa="none", black=BLACK, white=WHITE, tile_size=21)
    assert grey.observations.channels == ["Y"] and grey.tile_size == 21
    linear = np.stack([counts] * 3, axis=-1)
    green = seidel.measure_lights(linear, black=BLACK, white=WHITE, channels=["G"])
    assert green.observations.channels == ["G"]


BAD = [
    ({"cfa": None}, "cfa: is None, but photograph 0 has one channel"),
    ({"cfa": "RGBG?"}, "RGBG?"),
    ({"white": None}, "white: is None"),
    ({"tile_size": 3}, "tile_size: is 3"),
    ({"distance": [1.0, 2.0]}, "distance: gives 2 distances for 1"),
    ({"channels": ["Z"]}, "channel Z: is not in the photograph"),
    ({"encoding": "log"}, "encoding"),
]


@pytest.mark.parametrize(("changes", "message"), BAD)
def test_errors(counts, changes, message):
    with pytest.raises(seidel.InvalidInput) as caught:
        seidel.measure_lights(counts, **{**LEVELS, **changes})
    assert message in str(caught.value) and caught.value.remedy


def test_photographs_without_lights(tmp_path):
    dark = np.full((64, 64), BLACK, np.uint16)
    with pytest.raises(seidel.InsufficientData):
        seidel.measure_lights(dark, **LEVELS)
    with pytest.raises(seidel.FileError, match="none.dng"):
        seidel.measure_lights(tmp_path / "none.dng")
