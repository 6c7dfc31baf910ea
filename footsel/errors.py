"""Errors a user can meet. Each says the value that was wrong, what was expected and what to do."""

from collections.abc import Callable, Iterable
from typing import Any


class FootselError(Exception):
    """Base of every error that footsel raises on purpose; the command line prints it in one line and exits with 2.

    Errors come back whole from worker processes: pickling does not go through __init__, whose arguments vary.
    """

    def __reduce__(self) -> tuple[Callable[..., "FootselError"], tuple[Any, ...], dict[str, Any]]:
        return _remade, (type(self), self.args), self.__dict__


class InputError(FootselError):
    """A value, file or option that the user gave cannot be used."""

    def __init__(self, what: str, remedy: str = "") -> None:
        self.what = what
        self.remedy = remedy
        super().__init__(f"{what}; {remedy}" if remedy else what)


class UnknownNameError(InputError):
    """A name that is not in the list of names that exist."""

    def __init__(self, kind: str, name: object, known: Iterable[str]) -> None:
        self.kind = kind
        self.name = name
        self.known = tuple(known)
        super().__init__(f"unknown {kind} {name!r}", f"choose from: {', '.join(self.known)}")


class MapError(InputError):
    """An elevation map that cannot be read or makes no sense."""


class ModelError(InputError):
    """A model file or folder that is missing, foreign, damaged or of another contract."""


class MissingExtraError(FootselError):
    """A feature needs packages that are not installed."""

    def __init__(self, feature: str, extra: str, missing: str) -> None:
        self.extra = extra
        self.missing = missing
        super().__init__(f"{feature} needs the package {missing!r}; run: pip install 'footsel[{extra}]'")


def _remade(error: type[FootselError], args: tuple[Any, ...]) -> FootselError:
    """An error with its message, before it gets its attributes back."""
    return error.__new__(error, *args)
