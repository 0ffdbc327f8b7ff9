"""Lenses: files, PSFs, controls, fits."""

import copy
import pickle

import numpy as np
import pytest
from conftest import LENS

import seidel


def test_files_are_those_of_the_command(lens, tmp_path):
    path = tmp_path / "lens.json"
    lens.save(path)
    again = seidel.Lens.load(str(path))
    assert again == lens and again.to_json() == path.read_text() == lens.to_json()
    assert seidel.Lens.from_json(LENS.read_text()) == lens


def test_properties(lens):
    assert lens.frame_size == (960, 540) and lens.optical_axis == (480.0, 270.0)
    assert lens.channels == ["R", "G", "B"]
    assert (lens.kind, lens.depends_on_depth, lens.squeeze) == ("pupil", True, 1.0)
    assert repr(lens) == "<seidel.Lens of kind pupil: 960 x 540 px, channels R, G, B>"


def test_copies_and_pickles(lens):
    assert pickle.loads(pickle.dumps(lens)) == lens
    assert copy.deepcopy(lens) == lens


@pytest.mark.parametrize("size", [60, 61])
def test_psfs(lens, size):
    psf = lens.psf(900.0, 60.0, 2.5, size=size)
    assert psf.shape == (size, size, 3) and psf.dtype == np.float32
    assert psf.sum(axis=(0, 1)) == pytest.approx(1.0, abs=2e-3)
    centres = np.arange(size) + 0.5
    for axis in (0, 1):
        centroid = (psf.sum(axis=1 - axis) * centres[:, None]).sum(axis=0) / psf.sum(axis=(0, 1))
        assert centroid == pytest.approx(size / 2.0, abs=0.1)
    assert not np.array_equal(psf, lens.psf(900.0, 60.0, 2.5, size=size, psf_model="gaussian"))


def test_a_smaller_aperture_has_a_smaller_blur(lens):
    stopped_down = lens.adjusted(f_number=4.0)
    peaks = [of.psf(480.0, 270.0, 4.0, size=61).max() for of in (lens, stopped_down)]
    assert peaks[1] > 2.0 * peaks[0]
    assert lens.adjusted() == lens and stopped_down != lens
    with pytest.warns(UserWarning):
        lens.adjusted(f_number=0.7)


def test_looks(lens, tmp_path):
    at = (480.0, 270.0, 6.0)
    squeezed = lens.adjusted(look=seidel.Look(squeeze=2.0))
    psf = squeezed.psf(*at, size=61)[..., 1]
    rows, columns = np.mgrid[-30:31, -30:31]
    assert (psf * rows**2).sum() > 2.0 * (psf * columns**2).sum()
    assert lens.adjusted(look=seidel.Look()) == lens
    squeezed.save(tmp_path / "squeezed.json")
    assert seidel.Lens.load(tmp_path / "squeezed.json") == squeezed
    # Light in the right half of the aperture.
    picture = np.zeros((40, 40), np.float32)
    picture[:, 20:] = 1.0
    drawn = lens.adjusted(look=seidel.Look(aperture_picture=picture))
    assert drawn == lens.adjusted(look=seidel.Look(aperture_picture=picture.copy()))
    assert not np.array_equal(drawn.psf(*at, size=61), lens.psf(*at, size=61))
    for store in (drawn.to_json, lambda: pickle.dumps(drawn)):
        with pytest.raises(seidel.Unsupported, match="without the picture"):
            store()
    with pytest.raises(seidel.FileError, match="without the picture"):
        drawn.save(tmp_path / "drawn.json")
    assert not (tmp_path / "drawn.json").exists()
    for bad, word in [
        (seidel.Look(squeeze=9.0), "0.4 to 2.5"),
        (seidel.Look(rotation=5.0), "blades"),
        (seidel.Look(blades=2), "3 to 13"),
        (seidel.Look(aperture_picture=np.zeros((8, 8), np.float32)), "black"),
        (seidel.Look(aperture_picture=np.zeros((8, 8, 5), np.float32)), "5 channels"),
    ]:
        with pytest.raises(seidel.InvalidInput, match=word):
            lens.adjusted(look=bad)


def test_limits_of_a_fit_are_warnings():
    with pytest.warns(UserWarning, match="distance"):
        seidel.Lens.fit(_at_two_distances(), model="moments")


def _at_two_distances():
    y, x = np.mgrid[-10:11, -10:11]
    tile = np.exp(-(x**2 + y**2) / 6.0).astype(np.float32)
    found = [
        seidel.Observation(40.0 + column * 93.0, 36.0 + row * 72.0, distance, tile)
        for distance in (2.0, 4.0)
        for row in range(5)
        for column in range(7)
    ]
    return seidel.ObservationSet((640, 360), ["Y"], found)


def test_moments_are_fitted_to_arrays(observations, lens):
    fitted = seidel.Lens.fit(observations, model="moments")
    assert fitted.kind == "moments" and fitted.frame_size == (640, 360)
    psf = fitted.psf(320.0, 180.0, 3.0)
    y, x = np.mgrid[-16:17, -16:17]
    expected = np.exp(-(x**2 + y**2) / (2.0 * (1.5 + 4.0 / 3.0)))
    expected /= expected.sum()
    assert np.abs(psf[..., 0] - expected).max() < 0.05 * expected.max()
    with pytest.raises(seidel.Unsupported):
        fitted.adjusted(f_number=8.0)
    # Several sets of one camera are fitted together.
    assert seidel.Lens.fit([observations], model="moments") == fitted


def test_a_lens_is_fitted_ray_by_ray(lens):
    found = [
        seidel.Observation(x, y, distance, lens.psf(x, y, distance, size=61))
        for distance in (1.8, 2.5, 4.0)
        for x in (80.0, 240.0, 400.0, 560.0, 720.0, 880.0)
        for y in (60.0, 200.0, 340.0, 480.0)
    ]
    measured = seidel.ObservationSet(lens.frame_size, ["R", "G", "B"], found)
    fitted = seidel.Lens.fit(measured, model="reduced")
    assert fitted.kind == "pupil"
    own, true = (of.psf(700.0, 400.0, 3.0, size=61) for of in (fitted, lens))
    assert np.abs(own - true).sum() < 0.2 * 3


def test_sets_pass_through_files(observations, tmp_path):
    observations.save(tmp_path / "set")
    again = seidel.ObservationSet.load(tmp_path / "set")
    assert len(again) == len(observations) == 105
    assert again.distances == [2.0, 3.0, 6.0] and again.channels == ["R", "G", "B"]
    assert again.frame_size == (640, 360)
    again.save(tmp_path / "again")
    manifests = [(tmp_path / name / "manifest.json").read_text() for name in ("set", "again")]
    assert manifests[0] == manifests[1]


def test_the_library_is_found_by_name():
    swirl = seidel.Lens.load("library:swirl-58")
    assert swirl.channels == ["R", "G", "B"] and swirl.kind == "pupil"
    with pytest.raises(seidel.FileError, match="library:swirl-58"):
        seidel.Lens.load("library:swrl-58")
