"""A walk that knows the ground from images alone."""

import dataclasses

import numpy as np

from footsel.selectors import make_selector
from footsel.terrain import ElevationMap
from footsel.walking.courses.registry import make_walk_course
from footsel.walking.ground import make_ground
from footsel.walking.map_source import MapSource
from footsel.walking.observer import WalkObserver
from footsel.walking.sensing import camera_sight
from footsel.walking.walk import walk

#: Behind here the ground is changed; no foot comes so far in the time of the test. [m], [s]
FROM, SECONDS = 1.0, 5.0


class Choices(WalkObserver):
    """Keeps what the selector was told, and its answers."""

    def __init__(self):
        self.answers, self.maps = [], []

    def see(self, moment):
        """Nothing to keep."""

    def see_choice(self, moment):
        choice = moment.choice
        self.answers.append((choice.time, choice.leg, choice.pose.as_list(), choice.foothold.to_dict()))
        self.maps.append(choice.elevation_map.elevation)


class Remembered(MapSource):
    """A map source that looks no more."""

    def __init__(self, source):
        self._source = source

    def update(self, time, base, joints):
        """Eyes closed."""

    def elevation_map(self):
        return self._source.elevation_map()


def choices(swapped, eyes_open=False):
    """Of a walk over stairs; once it has mapped them, other ground may take their place."""
    course = make_walk_course("stairs", 0)
    course = dataclasses.replace(
        course, ground=ElevationMap(course.ground.elevation.copy(), 0.02, course.ground.position)
    )
    make, drift = camera_sight(0)

    def source(simulation):
        seen, ground = make(simulation), course.ground
        if swapped:
            # The last stairs first: the same range of heights, so that physics is the same before them.
            far = ground.x() > FROM
            ground.elevation[far] = ground.elevation[far][::-1]
            course.known.elevation[:] = np.nan
        simulation.client.removeBody(simulation.ground)
        simulation.ground = make_ground(simulation.client, ground.elevation, ground.resolution, ground.position)
        simulation.client.changeDynamics(simulation.ground, -1, lateralFriction=1.0, restitution=0.0)
        return seen if eyes_open else Remembered(seen)

    observer = Choices()
    walk(course, make_selector("cnn"), source, 0, "camera", "cnn", [observer], SECONDS, drift)
    return observer


def test_other_ground_changes_no_choice_that_was_made_from_a_map():
    before, after = choices(swapped=False), choices(swapped=True)
    assert len(before.answers) >= 4
    assert before.answers == after.answers
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(before.maps, after.maps, strict=True))
    # The map reaches over the ground that was changed, and one that goes on looking sees the change.
    looking = choices(swapped=True, eyes_open=True)
    assert not np.array_equal(looking.maps[-1], after.maps[-1], equal_nan=True)
