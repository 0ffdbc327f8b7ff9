"""Depth passes, mattes and observations: values that the compiled part of the package reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from numpy.typing import NDArray


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
    filter_px: float = 0.0
    """Width over which the depth is averaged at edges, by a filter or by motion over the shutter, pixels, up to 256: edges up to
    that wide are divided between their two sides."""


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
