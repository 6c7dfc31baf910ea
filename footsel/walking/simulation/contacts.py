"""Which parts of the robot touch the ground, and how hard."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: A contact this far from the foot's surface still counts as the foot's. [m]
FOOT_MARGIN = 0.008
#: The lower shank: contacts of the shank up to this distance from the foot's centre, half of its length. [m]
LOWER_SHANK = 0.157


@dataclass(eq=False)
class Contacts:
    """Contacts of one physics step, all forces on the robot in W, in [N].

    foot_forces, foot_normals: (4, 3) by LEGS; normals of the ground at the last contact point. shank_forces: (4,) sum of the normal forces on each shank beside the foot.
    others: names of the parts touched that are neither feet nor lower shanks.
    """

    foot_forces: NDArray[np.float64] = field(default_factory=lambda: np.zeros((4, 3)))
    foot_normals: NDArray[np.float64] = field(default_factory=lambda: np.tile([0.0, 0.0, 1.0], (4, 1)))
    shank_forces: NDArray[np.float64] = field(default_factory=lambda: np.zeros(4))
    others: tuple[str, ...] = ()


def sort_contacts(
    points: Iterable[Any], shank_links: Sequence[int], link_names: Sequence[str], feet: Any, foot_radius: float
) -> Contacts:
    """Tell feet from shanks and the rest.

    points: of pybullet.getContactPoints(robot, ground). shank_links: link index of each leg's shank, by LEGS.
    link_names: by link index, the base's last. feet: () -> (4, 3) foot centres, asked only if needed, in [m].
    """
    contacts = Contacts()
    centres = None
    others: list[str] = []
    for point in points:
        force = point[9]
        if force <= 0 and point[8] > 0:
            continue
        link = point[3]
        if link not in shank_links:
            others.append(link_names[link])
            continue
        leg = shank_links.index(link)
        if centres is None:
            centres = feet()
        dx, dy, dz = (point[5][axis] - centres[leg][axis] for axis in range(3))
        distance = (dx * dx + dy * dy + dz * dz) ** 0.5
        if distance <= foot_radius + FOOT_MARGIN:
            normal, first, second = point[7], point[11], point[13]
            contacts.foot_normals[leg] = normal
            for axis in range(3):
                contacts.foot_forces[leg, axis] += (
                    force * normal[axis] + point[10] * first[axis] + point[12] * second[axis]
                )
            continue
        contacts.shank_forces[leg] += force
        if distance > LOWER_SHANK:
            others.append(link_names[link])
    if others:
        contacts.others = tuple(dict.fromkeys(others))
    return contacts
