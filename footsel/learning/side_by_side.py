"""Trainings of several pairs at once, each a process of its own: two networks cost no more time than one."""

import multiprocessing
import os
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection, wait
from typing import Any, Protocol

from tqdm import tqdm

from footsel.errors import FootselError, InputError


class TrainPair(Protocol):
    """One training; can be pickled. bar_line: of its progress bar. Returns the header of its model."""

    def __call__(self, pair: str, /, *, bar_line: int | None = None) -> dict[str, Any]: ...


def in_turn(train_pair: TrainPair, pairs: Sequence[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    """(pair, header), one after the other in this process."""
    for pair in pairs:
        yield pair, train_pair(pair)


def side_by_side(train_pair: TrainPair, pairs: Sequence[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    """(pair, header) as the trainings end.

    The first error of one ends the others, which can be resumed; so does the end of this process, by whatever means.
    Raises InputError with the text of that error.
    """
    # A fresh interpreter for each: torch's threads do not survive a fork.
    context = multiprocessing.get_context("spawn")
    lock = context.RLock()
    running, workers = {}, []
    for line, pair in enumerate(pairs):
        ours, theirs = context.Pipe(duplex=False)
        worker = context.Process(target=_work, args=(train_pair, pair, line, theirs, lock, os.getpid()), daemon=True)
        worker.start()
        theirs.close()
        running[ours] = pair, worker
        workers.append(worker)
    try:
        while running:
            for end in wait(list(running)):
                assert isinstance(end, Connection)
                pair, worker = running.pop(end)
                try:
                    info, error = end.recv()
                except EOFError:
                    worker.join()
                    raise InputError(f"the training of {pair} ended with code {worker.exitcode}", "resume it") from None
                if error:
                    raise InputError(error)
                yield pair, info
    finally:
        for worker in workers:
            worker.terminate()
            worker.join()


def _work(
    train_pair: TrainPair,
    pair: str,
    line: int,
    end: Connection,
    lock: Any,
    parent: int,
) -> None:
    from footsel.dataset.orphans import leave_with

    leave_with(parent)
    tqdm.set_lock(lock)  # The progress bars share one terminal.
    try:
        end.send((train_pair(pair, bar_line=line), ""))
    except FootselError as error:
        end.send((None, str(error)))
