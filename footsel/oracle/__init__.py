"""The exact oracle: five constraints, a file each, the labeler that runs them in sequence, a brute-force reference."""

from footsel.errors import MissingExtraError

try:
    from footsel.oracle.labeler import Label, Oracle
except ImportError as error:
    raise MissingExtraError("the oracle", "oracle", error.name or "coal") from None

__all__ = ["Label", "Oracle"]
