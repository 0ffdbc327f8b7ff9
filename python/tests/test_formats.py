"""Arrays of packages that read and write images."""

import numpy as np
import pytest

import seidel


def package(name):
    """Returns a package, or skips the test."""
    return pytest.importorskip(name, reason=f"{name} is not installed")


@pytest.fixture
def blurred(lens, image, depth):
    return seidel.apply(lens, image, depth)


@pytest.mark.parametrize("sample", [np.float32, np.float16])
def test_openexr(lens, image, depth, tmp_path, sample):
    exr = package("OpenEXR")
    path = str(tmp_path / "plate.exr")
    header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
    planes = {"RGB": image.astype(sample), "Z": depth.astype(sample)}
    exr.File(header, planes).write(path)
    with exr.File(path) as file:
        channels = file.channels()
        plate, distance = channels["RGB"].pixels, channels["Z"].pixels
        result = seidel.apply(lens, plate, distance)
    expected = seidel.apply(lens, image.astype(sample), depth.astype(sample))
    assert result.dtype == sample and np.array_equal(result, expected)
    exr.File(header, {"RGB": result}).write(path)
    with exr.File(path) as file:
        assert np.array_equal(file.channels()["RGB"].pixels, result)


@pytest.mark.parametrize("kind", ["float", "half"])
def test_openimageio(lens, image, depth, tmp_path, kind):
    oiio = package("OpenImageIO")
    sample = np.float32 if kind == "float" else np.float16
    path = str(tmp_path / "plate.exr")
    buffer = oiio.ImageBuf(image.astype(sample))
    buffer.write(path, kind)
    plate = oiio.ImageBuf(path).get_pixels(kind)
    result = seidel.apply(lens, plate, depth)
    assert np.array_equal(result, seidel.apply(lens, image.astype(sample), depth))
    assert oiio.ImageBuf(result).write(path, kind)
    assert np.array_equal(oiio.ImageBuf(path).get_pixels(kind), result)


def test_imageio(lens, image, depth, tmp_path):
    imageio = package("imageio.v3")
    path = tmp_path / "plate.png"
    imageio.imwrite(path, np.clip(255.0 * image, 0.0, 255.0).astype(np.uint8))
    codes = imageio.imread(path)
    with pytest.warns(UserWarning, match="uint8"):
        seidel.apply(lens, codes, depth)
    # Codes of 8 bits are not scene-linear: here by the pure power of display.
    plate = (codes.astype(np.float32) / 255.0) ** 2.2
    result = seidel.apply(lens, plate, depth)
    assert result.shape == codes.shape and not np.array_equal(result, plate)
    imageio.imwrite(path, (255.0 * np.clip(result, 0.0, 1.0) ** (1 / 2.2)).astype(np.uint8))
    assert imageio.imread(path).shape == codes.shape


def test_torch(lens, image, depth):
    torch = package("torch")
    tensors = torch.from_numpy(image), torch.from_numpy(depth)
    assert np.array_equal(seidel.apply(lens, *tensors), seidel.apply(lens, image, depth))
    with pytest.raises(seidel.InvalidInput, match=r"detach\(\)"):
        seidel.apply(lens, tensors[0].requires_grad_(), depth)


def test_pillow(lens, image, depth):
    pillow = package("PIL.Image")
    picture = pillow.fromarray(np.clip(255.0 * image, 0.0, 255.0).astype(np.uint8))
    with pytest.warns(UserWarning, match="uint8"):
        result = seidel.apply(lens, picture, pillow.fromarray(depth))
    assert np.array_equal(result, seidel.apply(lens, np.asarray(picture, np.float32), depth))
