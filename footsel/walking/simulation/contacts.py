"""Which parts of the robot touch the ground, and how hard."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Point = Sequence[float]

#: A contact this far from the foot's surface still counts as the foot's. [m]
FOOT_MARGIN = 0.008
#: The lower shank: contacts of the shank up to this distance from the foot's centre, half of its length. [m]
LOWER_SHANK = 0.157
UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts of one physics step, all forces on the robot in W, in [N].

    foot_forces: (4, 3) by LEGS. foot_normals: per leg the ground's normal at its foot's contact, up without one.
    shank_forces: per leg the sum of the normal forces on its shank beside the foot.
    others: names of the parts touched that are neither feet nor lower shanks.
    """

    foot_forces: NDArray[np.float64]
    foot_normals: tuple[Point, ...] = (UP,) * 4
    shank_forces: tuple[float, ...] = (0.0,) * 4
    others: tuple[str, ...] = ()


def sort_contacts(
    points: Iterable[Any],
    shank_links: Sequence[int],
    link_names: Sequence[str],
    feet: Callable[[], Sequence[Point]],
    foot_radius: float,
) -> Contacts:
    """Tell feet from shanks and the rest.

    points: of pybullet.getContactPoints(robot, ground). shank_links: link index of each leg's shank, by LEGS.
    link_names: by link index, the base's last. feet: gives the foot centres, asked only if needed, in [m].
    """
    forces, normals, shanks = [[0.0, 0.0, 0.0] for _ in range(4)], [UP] * 4, [0.0] * 4
    others: dict[str, None] = {}
    centres: Sequence[Point] | None = None
    for point in points:
        link, force = point[3], point[9]
        if force <= 0 and point[8] > 0:
            continue
        if link not in shank_links:
            others[link_names[link]] = None
            continue
        leg = shank_links.index(link)
        centres = centres or feet()
        x, y, z = point[5]
        cx, cy, cz = centres[leg]
        distance = ((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) ** 0.5
        if distance <= foot_radius + FOOT_MARGIN:
            normals[leg] = point[7]
            for axis in range(3):
                forces[leg][axis] += force * point[7][axis] + point[10] * point[11][axis] + point[12] * point[13][axis]
            continue
        shanks[leg] += force
        if distance > LOWER_SHANK:
            others[link_names[link]] = None
    return Contacts(np.array(forces), tuple(normals), tuple(shanks), tuple(others))
