"""Results are those of the command, to the bit."""

import json

import exr_files
import numpy as np
import pytest
from conftest import LENS

import seidel
from seidel import DepthPass, Look, Settings


@pytest.fixture
def blur(command, tmp_path):
    """Returns a function that runs a command on an image and returns the image that it wrote."""

    def run(name, image, *options, depth=None):
        lens = [] if name == "relens" else ["--lens", LENS]
        arguments = [name, tmp_path / "in.exr", *lens, "-o", tmp_path / "out.exr", *options]
        exr_files.write_image(tmp_path / "in.exr", image)
        if depth is not None:
            exr_files.write(tmp_path / "depth.exr", {"Z": depth})
            arguments += ["--depth", tmp_path / "depth.exr"]
        command(*arguments)
        return exr_files.read_image(tmp_path / "out.exr", image.shape[2])

    return run


def assert_same(result, expected):
    assert result.dtype == expected.dtype and result.shape == expected.shape
    assert result.tobytes() == expected.tobytes()


def test_a_plate_at_one_distance(lens, image, blur):
    expected = blur("apply", image, "--distance", "3")
    assert not np.array_equal(expected, image)
    assert_same(seidel.apply(lens, image, 3.0), expected)


def test_a_plate_with_depth(lens, image, depth, blur):
    assert_same(seidel.apply(lens, image, depth), blur("apply", image, depth=depth))


def test_half_floats(lens, image, depth, blur):
    image = image.astype(np.float16)
    image[5, 5] = 60000.0
    expected = blur("apply", image, depth=depth.astype(np.float16))
    assert_same(seidel.apply(lens, image, depth.astype(np.float16)), expected)


@pytest.mark.parametrize("channels", [1, 2, 4])
def test_grey_plates_and_alpha(lens, image, depth, blur, channels):
    alpha = np.ones_like(image[..., :1])
    colours = image[..., :1] if channels <= 2 else image
    plate = np.concatenate([colours, alpha], axis=-1)[..., :channels]
    assert_same(seidel.apply(lens, plate, depth), blur("apply", plate, depth=depth))


def test_elements_over_nothing(lens, image, blur):
    alpha = np.zeros_like(image[..., :1])
    alpha[20:30, 40:60] = 1.0
    element = np.concatenate([image * alpha, alpha], axis=-1)
    expected = blur("apply", element, "--distance", "2.5", "--expand", "off")
    assert_same(seidel.apply(lens, element, 2.5), expected)


SETTINGS = [
    (Settings(amount=0.5, edges="black"), ["--amount", "0.5", "--edges", "black"]),
    (Settings(quality="draft", geometry="none"), ["--quality", "draft", "--geometry", "none"]),
    (Settings(quality="exact", psf_model="gaussian"), ["--quality", "exact", "--psf", "gaussian"]),
    (Settings(f_number=2.8, focus_distance=3.0), ["--f-number", "2.8", "--focus-distance", "3"]),
    (
        Settings(channel_scales={"R": 1.5}, axis_offset_px=(3.0, -2.0)),
        ["--channel-scale", "R=1.5", "--axis-offset", "3,-2"],
    ),
    (
        Settings(focal_length_mm=35.0, film_back_mm=24.9),
        ["--focal-length-mm", "35", "--film-back-mm", "24.9"],
    ),
    (Settings(lens_scale=0.2, pixel_aspect=1.2), ["--lens-scale", "0.2", "--pixel-aspect", "1.2"]),
    (
        Settings(
            look=Look(blades=5, roundness=0.3, rotation=20.0, squeeze=1.5, obstruction=0.2),
            bloom=0.4,
            bloom_level=0.3,
            bloom_radius=2.0,
        ),
        "--blades 5 --roundness 0.3 --rotation 20 --squeeze 1.5 --obstruction 0.2 "
        "--bloom 0.4 --bloom-level 0.3 --bloom-radius 2".split(),
    ),
    (
        Settings(look=Look(cats_eye=0.3, spherical=0.5, axial_colour=2.0, lateral_colour=0.0)),
        "--cats-eye 0.3 --spherical 0.5 --axial-colour 2 --lateral-colour 0".split(),
    ),
    (
        Settings(look=Look(tilt=6.0, tilt_direction=-60.0)),
        "--tilt 6 --tilt-direction -60".split(),
    ),
]


