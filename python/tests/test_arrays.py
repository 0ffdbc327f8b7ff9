"""Layouts and sample types of arrays."""

import numpy as np
import pytest

import seidel


@pytest.mark.parametrize("sample", [np.float32, np.float16])
def test_views_give_the_same_as_copies(lens, image, depth, sample):
    image, depth = image.astype(sample), depth.astype(sample)
    expected = seidel.apply(lens, image, depth)
    padded = np.zeros((2 * image.shape[0], image.shape[1] + 7, 4), sample)
    padded[::2, 3:-4, :3] = image
    view = padded[::2, 3:-4, :3]
    assert not view.flags.c_contiguous
    layouts = [
        view,
        np.asfortranarray(image),
        np.ascontiguousarray(image[::-1, ::-1, ::-1])[::-1, ::-1, ::-1],
        np.ascontiguousarray(image.transpose(2, 0, 1)).transpose(1, 2, 0),
    ]
    for layout in layouts:
        result = seidel.apply(lens, layout, np.asfortranarray(depth))
        assert result.tobytes() == expected.tobytes()


def test_inputs_stay_as_they_are_and_results_are_new(lens, image):
    kept = image.copy()
    read_only = image.view()
    read_only.flags.writeable = False
    for settings in (None, seidel.Settings(amount=0.0)):
        result = seidel.apply(lens, read_only, 3.0, settings=settings)
        assert result.flags.c_contiguous and result.flags.writeable
        assert not np.shares_memory(result, image)
    assert np.array_equal(image, kept) and np.array_equal(result, kept)


def test_results_have_the_shape_and_the_sample_type_of_the_image(lens, image):
    grey = image[..., 0]
    for array in (grey, grey[..., None], image, image.astype(np.float16)):
        result = seidel.apply(lens, array, 3.0)
        assert (result.shape, result.dtype) == (array.shape, array.dtype)
    both = [seidel.apply(lens, array, 3.0) for array in (grey, grey[..., None])]
    assert np.array_equal(both[0], both[1][..., 0])


def test_half_floats_do_not_overflow(lens, image):
    image = image.astype(np.float16)
    image[20:30, 20:30] = np.finfo(np.float16).max
    assert np.isfinite(seidel.apply(lens, image, 3.0)).all()


def test_samples_that_are_not_finite(lens, image):
    image = image.copy()
    image[4, 5, 1] = np.nan
    with pytest.raises(seidel.InvalidInput, match=r"channel G, pixel \(5, 4\): is NaN"):
        seidel.apply(lens, image, 3.0)
    black = image.copy()
    black[4, 5, 1] = 0.0
    result = seidel.apply(lens, image, 3.0, settings=seidel.Settings(scrub=True))
    assert np.array_equal(result, seidel.apply(lens, black, 3.0))


BAD_IMAGES = [
    ("a list", [[0.0]], "image: is of type list"),
    ("integers", np.zeros((4, 4, 3), np.uint8), "image: has samples of type uint8"),
    ("doubles", np.zeros((4, 4, 3)), "image: has samples of type float64"),
    ("swapped bytes", np.zeros((4, 4, 3), ">f4"), "image: has samples of type >f4"),
    ("one dimension", np.zeros(4, np.float32), "image: has 1 dimensions"),
    ("four dimensions", np.zeros((1, 4, 4, 3), np.float32), "image: has 4 dimensions"),
    ("five channels", np.zeros((4, 4, 5), np.float32), "image: has 5 channels"),
    ("no pixels", np.zeros((0, 4, 3), np.float32), "image: has the shape"),
    (
        "unaligned samples",
        np.zeros((4, 4), np.dtype([("tag", "u1"), ("value", "<f4")]))["value"],
        "image: has samples that are not aligned",
    ),
]


@pytest.mark.parametrize(("array", "message"), [case[1:] for case in BAD_IMAGES])
def test_other_arrays_are_errors(lens, array, message):
    with pytest.raises(seidel.InvalidInput) as caught:
        seidel.apply(lens, array, 3.0)
    assert str(caught.value).startswith(message)
    assert caught.value.kind == "invalid_input" and caught.value.remedy


def test_depth_has_the_size_of_the_image(lens, image, depth):
    with pytest.raises(seidel.InvalidInput, match="depth: has 53 x 96 pixels"):
        seidel.apply(lens, image, depth[1:])
    with pytest.raises(seidel.InvalidInput, match="3 channels"):
        seidel.apply(lens, image, image)
    one_channel = seidel.apply(lens, image, depth[..., None])
    assert np.array_equal(one_channel, seidel.apply(lens, image, depth))
