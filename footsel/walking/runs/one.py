"""A job walked, in this process."""

from collections.abc import Sequence

from footsel.selectors import Selector
from footsel.walking.course import WalkCourse
from footsel.walking.maps import make_senses
from footsel.walking.observer import WalkObserver
from footsel.walking.result import WalkResult
from footsel.walking.runs.job import WalkJob
from footsel.walking.walk import walk


def run_job(
    job: WalkJob, selector: Selector, observers: Sequence[WalkObserver] = (), course: WalkCourse | None = None
) -> WalkResult:
    """Walk. course: that of the job, if the caller has it already."""
    course = course or job.course()
    senses = make_senses(job.map, course, job.robot, job.seed)
    return walk(
        course,
        selector,
        senses.map_source,
        job.seed,
        job.map,
        job.selector,
        observers,
        job.time_limit_s,
        senses.estimator,
        job.watch_limbs,
    )
