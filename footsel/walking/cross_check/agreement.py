"""The oracle's verdict on every collision held against another engine's, and how near to touching they differ."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import Reason
from footsel.footholds.pose import tilt_rotation
from footsel.oracle import Label, Oracle
from footsel.oracle.verification.places import Place, draw_place
from footsel.robot.robot import Robot
from footsel.walking.cross_check.coal_engine import CoalEngine
from footsel.walking.cross_check.engine import Engine

KINDS = ("self", "terrain")

#: Places are drawn until there are enough cells in kinematic range, but no more than so many.
MOST_PLACES = 60

Check = Literal["contacts", "meshes"]


@dataclass
class Disagreement:
    """A cell on which the oracle and the other engine differ.

    where: course and seed or map, leg, base pose and cell. kind: "self" or "terrain". oracle: whether it sees contact.
    bodies: what met for the engine that saw contact, or what was nearest to it. distance: how far the answers are from
    the border between contact and none, in [m]; inf if further than was looked.
    details: how the distance was measured, in [m].
    """

    where: str
    kind: str
    oracle: bool
    bodies: list[str]
    distance: float
    details: dict[str, float]


@dataclass
class Agreement:
    """Counts of cells, kind -> [neither sees contact, the oracle alone, the other alone, both]."""

    counts: dict[str, list[int]] = field(default_factory=lambda: {kind: [0] * 4 for kind in KINDS})
    disagreements: list[Disagreement] = field(default_factory=list)

    @property
    def cells(self) -> int:
        """Cells in kinematic range that were compared."""
        return sum(self.counts["self"])

    @classmethod
    def sum(cls, parts: Iterable["Agreement"]) -> "Agreement":
        """All parts in one."""
        total = cls()
        for part in parts:
            for kind in KINDS:
                total.counts[kind] = [a + b for a, b in zip(total.counts[kind], part.counts[kind], strict=True)]
            total.disagreements = total.disagreements + part.disagreements
        return total

    def figures(self) -> dict[str, Any]:
        """Plain JSON values, without the disagreements themselves."""
        names = ("neither", "oracle_only", "other_only", "both")
        distances = np.array([each.distance for each in self.disagreements])
        return {
            "cells": self.cells,
            **{kind: dict(zip(names, self.counts[kind], strict=True)) for kind in KINDS},
            "disagreements": len(self.disagreements),
            "largest_distance": float(distances.max(initial=0.0)),
        }

    def worst(self, count: int) -> list[dict[str, Any]]:
        """The disagreements furthest from touching."""
        return [asdict(each) for each in sorted(self.disagreements, key=lambda each: -each.distance)[:count]]


def check_source(
    source: str, leg: str, check: Check, cells: int, cells_per_place: int, seed: int = 0, robot_name: str = "anymal_b"
) -> Agreement:
    """Compare on `cells` cells in kinematic range, at random places of one leg on a course family or a map file.

    check: "contacts": the same primitives in PyBullet; "meshes": the full meshes in coal.
    """
    oracle = Oracle.load(robot_name)
    rng = np.random.default_rng([seed, crc32(f"{Path(source).name} {leg}".encode())])
    primitives, other, measure = _engines(oracle.robot, leg, check)
    agreement = Agreement()
    for _ in range(MOST_PLACES):
        place = draw_place(oracle.robot.layout, source, leg, rng)
        label = oracle.label(place.local_map, leg, *place.tilt)
        in_range = rng.permutation(np.argwhere(np.isfinite(label.joint_angles).all(axis=-1)))
        chosen = in_range[: min(cells_per_place, cells - agreement.cells)]
        if len(chosen):
            for engine in (primitives, other):
                engine.stand(place.local_map, tilt_rotation(*place.tilt))
            compare_place(label, place, chosen, other, measure, agreement)
        if agreement.cells >= cells:
            break
    return agreement


#: (kind, angles, whether the oracle sees contact) -> distance, its details, the bodies; see Disagreement.
Measure = Callable[[str, NDArray[np.float64], bool], tuple[float, dict[str, float], list[str]]]


def compare_place(
    label: Label, place: Place, cells: NDArray[np.intp], other: Engine, measure: Measure, into: Agreement
) -> None:
    """Compare both kinds of collision on `cells` (k, 2) in kinematic range of a place's label."""
    for i, j in cells.tolist():
        reason, angles = Reason(int(label.reason[i, j])), label.joint_angles[i, j]
        verdicts = {"self": reason == Reason.SELF_COLLISION}
        if not verdicts["self"]:
            # A leg that hits the robot is not asked about the terrain.
            verdicts["terrain"] = reason == Reason.TERRAIN_COLLISION
        for kind, verdict in verdicts.items():
            found = other.touches(kind, angles)
            into.counts[kind][verdict + 2 * found] += 1
            if verdict != found:
                distance, details, bodies = measure(kind, angles, verdict)
                where = f"{place} --cell {i} {j}"
                into.disagreements.append(Disagreement(where, kind, verdict, bodies, distance, details))


def _engines(robot: Robot, leg: str, check: Check) -> tuple[CoalEngine, Engine, Measure]:
    """The oracle's primitives in coal, the other engine, and how their disagreements are measured."""
    primitives = CoalEngine(robot, leg)
    if check == "contacts":
        from footsel.walking.cross_check.bullet_engine import BulletEngine

        bullet = BulletEngine(robot, leg)

        def shifts(
            kind: str, angles: NDArray[np.float64], oracle_sees: bool
        ) -> tuple[float, dict[str, float], list[str]]:
            """Both engines: how far the leg must be moved until the engine changes its mind."""
            details = {
                "coal_shift": primitives.distance_to_other_answer(kind, angles),
                "pybullet_shift": bullet.distance_to_other_answer(kind, angles),
            }
            return max(details.values()), details, _bodies(primitives if oracle_sees else bullet, kind, angles)

        return primitives, bullet, shifts

    from footsel.walking.cross_check.full_meshes import leg_meshes

    meshes = CoalEngine(robot, leg, leg_meshes(robot, leg))

    def clearance(
        kind: str, angles: NDArray[np.float64], oracle_sees: bool
    ) -> tuple[float, dict[str, float], list[str]]:
        """How far apart the bodies are in the model that sees no contact."""
        seeing, free = (primitives, meshes) if oracle_sees else (meshes, primitives)
        distance, _ = free.clearance(kind, angles)
        return distance, {"clearance": distance}, _bodies(seeing, kind, angles)

    return primitives, meshes, clearance


def _bodies(engine: Engine, kind: str, angles: NDArray[np.float64]) -> list[str]:
    if kind == "self":
        return [f"{swing} against {other}" for swing, other in engine.self_contacts(angles)]
    return [f"{body} against terrain" for body in engine.terrain_contacts(angles)]
