"""Where the legs of a robot sit: all that choosing a foothold needs to know of a robot, numpy only.

A robot description makes it from the URDF; an exported model carries it in its metadata.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.errors import InputError
from footsel.footholds.pose import BasePose, heading_rotation
from footsel.legs import LEGS
from footsel.terrain import CELLS, ElevationMap, LocalMap, extract_local_map


@dataclass(frozen=True, eq=False)
class LegLayout:
    """Hip points, nominal feet and the scale of the local map.

    hips: leg -> (3,) hip point L_i in the base frame, in [m].
    nominal_feet: leg -> (3,) contact point of the nominal stance in the base frame of a level base, in [m].
    resolution: side of a local map's cell, in [m].
    height_range: depth below L_i that the image's full scale stands for, in [m].
    foot_radius: the foot sphere's centre is this far above the contact point, in [m].
    """

    hips: Mapping[str, NDArray[np.float64]]
    nominal_feet: Mapping[str, NDArray[np.float64]]
    resolution: float
    height_range: float
    foot_radius: float

    @property
    def standing_height(self) -> float:
        """Height of a level base above the ground in the nominal stance, in [m]."""
        return -float(np.mean([foot[2] for foot in self.nominal_feet.values()]))

    def hip_position(self, leg: str, pose: BasePose) -> NDArray[np.float64]:
        """(3,) L_i in the world frame, in [m]."""
        return pose.position + pose.rotation() @ self.hips[leg]

    def nominal_xy(self, leg: str, pose: BasePose) -> NDArray[np.float64]:
        """(2,) N_i: the nominal stance's foot turned by the yaw, world xy in [m]."""
        return pose.position[:2] + (heading_rotation(pose.yaw) @ self.nominal_feet[leg])[:2]

    def nominal_position(
        self, leg: str, pose: BasePose, elevation_map: ElevationMap, xy: NDArray[np.float64]
    ) -> tuple[float, float, float]:
        """N_i at `xy` on the terrain, or on the ground of the standing base where terrain is unknown, in [m]."""
        ground = float(elevation_map.sample(xy))
        z = pose.z + float(self.nominal_feet[leg][2]) if np.isnan(ground) else ground
        return float(xy[0]), float(xy[1]), z

    def local_map(self, elevation_map: ElevationMap, pose: BasePose, leg: str) -> LocalMap:
        """The leg's local map at this base pose."""
        return extract_local_map(elevation_map, self.hip_position(leg, pose), pose.yaw, self.resolution, CELLS)

    def check_on_map(self, elevation_map: ElevationMap, pose: BasePose) -> None:
        """Raise InputError if the base stands off the map."""
        if not elevation_map.contains(pose.position[:2]):
            x, y = elevation_map.position
            half_x, half_y = np.array(elevation_map.size) / 2
            raise InputError(
                f"the base at x={pose.x:g} y={pose.y:g} is off the map",
                f"the map spans x {x - half_x:g}..{x + half_x:g} and y {y - half_y:g}..{y + half_y:g} m",
            )

    def ground_height(self, elevation_map: ElevationMap, x: float, y: float, yaw: float) -> float:
        """Median known height under the rectangle of the nominal feet, in [m]; NaN if nothing there is known."""
        feet = np.array([self.nominal_feet[leg][:2] for leg in LEGS])
        low, high = feet.min(axis=0), feet.max(axis=0)
        step = min(self.resolution, elevation_map.resolution)
        axes = [np.arange(a, b + step / 2, step) for a, b in zip(low, high, strict=True)]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        heights = elevation_map.sample(np.array([x, y]) + grid @ heading_rotation(yaw)[:2, :2].T)
        known = heights[~np.isnan(heights)]
        return float(np.median(known)) if known.size else float("nan")

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON values; `from_dict` is its inverse."""
        return {
            "hips": {leg: [float(v) for v in self.hips[leg]] for leg in LEGS},
            "nominal_feet": {leg: [float(v) for v in self.nominal_feet[leg]] for leg in LEGS},
            "resolution": self.resolution,
            "height_range": self.height_range,
            "foot_radius": self.foot_radius,
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "LegLayout":
        """From the JSON values of `to_dict`."""
        return cls(
            hips={leg: np.array(values["hips"][leg], dtype=np.float64) for leg in LEGS},
            nominal_feet={leg: np.array(values["nominal_feet"][leg], dtype=np.float64) for leg in LEGS},
            resolution=float(values["resolution"]),
            height_range=float(values["height_range"]),
            foot_radius=float(values["foot_radius"]),
        )
