"""Settings, depth passes, mattes and observations: values that the compiled part of the package reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class Look:
    """Artistic changes of a lens traced ray by ray. The defaults leave it as measured, to the bit.

    They act on the lens as f-number and focus distance set it. docs/guide/looks.md shows them.
    """

    blades: int | None = None
    """Iris blades: 3 to 13, or 0 for a round iris; those of the lens if ``None``."""
    roundness: float = 0.0
    """Curvature of the blades, 0 (straight) to 1 (one circle)."""
    rotation: float = 0.0
    """Direction of one corner of discs before the focus, -180 to 180 degrees from right towards down. Discs behind the focus are
    turned by 180 degrees."""
    aperture_picture: NDArray[Any] | None = None
    """Picture of the aperture, white (1) where light passes: array of rows x columns, with or without 1 to 4 channels, ``float32``
    or ``float16``. Background discs show it. Its shorter side is the width of the pupil."""
    squeeze: float = 1.0
    """Height of discs over their width, 0.4 to 2.5, times that of the lens."""
    obstruction: float = 0.0
    """Radius of the dark middle of discs, 0 to 0.9 of theirs."""
    cats_eye: float = 0.0
    """Cat's eyes towards the corners: -1 for round discs, 0 as the lens, 1 for strong ones."""
    spherical: float = 0.0
    """Spherical aberration added: -1 for soft discs behind the focus, 1 for bubbles with bright rims."""
    axial_colour: float = 1.0
    """Factor on the difference of focus between channels, -4 to 4."""
    lateral_colour: float = 1.0
    """Factor on the difference of magnification between channels, -4 to 4."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of ``apply``, ``remove`` and ``relens``. The defaults use the lens as measured.

    The options of the command ``seidel`` have the same names. ``dataclasses.replace`` returns settings with changes.
    """

    amount: float = 1.0
    """Strength of blur and displacement, 0 (none) to 16; 1 is as measured."""
    psf_model: str | None = None
    """Identifier of the PSF model, such as ``pupil``; the best for the lens if ``None``."""
    channel_scales: Mapping[str, float] = field(default_factory=dict)
    """Strength of the blur of lens channels by name, on top of ``amount``: above 0, up to 16."""
    axis_offset_px: tuple[float, float] = (0.0, 0.0)
    """Offset of the optical axis, image pixels right and down."""
    geometry: Literal["none", "lateral", "full"] = "lateral"
    """Displacement: none, lateral colour, or lateral colour and distortion."""
    focus_distance: float | None = None
    """Focus distance, metres, may be ``math.inf``; as measured if ``None``."""
    f_number: float | None = None
    """F-number; as measured if ``None``."""
    sensor_shift_um: float | None = None
    """Shift of the sensor away from the lens, micrometres; as measured if ``None``."""
    focal_length_mm: float | None = None
    """Focal length to scale the lens and its frame to, millimetres; f-number and focus distance stay. As measured if ``None``."""
    depth_of_field: float = 0.0
    """Range around the focus plane that is as sharp as the plane, metres, half of it on each side."""
    front_multiplier: float = 1.0
    """Factor of the vergence difference to the focus plane for objects in front of it, 0 to 16."""
    back_multiplier: float = 1.0
    """Factor of the vergence difference to the focus plane for objects behind it, 0 to 16."""
    maximum_size: float | None = None
    """Largest kernel, as the radius of a uniform disc, image pixels; no limit if ``None``."""
    quality: Literal["draft", "final", "exact"] = "final"
    """Accuracy of ``apply`` against the exact renderer: 45 dB, 60 dB (50 dB ray by ray), or exact, which is slow."""
    edges: Literal["auto", "mirror", "black", "extend"] = "auto"
    """Light beyond the edges of the image in ``apply``: chosen by the alpha of the border, the mirrored image, black, or the
    nearest pixel."""
    occlusion: bool = True
    """Near surfaces occlude far ones in ``apply``; otherwise the light of all depths is added."""
    fill_foreground: bool = True
    """Background that a blurred foreground uncovers is filled from the background beside it."""
    blur_inside: bool = True
    """A blurred foreground becomes transparent inside its own outline."""
    noise: float | Sequence[float] | None = None
    """Standard deviation of the noise for a removal, scene-linear: one for all colours or one for each; estimated if
    ``None``."""
    clip: float | Literal["auto", "none"] = "auto"
    """Level from which samples count as clipped in a removal."""
    strength: float = 1.0
    """Weight of the sharp image against the given one in ``remove``, 0 to 1."""
    grain: Literal["keep", "solved"] = "keep"
    """Grain of the sharp image of ``remove``: that of the given one, or that of the solution, which has hardly any."""
    alpha: Literal["premultiplied", "unpremultiplied"] = "premultiplied"
    """Relation of colour and alpha."""
    scrub: bool = False
    """Samples that are not finite count as zero; otherwise they are an error."""
    lens_scale: float | None = None
    """Image pixels per pixel of the lens's frame, along y; if ``None`` the image is as wide as the frame."""
    film_back_mm: float | None = None
    """Width of the sensor that the display window shows, millimetres, instead of ``lens_scale``: a smaller sensor crops the lens's
    frame. The lens must have a pixel pitch."""
    pixel_aspect: float = 1.0
    """Width of a pixel over its height in the scene, 1/16 to 16: 2 for an image of a 2x anamorphic lens before it is
    desqueezed."""
    display_window: tuple[int, int, int, int] | None = None
    """Display window (x, y, width, height) in image pixels from the top-left corner of the array, which is the data window: of an
    image with overscan, or of a part of a picture. It lies centre on centre with the lens's frame. The array if ``None``."""
    threads: int = 0
    """Most threads; 0 for one each core. Results do not depend on it."""
    look: Look = Look()
    """Artistic changes of the lens of ``apply``, and of the new lens of ``relens``."""
    bloom: float = 0.0
    """Share of the light above ``bloom_level`` that spreads around highlights, 0 to 1, in ``apply`` and ``relens``; any lens."""
    bloom_level: float = 1.0
    """Scene-linear value above which light spreads."""
    bloom_radius: float = 1.0
    """Radius that holds half of the spread light, 0.05 to 20 % of the width of the lens's frame."""


