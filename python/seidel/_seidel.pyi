"""Types of the compiled part of the package. The docstrings are in the compiled module."""

from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from ._inputs import Background, DepthPass, Holdout, Observation
from ._settings import Look, Settings

__all__ = [
    "Diagnosis",
    "LeftOut",
    "Lens",
    "LightMeasurement",
    "ObservationSet",
    "Removal",
    "__version__",
    "apply",
    "blur_share",
    "diagnose",
    "diagnose_pictures",
    "match_colours",
    "measure_lights",
    "relens",
    "remove",
    "remove_with_maps",
]

__version__: str

_Path: TypeAlias = str | PathLike[str]
_Progress: TypeAlias = Callable[[float], bool | None]
_Sample = TypeVar("_Sample", np.float32, np.float16)
_Samples: TypeAlias = NDArray[np.float32] | NDArray[np.float16]
_Depth: TypeAlias = float | _Samples | DepthPass
_Photograph: TypeAlias = _Path | _Samples | NDArray[np.uint16]
_Photographs: TypeAlias = _Photograph | Iterable[_Photograph]

@final
class Lens:
    @staticmethod
    def load(path: _Path) -> Lens: ...
    @staticmethod
    def from_json(text: str) -> Lens: ...
    def to_json(self) -> str: ...
    def save(self, path: _Path) -> None: ...
    @staticmethod
    def fit(
        observations: ObservationSet | _Path | Iterable[ObservationSet | _Path],
        *,
        model: Literal["auto", "reduced", "extended", "moments"] = "auto",
        axis: tuple[float, float] | Literal["free"] | None = None,
        use_all: bool = False,
        law_only: bool = False,
        threads: int = 0,
        progress: _Progress | None = None,
    ) -> Lens: ...
    def psf(
        self,
        x: float,
        y: float,
        distance: float | None = None,
        *,
        size: int = 33,
        psf_model: str | None = None,
    ) -> NDArray[np.float32]: ...
    def adjusted(
        self,
        *,
        focus_distance: float | None = None,
        f_number: float | None = None,
        sensor_shift_um: float | None = None,
        focal_length_mm: float | None = None,
        look: Look | None = None,
    ) -> Lens: ...
    @property
    def frame_size(self) -> tuple[int, int]: ...
    @property
    def optical_axis(self) -> tuple[float, float]: ...
    @property
    def channels(self) -> list[str]: ...
    @property
    def kind(self) -> Literal["moments", "pupil"]: ...
    @property
    def depends_on_depth(self) -> bool: ...
    @property
    def squeeze(self) -> float: ...

@final
class ObservationSet:
    def __new__(
        cls,
        frame_size: tuple[int, int],
        channels: Sequence[str],
        observations: Sequence[Observation],
        *,
        axis: tuple[float, float] | None = None,
        pixel_pitch_um: float | None = None,
    ) -> ObservationSet: ...
    @staticmethod
    def load(path: _Path, *, skip_bad: bool = False) -> ObservationSet: ...
    def save(self, path: _Path) -> None: ...
    @property
    def frame_size(self) -> tuple[int, int]: ...
    @property
    def channels(self) -> list[str]: ...
    @property
    def distances(self) -> list[float | None]: ...
    def __len__(self) -> int: ...

@final
class LeftOut:
    @property
    def source(self) -> str: ...
    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...
    @property
    def why(self) -> str: ...
    @property
    def value(self) -> float: ...
    @property
    def limit(self) -> float: ...
    @property
    def quantity(self) -> str: ...

@final
class LightMeasurement:
    @property
    def observations(self) -> ObservationSet: ...
    @property
    def left_out(self) -> list[LeftOut]: ...
    @property
    def hot_pixels(self) -> list[int]: ...
    @property
    def tile_size(self) -> int: ...

@final
class Removal:
    @property
    def image(self) -> NDArray[Any]: ...
    @property
    def confidence(self) -> NDArray[np.float32]: ...
    @property
    def noise_gain(self) -> NDArray[np.float32] | None: ...
    @property
    def noise(self) -> list[float]: ...

