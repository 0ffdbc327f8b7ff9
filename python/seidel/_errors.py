"""The exceptions of the package."""


class Error(Exception):
    """A failed call. The message has the form ``place: problem; remedy``.

    Attributes:
        kind: class of the error: ``invalid_input``, ``unsupported``, ``insufficient_data``, ``cancelled``, ``file`` or
            ``internal``.
        place: the argument, field or file at fault.
        remedy: what to do about it.
    """

    kind: str = "internal"
    place: str = ""
    remedy: str = ""


class InvalidInput(Error, ValueError):
    """A value, an array or a combination of settings that is not valid."""

    kind = "invalid_input"


class Unsupported(Error, ValueError):
    """A valid request that this lens or this version cannot serve."""

    kind = "unsupported"


class InsufficientData(Error, ValueError):
    """Too few usable observations for the result."""

    kind = "insufficient_data"


class Cancelled(Error):
    """The progress callback stopped the call by returning ``False``."""

    kind = "cancelled"


class FileError(Error, OSError, ValueError):
    """A file that cannot be read or written, or whose contents are not valid. ``place`` is its path."""

    kind = "file"


class DepthWarning(UserWarning):
    """A depth pass that seems to have another meaning than stated, or to be of another image. ``apply`` renders it as stated."""


class InternalError(Error, RuntimeError):
    """An error of Seidel itself."""

    kind = "internal"
