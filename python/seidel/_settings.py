"""Settings of calls. Written by ``cargo xtask knobs`` from the table of knobs; do not edit."""

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

    Attributes:
        blades: Iris blades: 3 to 13, or 0 for a round iris; those of the lens if ``None``.
        aperture_picture: Picture of the aperture, white (1) where light passes: array of rows x columns, with
            or without 1 to 4 channels, ``float32`` or ``float16``. Background discs show it. Its shorter side is
            the width of the pupil.
        roundness: Curvature of the iris blades: 0 straight, 1 one circle (0 to 1).
        rotation: Direction of one corner of discs before the focus, from right towards down (-180 to 180
            degrees). Discs behind the focus are turned by 180 degrees.
        squeeze: Height of discs over their width, times that of the lens: 2 for the ovals of a 2x anamorphic
            lens (0.4 to 2.5).
        obstruction: Radius of the dark middle of discs over theirs, as of a mirror lens; 0 as the lens (0 to
            0.9).
        cats_eye: Cat's eyes towards the corners: -1 round discs, 0 as the lens, 1 strong ones (-1 to 1).
        spherical: Spherical aberration added: -1 soft discs behind the focus, 1 bubbles with bright rims (-1 to
            1). Before the focus it is the other way round.
        axial_colour: Factor on the difference of focus between channels: 0 none, 1 as the lens (-4 to 4).
        lateral_colour: Factor on the difference of magnification between channels: 0 none, 1 as the lens (-4 to
            4). Without lateral colour in the geometry it has no effect.
        tilt: Tilt of the lens, as of a tilt-shift lens: the plane of focus turns by Scheimpflug's rule (-30 to
            30 degrees). Needs a lens of known focal length and f-number.
        tilt_direction: Direction in the picture along which the tilted plane of focus comes nearer, from right
            towards down: 90 lays it along the ground (-180 to 180 degrees). At -90 one strip of the ground is
            sharp, as in photographs of small models.
    """

    blades: int | None = None
    aperture_picture: NDArray[Any] | None = None
    roundness: float = 0.0
    rotation: float = 0.0
    squeeze: float = 1.0
    obstruction: float = 0.0
    cats_eye: float = 0.0
    spherical: float = 0.0
    axial_colour: float = 1.0
    lateral_colour: float = 1.0
    tilt: float = 0.0
    tilt_direction: float = 90.0


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of ``apply``, ``remove`` and ``relens``. The defaults use the lens as measured.

    The options of the command ``seidel`` have the same names. ``dataclasses.replace`` returns settings with changes.

    Attributes:
        amount: Strength of the lens's blur and displacement: 0 leaves the plate unchanged, 1 is as measured (0
            to 16).
        focal_length_mm: Focal length to scale the lens and its frame to; f-number and focus distance stay
            (millimetres; as measured if ``None``). Blur is that of a lens of this focal length with the measured
            one's aberrations. For lenses of rays: those of the library, and those fitted by the model reduced or
            extended.
        f_number: F-number to stop the lens down to (as measured if ``None``). Below the measured one the blur
            is extrapolated. For lenses of rays.
        sensor_shift_um: Shift of the sensor away from the lens; negative towards it (micrometres; as measured
            if ``None``). For lenses of rays.
        geometry: Displacement of light by the lens.
        lens_scale: Scale of the lens's frame on the plate, along y (plate pixels per pixel of the lens's frame;
            from the display window if ``None``).
        film_back_mm: Width of the sensor that the display window shows (film back), instead of the lens scale:
            a smaller sensor crops the lens's frame (millimetres; by the lens scale if ``None``). Common widths: 36
            for full frame, 24.9 for Super 35, 12.5 for Super 16. The lens profile must have a pixel pitch. Beyond
            the frame of the lens its blur is extrapolated.
        focus_distance: Distance to focus the lens on (metres or inf; as measured if ``None``). For lenses of
            rays: those of the library, and those fitted by the model reduced or extended.
        depth_of_field: Depth of the range that is as sharp as the focus plane, half of it on each side
            (metres). Beyond the range, depth is measured from its nearer end.
        front_multiplier: Factor on the distance from focus, in vergence, in front of the focus plane: blur
            grows as many times as fast (0 to 16).
        back_multiplier: Factor on the distance from focus, in vergence, behind the focus plane (0 to 16).
        maximum_size: Radius of the largest kernel in the frame: that of a uniform disc (plate pixels; none if
            ``None``). For other kernels it is two standard deviations. A larger kernel is replaced by that of the
            distance at which it has this radius.
        bloom: Share of the light above the bloom level that spreads around highlights; any lens (0 to 1).
        bloom_level: Value above which light spreads (scene-linear).
        bloom_radius: Radius that holds half of the spread light (0.05 to 20 per cent of the width of the lens's
            frame).
        quality: Accuracy of the render, as PSNR against the exact renderer; in ``apply``.
        edges: Light beyond the edges of the plate; in ``apply``.
        occlusion: Near surfaces occlude far ones where depth varies; otherwise the light of all depths is
            added; in ``apply``.
        fill_foreground: Background that a blurred foreground uncovers is filled from the background beside it,
            rather than with the foreground's own light; in ``apply``.
        blur_inside: A blurred foreground becomes transparent inside its own outline too, as in a camera;
            otherwise it only blurs outwards; in ``apply``.
        mix: Weight of the blurred plate against its own pixels, times that of the mask (0 to 1); in ``apply``.
        mask_scales: What the mask scales; in ``apply``. The blur is scaled before it is rendered, so a part
            that a mask keeps sharp has no blurred copy of itself around it.
        only_chroma: The lens's axial and lateral colour alone, without the blur that all colours share; in
            ``apply``. At each place and distance the sharpest colour stays sharp, and the others blur by as much as
            their variance exceeds its own.
        strength: Weight of the sharp image against the plate: 0 leaves the plate unchanged (0 to 1); in
            ``remove``.
        grain: Grain of the sharp image; in ``remove``.
        from_focal_length_mm: Focal length of the lens that the plate was taken with (millimetres; that of both
            lenses if ``None``); in ``relens``.
        from_f_number: F-number of the lens that the plate was taken with (that of both lenses if ``None``); in
            ``relens``.
        from_sensor_shift_um: Shift of the sensor of the lens that the plate was taken with (micrometres; that
            of both lenses if ``None``); in ``relens``.
        from_focus_distance: Focus distance of the lens that the plate was taken with (metres or inf; that of
            both lenses if ``None``); in ``relens``.
        to_focal_length_mm: Focal length of the lens whose blur the plate gets (millimetres; that of both lenses
            if ``None``); in ``relens``.
        to_f_number: F-number of the lens whose blur the plate gets (that of both lenses if ``None``); in
            ``relens``.
        to_sensor_shift_um: Shift of the sensor of the lens whose blur the plate gets (micrometres; that of both
            lenses if ``None``); in ``relens``.
        to_focus_distance: Focus distance of the lens whose blur the plate gets (metres or inf; that of both
            lenses if ``None``); in ``relens``.
        psf_model: Identifier of the PSF model, such as ``pupil``; the best for the lens if ``None``.
        channel_scales: Strength of the blur of lens channels by name, on top of ``amount``: above 0, up to 16.
        axis_offset_px: Offset of the optical axis, image pixels right and down.
        noise: Standard deviation of the plate's noise: one for all colours, or one for each (scene-linear;
            estimated from the plate if ``None``).
        clip: Level from which samples are clipped: they and the pixels that their light reaches keep their
            blur.
        alpha: Relation of colour and alpha.
        scrub: Samples that are not finite count as zero; otherwise they are an error.
        pixel_aspect: Width of a pixel over its height in the scene, 1/16 to 16: 2 for an image of a 2x
            anamorphic lens before it is desqueezed.
        display_window: Display window (x, y, width, height) in image pixels from the top-left corner of the
            array, which is the data window: of an image with overscan, or of a part of a picture. It lies centre on
            centre with the lens's frame. The array if ``None``.
        threads: Most threads; 0 for one each core. Results do not depend on it.
        look: Artistic changes of the lens of ``apply``, and of the new lens of ``relens``.
    """

    amount: float = 1.0
    focal_length_mm: float | None = None
    f_number: float | None = None
    sensor_shift_um: float | None = None
    geometry: Literal["none", "lateral", "full"] = "lateral"
    lens_scale: float | None = None
    film_back_mm: float | None = None
    focus_distance: float | None = None
    depth_of_field: float = 0.0
    front_multiplier: float = 1.0
    back_multiplier: float = 1.0
    maximum_size: float | None = None
    bloom: float = 0.0
    bloom_level: float = 1.0
    bloom_radius: float = 1.0
    quality: Literal["draft", "final", "exact"] = "final"
    edges: Literal["mirror", "black", "extend", "auto"] = "auto"
    occlusion: bool = True
    fill_foreground: bool = True
    blur_inside: bool = True
    mix: float = 1.0
    mask_scales: Literal["mix", "blur"] = "mix"
    only_chroma: bool = False
    strength: float = 1.0
    grain: Literal["keep", "solved"] = "keep"
    from_focal_length_mm: float | None = None
    from_f_number: float | None = None
    from_sensor_shift_um: float | None = None
    from_focus_distance: float | None = None
    to_focal_length_mm: float | None = None
    to_f_number: float | None = None
    to_sensor_shift_um: float | None = None
    to_focus_distance: float | None = None
    psf_model: str | None = None
    channel_scales: Mapping[str, float] = field(default_factory=dict)
    axis_offset_px: tuple[float, float] = (0.0, 0.0)
    noise: float | Sequence[float] | None = None
    clip: float | Literal["auto", "none"] = "auto"
    alpha: Literal["premultiplied", "unpremultiplied"] = "premultiplied"
    scrub: bool = False
    pixel_aspect: float = 1.0
    display_window: tuple[int, int, int, int] | None = None
    threads: int = 0
    look: Look = Look()
