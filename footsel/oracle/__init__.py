"""The exact oracle: five constraints, one file each, the labeler that runs them in sequence, and its brute-force reference."""

from footsel.errors import MissingExtraError

try:
    from footsel.oracle.labeler import Label, Oracle
except ImportError as error:
    raise MissingExtraError("the oracle", "oracle", error.name or "coal") from None

__all__ = ["Label", "Oracle"]
