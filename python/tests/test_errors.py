"""Exceptions: class, kind, place and remedy."""

import pickle

import numpy as np
import pytest

import seidel
from seidel import DepthPass, Settings


def test_files(tmp_path):
    with pytest.raises(seidel.FileError) as caught:
        seidel.Lens.load(tmp_path / "none.json")
    error = caught.value
    assert isinstance(error, seidel.Error) and isinstance(error, OSError)
    assert (error.kind, error.place) == ("file", str(tmp_path / "none.json"))
    assert error.remedy == "check the path" and error.remedy in str(error)
    bad = tmp_path / "bad.json"
    bad.write_text('{"format": "seidel-lens", "version": 99}')
    with pytest.raises(ValueError, match="version"):
        seidel.Lens.load(bad)
    with pytest.raises(seidel.FileError):
        seidel.ObservationSet.load(tmp_path)


def test_text_that_is_no_lens():
    with pytest.raises(seidel.InvalidInput) as caught:
        seidel.Lens.from_json("{")
    assert isinstance(caught.value, ValueError) and caught.value.remedy


def test_errors_can_be_pickled():
    with pytest.raises(seidel.InvalidInput) as caught:
        seidel.Lens.from_json("{}")
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is seidel.InvalidInput
    assert (str(again), again.remedy) == (str(caught.value), caught.value.remedy)


BAD_SETTINGS = [
    ({"amount": 17.0}, "settings.amount: is 17; give 0 to 16"),
    ({"quality": "best"}, 'settings.quality: is "best"; give one of "draft"'),
    ({"edges": "wrap"}, "settings.edges"),
    ({"geometry": "bent"}, "settings.geometry"),
    ({"psf_model": "none"}, "none"),
    ({"channel_scales": {"X": 2.0}}, "channel scale X"),
    ({"pixel_aspect": 40.0}, "pixel_aspect"),
    ({"lens_scale": -1.0}, "lens_scale"),
    ({"focus_distance": -1.0}, "settings.focus_distance: is -1"),
    ({"lens_scale": 1.0, "film_back_mm": 24.0}, "settings.film_back_mm: is given beside lens_scale"),
    ({"look": seidel.Look(squeeze=9.0)}, "look.squeeze: is 9; give 0.4 to 2.5"),
    ({"noise": -0.1}, "settings.noise"),
    ({"strength": 2.0}, "settings.strength"),
    ({"display_window": (0, 0, 0, 4)}, "settings.display_window"),
    ({"clip": "never"}, "settings.clip"),
]


@pytest.mark.parametrize(("changes", "message"), BAD_SETTINGS)
def test_settings(lens, image, changes, message):
    with pytest.raises(seidel.InvalidInput) as caught:
        seidel.apply(lens, image, 3.0, settings=Settings(**changes))
    assert message in str(caught.value)


def test_noise_of_each_colour(lens, image):
    for function in (seidel.remove, seidel.remove_with_maps, seidel.blur_share):
        with pytest.raises(seidel.InvalidInput, match="noise: has 2 values for a plate of 3 colours; give one value"):
            function(lens, image, 3.0, settings=Settings(noise=[0.01, 0.02]))


def test_holdouts_and_backgrounds(lens, image, depth):
    matte = np.zeros_like(depth)
    background = seidel.Background(image, depth)
    cases = [
        ({"holdout": matte[1:]}, {}, "holdout: has 53 x 96 pixels"),
        ({"holdout": matte + 2.0}, {}, "holdout"),
        ({"holdout": seidel.Holdout(matte, 3.0)}, {}, "holdout.depth: is one distance"),
        ({"holdout": matte}, {"occlusion": False}, "holdout: needs occlusion"),
        ({"background": background}, {"fill_foreground": False}, "fill_foreground is False"),
        ({"background": seidel.Background(image[1:], depth)}, {}, "background"),
    ]
    for arguments, changes, message in cases:
        with pytest.raises(seidel.InvalidInput) as caught:
            seidel.apply(lens, image, depth, **arguments, settings=Settings(**changes))
        assert message in str(caught.value), str(caught.value)
    with pytest.raises(seidel.InvalidInput, match="lies at one distance"):
        seidel.apply(lens, image, 3.0, background=background)
    with pytest.raises(seidel.InvalidInput, match="lies at one distance"):
        seidel.remove(lens, image, 3.0, background=background)