@dataclass(frozen=True, eq=False)
class DepthPass:
    """A depth pass whose samples are not metres along the optical axis."""

    samples: NDArray[Any]
    """Array of rows x columns, ``float32`` or ``float16``."""
    kind: Literal["distance", "inverse", "far-one", "far-zero"] = "distance"
    """Meaning: distance, 1 / distance, or a distance scaled to 0 at ``near`` and 1 at ``far`` (``far-one``) or the
    reverse (``far-zero``)."""
    unit: float = 1.0
    """Metres per unit of distance; negative if depth is negative."""
    near: float | None = None
    """Nearest distance of a scaled depth, metres."""
    far: float | None = None
    """Farthest distance of a scaled depth, metres."""
    along_ray: float | None = None
    """Focal length in pixel widths, if distances are measured along the ray from the camera."""


@dataclass(frozen=True, eq=False)
class Holdout:
    """A matte of an object that will be merged in front later, with its depth."""

    matte: NDArray[Any]
    """Array of rows x columns, ``float32`` or ``float16``, 0 to 1."""
    depth: NDArray[Any] | DepthPass | None = None
    """Depth of the object: only light from behind it is held out. All is if ``None``."""


@dataclass(frozen=True, eq=False)
class Background:
    """The image without its foreground, such as a clean plate."""

    image: NDArray[Any]
    """Array of the size and channels of the image."""
    depth: NDArray[Any] | DepthPass | float
    """Its depth, as that of the image."""


@dataclass(frozen=True, eq=False)
class Observation:
    """An observed point of light."""

    x: float
    """Frame pixels from the left edge to the centre of the tile."""
    y: float
    """Frame pixels from the top edge to the centre of the tile."""
    distance: float | None
    """Object distance, metres; ``math.inf`` for infinity, ``None`` if unknown."""
    tile: NDArray[Any]
    """PSF of each channel: array of rows x columns, or rows x columns x channels, ``float32`` or ``float16``,
    scene-linear, without background."""
