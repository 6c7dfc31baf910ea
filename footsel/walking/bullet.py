"""PyBullet without what it prints from C: its build time when it is loaded, its arguments when it is connected."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

from footsel.errors import MissingExtraError


@contextmanager
def _closed_stderr() -> Iterator[None]:
    """What is written to the process's stderr, by whatever language, is lost."""
    before, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(before, 2)
        os.close(before)
        os.close(nowhere)


try:
    with _closed_stderr():
        import pybullet
        from pybullet_utils.bullet_client import BulletClient
except ImportError:
    raise MissingExtraError("simulation", "sim", "pybullet") from None


class BulletWorld(BulletClient):  # type: ignore[misc]
    """A world of its own without graphics; PyBullet's functions are its methods."""

    def __init__(self) -> None:
        # As BulletClient does, but for `options`: given any, even none, PyBullet prints them to stdout.
        self._shapes: dict[object, object] = {}
        self._pid = os.getpid()
        self._client = pybullet.connect(pybullet.DIRECT)

    @property
    def id(self) -> int:
        """The world's physicsClientId."""
        return int(self._client)


__all__ = ["BulletWorld", "pybullet"]