@pytest.mark.parametrize(("settings", "options"), SETTINGS)
def test_settings(lens, image, blur, settings, options):
    expected = blur("apply", image, "--distance", "3", *options)
    assert_same(seidel.apply(lens, image, 3.0, settings=settings), expected)


def test_settings_of_occlusion_and_focus(lens, image, depth, blur):
    settings = Settings(fill_foreground=False, depth_of_field=0.5, maximum_size=4.0)
    options = ["--no-fill-foreground", "--depth-of-field", "0.5", "--maximum-size", "4"]
    expected = blur("apply", image, *options, depth=depth)
    assert_same(seidel.apply(lens, image, depth, settings=settings), expected)


def test_depth_conventions(lens, image, depth, blur):
    scaled = (depth - 1.0) / 4.0
    options = ["--depth-kind", "far-one", "--near", "1", "--far", "5"]
    expected = blur("apply", image, *options, depth=scaled)
    scaled_pass = DepthPass(scaled, kind="far-one", near=1.0, far=5.0)
    assert_same(seidel.apply(lens, image, scaled_pass), expected)
    expected = blur("apply", image, "--depth-kind", "inverse", depth=1.0 / depth)
    assert_same(seidel.apply(lens, image, DepthPass(1.0 / depth, kind="inverse")), expected)


def test_holdouts(lens, image, depth, blur, tmp_path):
    matte = np.zeros_like(depth)
    matte[15:40, 50:80] = 0.75
    near = np.full_like(depth, 3.0)
    exr_files.write(tmp_path / "matte.exr", {"A": matte})
    exr_files.write(tmp_path / "near.exr", {"Z": near})
    options = ["--holdout", tmp_path / "matte.exr"]
    whole = seidel.apply(lens, image, depth, holdout=matte)
    assert_same(whole, blur("apply", image, *options, depth=depth))
    assert not np.array_equal(whole, seidel.apply(lens, image, depth))
    options += ["--holdout-depth", tmp_path / "near.exr"]
    behind = seidel.apply(lens, image, depth, holdout=seidel.Holdout(matte, near))
    assert_same(behind, blur("apply", image, *options, depth=depth))
    assert not np.array_equal(whole, behind)


def test_backgrounds(lens, image, depth, blur, tmp_path):
    clean, far = 0.5 * image[:, ::-1], np.full_like(depth, 4.0)
    planes = {name: np.ascontiguousarray(clean[..., k]) for k, name in enumerate("RGB")}
    exr_files.write(tmp_path / "clean.exr", {**planes, "Z": far})
    expected = blur("apply", image, "--background", tmp_path / "clean.exr", depth=depth)
    background = seidel.Background(clean, far)
    result = seidel.apply(lens, image, depth, background=background)
    assert_same(result, expected)
    assert not np.array_equal(result, seidel.apply(lens, image, depth))
    options = ["--background", tmp_path / "clean.exr", "--lens-check", "off", "--no-overscan"]
    expected = blur("remove", image, *options, depth=depth)
    result = seidel.remove(lens, image, depth, background=background)
    assert_same(result, expected)
    assert not np.array_equal(result, seidel.remove(lens, image, depth))
    maps = seidel.remove_with_maps(lens, image, depth, background=background)
    assert np.array_equal(maps.image, result)


def test_alphas_of_colours(lens, image, depth, command, tmp_path):
    alpha = np.ones_like(image[..., :1])
    alpha[10:40, 20:50] = 0.0
    element = np.concatenate([image * alpha, alpha], axis=-1)
    exr_files.write_image(tmp_path / "in.exr", element)
    exr_files.write(tmp_path / "depth.exr", {"Z": depth})
    files = [tmp_path / "in.exr", "--depth", tmp_path / "depth.exr", "-o", tmp_path / "out.exr"]
    command("apply", *files, "--lens", LENS, "--alpha-per-channel", "--expand", "off")
    written = exr_files.read(tmp_path / "out.exr")
    names = ["R", "G", "B", "A", "alpha.R", "alpha.G", "alpha.B"]
    expected = np.stack([written[name] for name in names], axis=-1)
    result = seidel.apply(lens, np.concatenate([element, alpha, alpha, alpha], axis=-1), depth)
    assert_same(result, expected)
    assert not np.array_equal(result[..., 4], result[..., 6])


