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
    with pytest.raises(seidel.InvalidInput, match=r"channel G, pixel \(5, 4\): is NaN.*Settings\(scrub=True\)"):
        seidel.apply(lens, image, 3.0)
    black = image.copy()
    black[4, 5, 1] = 0.0
    result = seidel.apply(lens, image, 3.0, settings=seidel.Settings(scrub=True))
    assert np.array_equal(result, seidel.apply(lens, black, 3.0))


BAD_IMAGES = [
    ("a list", [[0.0]], "image: is of type list"),
    ("complex numbers", np.zeros((4, 4, 3), np.complex64), "image: has samples of type complex64"),
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


@pytest.mark.parametrize("dtype", ["float64", ">f4", "uint8", "bool"])
def test_other_numbers_are_converted_with_a_word(lens, image, dtype):
    array = (4 * image).astype(dtype)
    with pytest.warns(UserWarning, match="image: samples of type") as caught:
        result = seidel.apply(lens, array, 3.0)
    assert len(caught) == 1 and caught[0].filename == __file__
    assert np.array_equal(result, seidel.apply(lens, array.astype(np.float32), 3.0))


class OfInterface:
    def __init__(self, array):
        self.__array_interface__ = array.__array_interface__
        self.kept = array


class OfArray:
    def __init__(self, array):
        self.kept = array

    def __array__(self, dtype=None, copy=None):
        return self.kept


class OfDlpack(OfArray):
    def __dlpack__(self, **options):
        return self.kept.__dlpack__(**options)

    def __dlpack_device__(self):
        return self.kept.__dlpack_device__()


class OnGpu(OfDlpack):
    def __dlpack__(self, **options):
        raise BufferError("on the device cuda:0")


@pytest.mark.parametrize("wrapped", [OfInterface, OfArray, OfDlpack])
def test_arrays_of_other_packages_are_read(lens, image, depth, wrapped):
    assert np.array_equal(seidel.apply(lens, wrapped(image), wrapped(depth)), seidel.apply(lens, image, depth))


def test_arrays_on_another_device_are_errors(lens, image):
    with pytest.raises(seidel.InvalidInput, match=r"cuda:0.*tensor.detach\(\).cpu\(\)"):
        seidel.apply(lens, OnGpu(image), 3.0)


def test_a_mask_keeps_the_image(lens, image, depth):
    mask = np.zeros_like(depth)
    mask[:, 40:] = 1.0
    blurred = seidel.apply(lens, image, depth)
    masked = seidel.apply(lens, image, depth, mask=mask)
    assert np.array_equal(masked[:, :40], image[:, :40]) and np.array_equal(masked[:, 40:], blurred[:, 40:])
    half = seidel.apply(lens, image, depth, settings=seidel.Settings(mix=0.5))
    assert np.allclose(half, (image + blurred) / 2, atol=1e-6)


def test_a_mask_scales_the_blur(lens, image, depth):
    blurred = seidel.apply(lens, image, depth)
    by_blur = seidel.Settings(mask_scales="blur")
    assert np.array_equal(seidel.apply(lens, image, depth, mask=np.ones_like(depth), settings=by_blur), blurred)
    focused = seidel.apply(lens, image, depth, mask=np.zeros_like(depth), settings=by_blur)
    everywhere = seidel.Settings(front_multiplier=0.0, back_multiplier=0.0)
    assert np.allclose(focused, seidel.apply(lens, image, depth, settings=everywhere), atol=1e-5)


def test_a_picked_distance_is_in_focus(lens, image, depth):
    post = seidel.distance_at(lens, depth, 36, 20)
    assert post == pytest.approx(1.6) and seidel.distance_at(lens, depth, 5, 5) == pytest.approx(4.0)
    assert seidel.distance_at(lens, seidel.DepthPass(100 * depth, unit=0.01), 36, 20) == pytest.approx(1.6)
    with pytest.raises(seidel.InvalidInput, match=r"pixel \(96, 0\): lies outside"):
        seidel.distance_at(lens, depth, 96, 0)
    settings = seidel.Settings(focus_distance=2.5)
    blur = seidel.circle_of_confusion(lens, image, depth, settings=settings)
    assert blur.shape == depth.shape and blur.dtype == np.float32
    assert blur[20, 36] < 0.0 < blur[5, 5]
    picked = seidel.circle_of_confusion(lens, image, depth, settings=seidel.Settings(focus_distance=post))
    assert np.abs(picked[20, 36]) < np.abs(blur[20, 36])


def test_doubts_about_a_depth_pass_are_warnings(lens, image, depth):
    scaled = depth / depth.max()
    with pytest.warns(seidel.DepthWarning, match=r"normalised.*DepthPass.kind"):
        seidel.apply(lens, image, scaled, settings=seidel.Settings(maximum_size=20.0))


def test_depth_has_the_size_of_the_image(lens, image, depth):
    with pytest.raises(seidel.InvalidInput, match="depth: has 53 x 96 pixels"):
        seidel.apply(lens, image, depth[1:])
    with pytest.raises(seidel.InvalidInput, match="3 channels"):
        seidel.apply(lens, image, image)
    one_channel = seidel.apply(lens, image, depth[..., None])
    assert np.array_equal(one_channel, seidel.apply(lens, image, depth))
