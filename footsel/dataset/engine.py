"""Where the jobs run: processes of this machine, or the workers of a Dask cluster, both through joblib."""

import logging
import os
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, CancelledError
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from joblib import parallel_config

from footsel.dataset.orphans import leave_with
from footsel.errors import FootselError, InputError, MissingExtraError

#: How long to wait for a scheduler, and for its first worker, in [s].
PATIENCE = 10

_CLIENT_LIBRARIES = ("asyncio", "distributed", "tornado")


class WorkersLostError(FootselError):
    """The processes that did the work are gone; what they had finished is kept."""

    def __init__(self, what: str, remedy: str) -> None:
        self.what = what
        self.remedy = remedy
        super().__init__(f"{what}; {remedy}")


@contextmanager
def engine(scheduler: str | None) -> Iterator[str]:
    """Within, joblib's jobs run on the Dask cluster of the scheduler at this address; None: on this machine.

    Yields a few words on where that is. Raises InputError if no cluster answers, WorkersLostError if workers die.
    """
    if scheduler is None:
        try:
            with parallel_config("loky", initializer=leave_with, initargs=(os.getpid(),)):
                yield "here"
        except BrokenExecutor:
            raise WorkersLostError(
                "a worker process was killed, perhaps for want of memory",
                "run the same command again, with fewer --jobs if memory ran out: it goes on from here",
            ) from None
        return
    distributed = _import_distributed()
    with _connect(distributed, scheduler) as client:
        try:
            with parallel_config("dask", client=client):
                yield f"on {len(client.ncores())} Dask workers"
        except (distributed.KilledWorker, distributed.comm.CommClosedError, CancelledError, TimeoutError) as error:
            raise WorkersLostError(
                f"the Dask cluster at {scheduler} lost the work ({type(error).__name__})",
                "see the logs of its workers, then run the same command again: it goes on from here",
            ) from None


def _import_distributed() -> ModuleType:
    try:
        import distributed
    except ModuleNotFoundError as error:
        raise MissingExtraError("--engine dask", "cluster", str(error.name)) from None
    return distributed


@contextmanager
def _connect(distributed: ModuleType, scheduler: str) -> Iterator[Any]:
    """A client of the scheduler that has at least one worker."""
    try:
        # Before the client tries: it would spend minutes on an address that makes no sense.
        distributed.comm.resolve_address(scheduler)
        client = distributed.Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(
            f"no Dask scheduler answers at {scheduler} ({reason})",
            "start one with `dask scheduler` and give the address that it prints",
        ) from None
    with _quiet(), client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise InputError(
                f"the Dask scheduler at {scheduler} has no workers", f"start some with `dask worker {scheduler}`"
            ) from None
        yield client


@contextmanager
def _quiet() -> Iterator[None]:
    """When a cluster goes down, its client's libraries log tracebacks; the error that we raise says it once."""
    names = [name for name in logging.root.manager.loggerDict if name.split(".")[0] in _CLIENT_LIBRARIES]
    levels = [(logging.getLogger(name), logging.getLogger(name).level) for name in names]
    for logger, _ in levels:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in levels:
            logger.setLevel(level)