def test_overscan(lens, image, command, tmp_path):
    window = (8, 6, 80, 42)
    exr_files.write_image(tmp_path / "in.exr", image, window)
    options = ["--distance", "3", "--edges", "black", "--lens-scale", "0.2"]
    command("apply", tmp_path / "in.exr", "--lens", LENS, "-o", tmp_path / "out.exr", *options)
    settings = Settings(display_window=window, edges="black", lens_scale=0.2)
    result = seidel.apply(lens, image, 3.0, settings=settings)
    assert_same(result, exr_files.read_image(tmp_path / "out.exr", 3))


def test_maps_of_a_removal(lens, image, command, tmp_path):
    blurred = seidel.apply(lens, image, 2.5)
    exr_files.write_image(tmp_path / "in.exr", blurred)
    maps = ["--confidence", tmp_path / "confidence.exr", "--noise-gain", tmp_path / "gain.exr"]
    options = ["--lens", LENS, "--distance", "2.5", "--no-overscan", "--lens-check", "off"]
    command("remove", tmp_path / "in.exr", "-o", tmp_path / "out.exr", *options, *maps)
    found = seidel.remove_with_maps(lens, blurred, 2.5, noise_gain=True)
    assert_same(found.image, exr_files.read_image(tmp_path / "out.exr", 3))
    assert_same(found.confidence, exr_files.read_image(tmp_path / "confidence.exr", 3))
    assert_same(found.noise_gain, exr_files.read_image(tmp_path / "gain.exr", 3))
    assert len(found.noise) == 3 and all(noise > 0.0 for noise in found.noise)
    plain = seidel.remove_with_maps(lens, blurred, 2.5)
    assert plain.noise_gain is None and plain.noise == found.noise


def test_the_lens_check(lens, blur):
    random = np.random.default_rng(4)
    squares = random.random((18, 32, 1)).repeat(6, axis=0).repeat(6, axis=1)
    texture = (0.05 + 0.9 * squares * np.array([1.0, 0.9, 0.7])).astype(np.float32)
    half = seidel.apply(lens, texture, 2.5, settings=Settings(amount=0.5, lens_scale=0.5))
    half += random.normal(0.0, 0.002, half.shape).astype(np.float32)
    share = seidel.blur_share(lens, half, 2.5, settings=Settings(lens_scale=0.5))
    assert 0.4 < share < 0.6
    expected = blur("remove", half, "--distance", "2.5", "--no-overscan", "--lens-scale", "0.5")
    settings = Settings(amount=share, lens_scale=0.5)
    assert_same(seidel.remove(lens, half, 2.5, settings=settings), expected)


def test_removal(lens, image, blur):
    blurred = seidel.apply(lens, image, 2.5)
    options = ["--distance", "2.5", "--no-overscan", "--lens-check", "off"]
    expected = blur("remove", blurred, *options)
    assert_same(seidel.remove(lens, blurred, 2.5), expected)
    settings = Settings(noise=0.01, clip="none", grain="solved", strength=0.7)
    options += ["--noise", "0.01", "--clip", "none", "--grain", "solved", "--strength", "0.7"]
    expected = blur("remove", blurred, *options)
    assert_same(seidel.remove(lens, blurred, 2.5, settings=settings), expected)


def test_another_lens(lens, image, blur, tmp_path):
    stopped_down = lens.adjusted(f_number=2.8)
    stopped_down.save(tmp_path / "to.json")
    options = ["--from", LENS, "--to", tmp_path / "to.json", "--distance", "2.5"]
    expected = blur("relens", image, *options, "--lens-check", "off")
    assert_same(seidel.relens(lens, stopped_down, image, 2.5), expected)


def test_colour_fringes(lens, image, blur):
    expected = blur("remove", image, "--distance", "2.5", "--only-chroma")
    assert not np.array_equal(expected, image)
    assert_same(seidel.match_colours(lens, image, 2.5), expected)


def test_fits(observations, command, tmp_path):
    observations.save(tmp_path / "set")
    command("fit", tmp_path / "set", "-o", tmp_path / "lens.json", "--model", "moments")
    seidel.Lens.fit(tmp_path / "set", model="moments").save(tmp_path / "own.json")
    assert (tmp_path / "own.json").read_bytes() == (tmp_path / "lens.json").read_bytes()


