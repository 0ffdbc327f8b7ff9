"""Real lens blur on NumPy arrays.

A ``Lens`` describes the point-spread function (PSF) of a real lens over its field, colour channels and distances. It is
fitted to measured PSFs. ``apply`` blurs an image as the lens does, guided by its depth; ``remove`` removes the blur of the
lens that an image was taken with, ``match_colours`` its colour fringes alone; ``relens`` replaces it by that of another lens; ``measure_lights`` measures PSFs in
photographs; ``diagnose`` finds the effects that a lens lacks against measured PSFs, ``diagnose_pictures`` those against a sharp
picture and one through the lens.

Images are arrays of rows x columns x channels, ``float32`` or ``float16``, scene-linear. Results are bit-identical to those
of the command ``seidel`` on the same samples, whatever the number of threads. Calls release the GIL; Ctrl-C stops them.
"""

from ._errors import (
    Cancelled,
    DepthWarning,
    Error,
    FileError,
    InsufficientData,
    InternalError,
    InvalidInput,
    Unsupported,
)
from ._inputs import Background, DepthPass, Holdout, Observation
from ._seidel import (
    Diagnosis,
    LeftOut,
    Lens,
    LightMeasurement,
    ObservationSet,
    Removal,
    __version__,
    apply,
    blur_share,
    circle_of_confusion,
    diagnose,
    diagnose_pictures,
    distance_at,
    lens_settings,
    match_colours,
    measure_lights,
    relens,
    remove,
    remove_with_maps,
)
from ._settings import Look, Settings

__all__ = [
    "Background",
    "Cancelled",
    "DepthPass",
    "DepthWarning",
    "Diagnosis",
    "Error",
    "FileError",
    "Holdout",
    "InsufficientData",
    "InternalError",
    "InvalidInput",
    "LeftOut",
    "Lens",
    "LightMeasurement",
    "Look",
    "Observation",
    "ObservationSet",
    "Removal",
    "Settings",
    "Unsupported",
    "__version__",
    "apply",
    "blur_share",
    "circle_of_confusion",
    "diagnose",
    "diagnose_pictures",
    "distance_at",
    "lens_settings",
    "match_colours",
    "measure_lights",
    "relens",
    "remove",
    "remove_with_maps",
]
