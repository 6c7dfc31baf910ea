"""Many walks side by side. What comes of a walk depends on its job alone, not on how many ran or where."""

import sys
import threading
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

import joblib
from tqdm import tqdm

from footsel.dataset.engine import engine
from footsel.errors import InputError
from footsel.selectors import Selector, make_selector
from footsel.walking.result import WalkResult
from footsel.walking.runs.job import WalkJob
from footsel.walking.runs.kept import held_folder, keep, kept, versions
from footsel.walking.runs.trace import Trace

#: A worker of a cluster may have several threads; selectors and their scratch memory are for one.
_ONE_AT_A_TIME = threading.Lock()

#: What a worker hands back: number of the job, what came of it, and the software that walked.
Walked = tuple[int, WalkResult, Trace, dict[str, str]]


def walk_all(
    walks: Sequence[WalkJob], out: Path, jobs: int = -1, scheduler: str | None = None
) -> list[tuple[WalkResult, Trace]]:
    """What came of every walk, in their order; those that folder `out` keeps from an earlier command are not repeated.

    walks: all of one robot and kind of map. jobs: processes on this machine, -1 for one per core.
    scheduler: address of a Dask scheduler whose workers walk in their place.

    Raises InputError if the folder holds something else, WorkersLostError if workers die.
    """
    if not walks:
        raise InputError("there is no walk to make", "give at least one terrain, selector and seed")
    with engine(scheduler) as place, held_folder(out, walks[0].robot, walks[0].map):
        found = {number: each for number, walk in enumerate(walks) if (each := kept(out, walk)) is not None}
        if found:
            print(f"{out} has {len(found)} of {len(walks)} walks; going on with the others {place}", file=sys.stderr)
        missing = [number for number in range(len(walks)) if number not in found]
        with tqdm(
            total=len(walks),
            initial=len(found),
            desc="walks",
            unit="walk",
            # Into a file go a few lines and not a picture that moves.
            mininterval=0.2 if sys.stderr.isatty() else 15,
        ) as progress:
            for number, result, trace, software in _work(walks, missing, jobs):
                _check_versions(software)
                keep(out, walks[number], result, trace)
                found[number] = result, trace
                progress.update()
                reached = sum(result.success for result, _ in found.values())
                progress.set_postfix_str(f"{reached} reached the goal", refresh=False)
    return [found[number] for number in range(len(walks))]


def _work(walks: Sequence[WalkJob], missing: Sequence[int], jobs: int) -> Iterator[Walked]:
    """The missing walks, in the order in which they end."""
    with joblib.Parallel(n_jobs=jobs, return_as="generator_unordered") as parallel:
        # Tables that do not exist yet are built by one worker per selector, and a model that is none shows at once.
        selectors = {walks[number].selector: walks[number] for number in missing}
        for _ in parallel(joblib.delayed(_prepare)(walk) for walk in selectors.values()):
            pass
        yield from parallel(joblib.delayed(_walk)(number, walks[number]) for number in missing)


def _prepare(job: WalkJob) -> None:
    _selector(job.selector, job.robot, job.model)


def _walk(number: int, job: WalkJob) -> Walked:
    # PyBullet is for the workers.
    from footsel.walking.runs.one import run_job
    from footsel.walking.runs.tracer import Tracer

    tracer = Tracer()
    with _ONE_AT_A_TIME:
        result = run_job(job, _selector(job.selector, job.robot, job.model), [tracer])
    return number, result, tracer.trace, versions()


@cache
def _selector(name: str, robot: str, model: Path | None) -> Selector:
    """One per process: a selector keeps nothing between walks."""
    return make_selector(name, robot, model)


def _check_versions(found: dict[str, str]) -> None:
    """Raise InputError if a worker's software is not ours, whose folder this is."""
    others = [
        f"{name} {found.get(name)} and not {ours}" for name, ours in versions().items() if found.get(name) != ours
    ]
    if others:
        raise InputError(f"a worker has {', '.join(others)}", "install the same on all machines")