def test_psfs(lens, command, tmp_path):
    at = [(480.0, 270.0), (901.5, 88.25)]
    point = np.zeros((41, 41, 3), np.float32)
    point[20, 20] = 1.0
    template = [seidel.Observation(x, y, 2.5, point) for x, y in at]
    template = seidel.ObservationSet(lens.frame_size, lens.channels, template)
    template.save(tmp_path / "set")
    command("psf", "--lens", LENS, "--like", tmp_path / "set", "--out", tmp_path / "drawn")
    own = [seidel.Observation(x, y, 2.5, lens.psf(x, y, 2.5, size=41)) for x, y in at]
    seidel.ObservationSet(lens.frame_size, lens.channels, own).save(tmp_path / "own")
    tiles = sorted(path.relative_to(tmp_path / "own") for path in (tmp_path / "own").rglob("*.*"))
    assert len(tiles) > 1
    for tile in tiles:
        assert (tmp_path / "own" / tile).read_bytes() == (tmp_path / "drawn" / tile).read_bytes()


def test_diagnoses(lens, command, tmp_path):
    moved = lens.adjusted(sensor_shift_um=30.0)
    found = [
        seidel.Observation(x, y, 2.5, moved.psf(x, y, 2.5, size=61))
        for x in (80.0, 240.0, 400.0, 560.0, 720.0, 880.0)
        for y in (60.0, 200.0, 340.0, 480.0)
    ]
    seidel.ObservationSet(lens.frame_size, lens.channels, found).save(tmp_path / "set")
    only = ["defocus_offset", "decentre"]
    out = tmp_path / "out"
    options = ["--out", out, "--only", ",".join(only), "--no-pairs"]
    command("diagnose", tmp_path / "set", "--lens", LENS, *options)
    diagnosis = seidel.diagnose(lens, tmp_path / "set", only=only, pairs=False)
    expected = json.loads((out / "report.json").read_text())
    for key, value in diagnosis.report.items():
        assert expected[key] == value, key
    assert (diagnosis.verdict, diagnosis.added) == (expected["verdict"], expected["added"])
    diagnosis.corrected.save(tmp_path / "own.json")
    assert (tmp_path / "own.json").read_bytes() == (out / "corrected.json").read_bytes()


def test_diagnoses_pictures(lens, command, tmp_path):
    random = np.random.default_rng(11)
    width, height = lens.frame_size
    # Texture of several widths: blur leaves little of noise alone.
    reference = np.zeros((height, width, 3), np.float32)
    for side in (1, 3, 9):
        shape = (-(-height // side), -(-width // side), 3)
        blocks = random.uniform(0.0, 0.3, shape).astype(np.float32)
        blocks = blocks.repeat(side, axis=0).repeat(side, axis=1)
        reference += blocks[:height, :width]
    observed = seidel.apply(lens.adjusted(sensor_shift_um=10.0), reference, 2.5)
    exr_files.write_image(tmp_path / "reference.exr", reference)
    exr_files.write_image(tmp_path / "observed.exr", observed)
    only = ["defocus_offset", "decentre"]
    out = tmp_path / "out"
    pair = ["--reference", tmp_path / "reference.exr", "--observed", tmp_path / "observed.exr"]
    options = ["--distance", "2.5", "--out", out, "--only", ",".join(only), "--no-pairs"]
    command("diagnose", "--lens", LENS, *pair, *options)
    shares = []
    diagnosis = seidel.diagnose_pictures(
        lens, reference, observed, distance=2.5, only=only, pairs=False, progress=shares.append
    )
    assert shares[0] == 0.0 and shares[-1] == 1.0 and shares == sorted(shares)
    expected = json.loads((out / "report.json").read_text().replace(".exr", ""))
    # The command names the files.
    remark = expected["remarks"].pop()
    assert remark.startswith(f"{len(diagnosis.estimated)} PSFs were estimated from reference")
    for key, value in diagnosis.report.items():
        assert expected[key] == value, key
    assert diagnosis.added == ["defocus_offset"] == expected["added"]
    diagnosis.corrected.save(tmp_path / "own.json")
    assert (tmp_path / "own.json").read_bytes() == (out / "corrected.json").read_bytes()
    diagnosis.estimated.save(tmp_path / "psf")
    tiles = sorted(path.relative_to(tmp_path / "psf") for path in (tmp_path / "psf").rglob("*.exr"))
    assert len(tiles) == len(diagnosis.estimated) > 1
    for tile in tiles:
        assert (tmp_path / "psf" / tile).read_bytes() == (out / "psf" / tile).read_bytes()