@final
class Diagnosis:
    @property
    def verdict(
        self,
    ) -> Literal["no_gap", "explained", "ambiguous", "unexplained", "model_too_simple", "bookkeeping"]: ...
    @property
    def added(self) -> list[str]: ...
    @property
    def corrected(self) -> Lens: ...
    @property
    def estimated(self) -> ObservationSet | None: ...
    @property
    def report(self) -> dict[str, Any]: ...

def apply(
    lens: Lens,
    image: NDArray[_Sample],
    depth: _Depth | None = None,
    *,
    holdout: _Samples | Holdout | None = None,
    mask: _Samples | None = None,
    background: Background | None = None,
    settings: Settings | None = None,
    progress: _Progress | None = None,
) -> NDArray[_Sample]: ...
def remove(
    lens: Lens,
    image: NDArray[_Sample],
    depth: _Depth | None = None,
    *,
    background: Background | None = None,
    settings: Settings | None = None,
    progress: _Progress | None = None,
) -> NDArray[_Sample]: ...
def remove_with_maps(
    lens: Lens,
    image: _Samples,
    depth: _Depth | None = None,
    *,
    background: Background | None = None,
    noise_gain: bool = False,
    settings: Settings | None = None,
    progress: _Progress | None = None,
) -> Removal: ...
def blur_share(
    lens: Lens,
    image: _Samples,
    depth: _Depth | None = None,
    *,
    settings: Settings | None = None,
    progress: _Progress | None = None,
) -> float: ...
def relens(
    from_lens: Lens,
    to_lens: Lens,
    image: NDArray[_Sample],
    depth: _Depth | None = None,
    *,
    settings: Settings | None = None,
    progress: _Progress | None = None,
) -> NDArray[_Sample]: ...
def distance_at(
    lens: Lens, depth: _Samples | DepthPass, x: int, y: int, *, settings: Settings | None = None
) -> float: ...
def circle_of_confusion(
    lens: Lens,
    image: _Samples,
    depth: _Depth | None = None,
    *,
    settings: Settings | None = None,
) -> NDArray[np.float32]: ...
def match_colours(
    lens: Lens,
    image: NDArray[_Sample],
    depth: _Depth | None = None,
    *,
    settings: Settings | None = None,
    progress: _Progress | None = None,
) -> NDArray[_Sample]: ...
def lens_settings(path: _Path, *, metres_per_unit: float | None = None) -> list[dict[str, float]]: ...
def measure_lights(
    photographs: _Photographs,
    *,
    distance: float | Sequence[float | None] | None = None,
    channels: Sequence[str] | None = None,
    axis: tuple[float, float] | None = None,
    dark: _Photographs | None = None,
    flat: _Photographs | None = None,
    cfa: str | None = None,
    black: float | None = None,
    white: float | None = None,
    encoding: Literal["linear", "srgb"] | None = None,
    tile_size: int | None = None,
    min_snr: float | None = None,
    threads: int = 0,
) -> LightMeasurement: ...
def diagnose(
    lens: Lens,
    observations: ObservationSet | _Path,
    *,
    only: Sequence[str] | None = None,
    pairs: bool = True,
    design: ObservationSet | _Path | None = None,
    threads: int = 0,
    progress: _Progress | None = None,
) -> Diagnosis: ...
def diagnose_pictures(
    lens: Lens,
    reference: _Samples,
    observed: _Samples,
    *,
    distance: float | None = None,
    patch: int = 33,
    axis: tuple[float, float] | None = None,
    clip: float | None = None,
    reference_pixels: Literal["points", "areas"] = "points",
    geometry: Literal["undistorted", "distorted"] | None = None,
    only: Sequence[str] | None = None,
    pairs: bool = True,
    design: ObservationSet | _Path | None = None,
    threads: int = 0,
    progress: _Progress | None = None,
) -> Diagnosis: ...
