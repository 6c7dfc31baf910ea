"""What every reader does about packages that are missing and files that are damaged."""

from collections.abc import Iterator
from contextlib import contextmanager

from footsel.errors import FootselError, MapError, MissingExtraError


@contextmanager
def decoding(kind: str, package: str = "") -> Iterator[None]:
    """Turn whatever a decoder raises on a damaged file of this `kind` into one MapError.

    package: distribution that the decoder comes from; MissingExtraError if it is not installed.
    """
    try:
        yield
    except (FootselError, MemoryError):
        raise
    except ImportError as error:
        raise MissingExtraError(f"reading a {kind}", "maps", package or str(error.name)) from error
    except Exception as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise  # The disk or its permissions, not the file's content.
        # Decoders of foreign files fail in more ways than they document: struct, zlib, sqlite, yaml, lz4 errors.
        reason = " ".join(str(error).split())[:160] or type(error).__name__
        raise MapError(f"is not a readable {kind} ({reason})", "the file is damaged or of another format") from error