def test_types_of_settings(lens, image):
    with pytest.raises(TypeError):
        seidel.apply(lens, image, 3.0, settings=Settings(amount="much"))
    with pytest.raises(TypeError):
        Settings(amuont=1.0)


def test_distances(lens, image, depth):
    with pytest.raises(seidel.InvalidInput, match="unknown"):
        seidel.apply(lens, image)
    for distance in (0.0, -2.0, float("nan")):
        with pytest.raises(seidel.InvalidInput, match="distance"):
            seidel.apply(lens, image, distance)
    with pytest.raises(seidel.InvalidInput, match="depth.near"):
        seidel.apply(lens, image, DepthPass(depth, kind="far-one"))
    with pytest.raises(seidel.InvalidInput, match="depth.kind"):
        seidel.apply(lens, image, DepthPass(depth, kind="near"))
    broken = depth.copy()
    broken[3, 2] = np.nan
    with pytest.raises(seidel.InvalidInput):
        seidel.apply(lens, image, broken)


def test_what_a_lens_cannot_do(observations, image):
    moments = seidel.Lens.fit(observations, model="moments")
    with pytest.raises(seidel.Unsupported) as caught:
        seidel.apply(moments, image, 3.0, settings=Settings(psf_model="pupil"))
    assert caught.value.kind == "unsupported"


def test_observations(observations):
    tile = np.ones((5, 5, 3), np.float32)
    few = [seidel.Observation(100.0 * k, 50.0, 3.0, tile) for k in range(1, 3)]
    with pytest.raises(seidel.Error):
        seidel.Lens.fit(seidel.ObservationSet((640, 360), ["R", "G", "B"], few), model="moments")
    with pytest.raises(seidel.InvalidInput, match="observation 0: tile"):
        seidel.ObservationSet((640, 360), ["Y"], few)
    dark = seidel.Observation(9.0, 9.0, 3.0, np.zeros((5, 5), np.float32))
    with pytest.raises(seidel.InvalidInput) as caught:
        seidel.ObservationSet((640, 360), ["Y"], [dark, dark])
    assert "observation 0" in str(caught.value) and "observation 1" in str(caught.value)
    for bad in ({"model": "best"}, {"axis": "middle"}, {"model": "moments", "use_all": True}):
        with pytest.raises(seidel.InvalidInput):
            seidel.Lens.fit(observations, **bad)


def test_effects(lens, observations):
    with pytest.raises(seidel.InvalidInput):
        seidel.diagnose(lens, observations)
    with pytest.raises(seidel.Error):
        seidel.diagnose(seidel.Lens.fit(observations, model="moments"), observations)


def test_picture_pairs(lens):
    width, height = lens.frame_size
    picture = np.full((height, width, 3), 0.5, np.float32)
    broken = picture.copy()
    broken[7, 5, 1] = np.nan
    for reference, observed, options, words in [
        (picture[..., 0], picture, {}, "reference: has 1 channels"),
        (picture, broken, {}, "observed: is NaN in G at row 7, column 5"),
        (picture, picture, {"geometry": "bent"}, 'geometry: is "bent"'),
        (picture, picture, {"reference_pixels": "dots"}, 'reference_pixels: is "dots"'),
        (picture, picture, {"patch": 8}, "patch: is 8 px"),
    ]:
        with pytest.raises(seidel.Error, match=words):
            seidel.diagnose_pictures(lens, reference, observed, distance=2.5, **options)
