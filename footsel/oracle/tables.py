"""The oracle's tables for one leg, built once per robot model and kept in the user's cache folder."""

import hashlib
import zipfile
from dataclasses import dataclass
from functools import cache

import numpy as np

from footsel.files import cache_folder, replace_file
from footsel.oracle import kinematic_margin, self_collision
from footsel.oracle.kinematic_margin import MarginField
from footsel.oracle.self_collision import SelfCollisionTable
from footsel.robot.robot import Robot

#: Raised when the meaning or the making of a table changes.
TABLE_VERSION = 3


@dataclass(frozen=True, eq=False)
class Tables:
    """What is looked up for one leg."""

    self_collision: SelfCollisionTable
    margin: MarginField


@cache
def load_tables(robot: Robot, leg: str) -> Tables:
    """Read the tables of a leg from the cache folder, or build them there (some 30 s)."""
    path = cache_folder() / f"{robot.name}-{robot.description.limits_name}-{leg}-{_fingerprint(robot)}.npz"
    try:
        with np.load(path, allow_pickle=False) as stored:
            return Tables(
                SelfCollisionTable(stored["answer"], stored["low"], stored["step"]),
                MarginField(stored["distance"].astype(np.float32), stored["origin"]),
            )
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile):
        pass
    table = SelfCollisionTable.build(robot, leg)
    margin = MarginField.build(robot, leg, table)
    # As it will be read again: a tenth of a millimetre is far below the field's own error.
    kept = margin.distance.astype(np.float16)
    path.parent.mkdir(parents=True, exist_ok=True)
    replace_file(
        path,
        lambda temporary: np.savez_compressed(
            temporary, answer=table.answer, low=table.low, step=table.step, distance=kept, origin=margin.origin
        ),
    )
    return Tables(table, MarginField(kept.astype(np.float32), margin.origin))


def _fingerprint(robot: Robot) -> str:
    """Changes with the robot model, the way tables are made and the collision library."""
    import coal

    parts = (
        TABLE_VERSION,
        self_collision.NODE_STEP,
        kinematic_margin.VOXEL,
        coal.__version__,
        robot.description.limits,
        robot.description.stance,
        robot.description.joints,
    )
    digest = hashlib.sha256(repr(parts).encode())
    digest.update(robot.description.urdf_path.read_bytes())
    return digest.hexdigest()[:16]
