"""The map itself: it follows the robot, grows uncertain with its motion and learns from depth images."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.errors import InputError
from footsel.mapping.camera import CameraModel
from footsel.mapping.capsule import Capsule, without_bodies
from footsel.mapping.cell_readings import CellReadings, read_cells
from footsel.mapping.config import MappingConfig
from footsel.mapping.grid import Grid, moved
from footsel.mapping.motion import attitude_variance, motion_variance
from footsel.mapping.visibility import doubts, seen_through
from footsel.terrain import ElevationMap

Array = NDArray[np.float64]

#: Larger departures of a placement's rotation from a rotation are an error of the caller's.
ROTATION_TOLERANCE = 1e-4


class ElevationMapping:
    """A robot-centric elevation map with uncertainty.

    The map is aligned with W and keeps the robot in its middle. Heights are in W as the robot's pose estimate has it;
    their variances say how well they are known relative to the robot as it stands now. Cells that nothing is known of
    are NaN; holes are never filled.

        mapping = ElevationMapping()
        mapping.move(world_base, pose_covariance)                       # at every pose
        mapping.integrate(depth, camera, world_camera, own_bodies)      # at every image
        mapping.touch(soles, variance)                                  # where feet stand
        mapping.elevation_map()
    """

    def __init__(self, config: MappingConfig | None = None) -> None:
        self.config = config = config or MappingConfig()
        n = config.cells
        self._grid = Grid(n, config.resolution, np.zeros(2, dtype=np.intp))
        self._height = np.full((n, n), np.nan)
        self._variance = np.full((n, n), np.nan)
        # What of the variance came with the robot's motion since the cell was seen.
        self._drift_variance = np.full((n, n), np.nan)
        self._place_variance = np.full((n, n, 2), np.nan)
        # How many more images looked past a cell's top than at it, of late.
        self._doubt = np.zeros((n, n))
        self._base: Array | None = None
        self._covariance = np.zeros((6, 6))

    @property
    def variance(self) -> NDArray[np.float32]:
        """(nx, ny) variance of each cell's height, NaN where it is unknown, in [m^2]."""
        return self._shown(self._variance).astype(np.float32)

    @property
    def horizontal_variance(self) -> NDArray[np.float32]:
        """(nx, ny, 2) variance of each cell's x and y, NaN where it is unknown, in [m^2]."""
        return self._shown(self._place_variance).astype(np.float32)

    def elevation_map(self) -> ElevationMap:
        """The map as known now, in W."""
        return ElevationMap(self._shown(self._height).astype(np.float32), self.config.resolution, self._grid.position)

    def uncertainty(self) -> NDArray[np.float32]:
        """(nx, ny) standard deviation of the terrain's height at each cell's centre, in [m].

        Of the cell's height and, to first order, of its place: where the map is steep, a cell that lies elsewhere has
        another height. NaN where the cell is unknown; beside unknown cells the slope is that to the other side.
        """
        height = self._shown(self._height)
        steps = np.stack([_steepest(height, axis) for axis in (0, 1)], axis=-1) / self.config.resolution
        total = self._shown(self._variance) + (steps**2 * self._place_variance).sum(axis=-1)
        return np.asarray(np.sqrt(total), dtype=np.float32)

    def move(self, world_base: ArrayLike, pose_covariance: ArrayLike | None = None) -> None:
        """The base stands elsewhere: the map follows by whole cells, and all it knows grows less certain.

        world_base: (4, 4) placement of the base in W, in [m]. pose_covariance: (6, 6) of its x, y, z, in [m], and of a
        rotation vector, in [rad], along W's axes; without it, the pose is exact.
        """
        base = _placement("the base", world_base)
        covariance = np.zeros((6, 6)) if pose_covariance is None else _covariance(pose_covariance)
        grid = self._grid.centred_on(base[:2, 3])
        shift = grid.middle - self._grid.middle
        if shift.any():
            self._height = moved(self._height, shift, np.nan)
            self._variance = moved(self._variance, shift, np.nan)
            self._drift_variance = moved(self._drift_variance, shift, np.nan)
            self._place_variance = moved(self._place_variance, shift, np.nan)
            self._doubt = moved(self._doubt, shift, 0.0)
        self._grid = grid
        if self._base is not None:
            growth = motion_variance(self._base, self._covariance, base, covariance)
            self._variance += growth.height
            self._drift_variance += growth.height
            if growth.x or growth.y or growth.yaw:
                everywhere = np.arange(self.config.cells**2)
                places = growth.of_places(grid.centres(everywhere))
                self._place_variance += places.reshape(self._place_variance.shape)
            self._hold_variances()
        self._base, self._covariance = base, covariance

    def integrate(
        self, depth: ArrayLike, camera: CameraModel, world_camera: ArrayLike, own_bodies: Sequence[Capsule] = ()
    ) -> None:
        """Learn from a depth image.

        depth: (height, width) along the optical axis, in [m]; 0, NaN or out of the camera's range is no reading.
        world_camera: (4, 4) placement of the camera's frame in W (x right in the image, y down, z along the axis).
        own_bodies: parts of the robot, in W, which are no terrain.

        Raises InputError for another shape, or what is no placement.
        """
        placement = _placement("the camera", world_camera)
        image = camera.readings(depth)
        if own_bodies:
            bodies = [body.seen_from(placement, self.config.body_margin) for body in own_bodies]
            image = without_bodies(image, camera, bodies)
        if not image.any():
            return
        doubted = np.where(self._hidden, self._height, np.nan).reshape(-1)
        readings = read_cells(image, camera, placement, self._grid, self.config, doubted)
        if self._base is not None:
            noise = attitude_variance(self._grid.centres(readings.cells), self._base, self._covariance)
            readings = replace(readings, variance=readings.variance + noise, lasting=noise)
        self._forget_what_is_seen_through(image, camera, placement, readings)
        lower = readings.cells[self._lower(readings)]
        self._fuse(readings)
        self._vote(image, camera, placement, lower)
        self._hold_variances()

    def touch(self, points: ArrayLike, variance: float) -> None:
        """The robot stands on the ground at points: what has drifted away from them comes back.

        points: (k, 3) in W, in [m]; where nothing is known, or ground of another height, they tell nothing.
        variance: of their heights, in [m^2].

        The pose drifts as the robot goes on, and heights stay as they were seen. Two cells have in common what the pose
        has drifted since the later of them was seen: the lesser of their variances of drift. So one point corrects all
        cells, as a Kalman filter with that covariance does: those seen as long ago as the one under it by as much, and
        those just seen not at all.
        """
        places = np.asarray(points, dtype=np.float64)
        if places.ndim != 2 or places.shape[1] != 3 or not np.isfinite(places).all():
            raise InputError(f"points of shape {places.shape}", "expected finite points (k, 3), in metres")
        if not 0 < variance < np.inf:
            raise InputError(f"a variance of {variance} m^2", "expected a finite number above 0")
        index = np.floor((places[:, :2] - self._grid.corner) / self._grid.resolution).astype(np.intp)
        on_map = ((index >= 0) & (index < self._grid.cells)).all(axis=1)
        for (i, j), height in zip(index[on_map], places[on_map, 2], strict=True):
            error, total = height - self._height[i, j], self._variance[i, j] + variance
            if not self._hidden[i, j] and error**2 <= self.config.gate**2 * total:
                shared = np.minimum(self._drift_variance, self._drift_variance[i, j])
                self._height += shared / total * error
                self._variance -= shared**2 / total
                self._drift_variance -= shared**2 / total
        self._hold_variances()

    def lay_plane(self, points: ArrayLike, margin: float, variance: float) -> None:
        """Fill unknown cells around points that are known to lie on one even piece of ground.

        A robot that begins on flat ground stands where no camera looks; its feet tell how high the ground is.
        points: (k >= 3, 3) in W, in [m]. margin: how far the ground goes on beyond the points' x and y, in [m].
        variance: of its height, in [m^2].
        """
        places = np.asarray(points, dtype=np.float64)
        if places.ndim != 2 or places.shape[1] != 3 or len(places) < 3 or not np.isfinite(places).all():
            raise InputError(
                f"points of shape {places.shape}", "expected three or more finite points (k, 3), in metres"
            )
        if not (np.isfinite(margin) and 0 < variance < np.inf):
            raise InputError(
                f"margin {margin} m and variance {variance} m^2", "expected finite numbers, a variance above 0"
            )
        low, high = places[:, :2].min(axis=0) - margin, places[:, :2].max(axis=0) + margin
        centres = self._grid.centres(np.arange(self.config.cells**2))
        patch = ((centres >= low) & (centres <= high)).all(axis=1) & np.isnan(self._shown(self._height)).reshape(-1)
        middle = places.mean(axis=0)
        slope, *_ = np.linalg.lstsq(places[:, :2] - middle[:2], places[:, 2] - middle[2], rcond=None)
        cells = np.flatnonzero(patch)
        heights = middle[2] + (centres[cells] - middle[:2]) @ slope
        self._height.reshape(-1)[cells] = np.nan
        self._fuse(CellReadings(cells, heights, np.full(len(cells), variance), np.zeros(len(cells))))
        self._hold_variances()

    def _forget_what_is_seen_through(
        self, image: NDArray[np.float32], camera: CameraModel, world_camera: Array, readings: CellReadings
    ) -> None:
        """Remove the cells that the image looks through, unless it shows them where they are as well."""
        height, variance = self._height.reshape(-1), self._variance.reshape(-1)
        suspects = ~np.isnan(height)
        suspects[readings.cells[self._agree(readings)]] = False
        cells = np.flatnonzero(suspects)
        lowest = height[cells] - self.config.sight * np.sqrt(variance[cells])
        points = np.column_stack([self._grid.centres(cells), lowest])
        gone = cells[seen_through(image, camera, world_camera, points, self.config.sight)]
        height[gone] = variance[gone] = np.nan
        self._drift_variance.reshape(-1)[gone] = np.nan
        self._place_variance.reshape(-1, 2)[gone] = np.nan

    def _vote(
        self, image: NDArray[np.float32], camera: CameraModel, world_camera: Array, lower: NDArray[np.intp]
    ) -> None:
        """Let the image say of each cell whether its top is there; no more votes are kept than the config says.

        lower: cells in which it shows lower ground than the map has, which no camera would see if its top were there.
        """
        height, doubt = self._height.reshape(-1), self._doubt.reshape(-1)
        cells = np.flatnonzero(~np.isnan(height))
        points = np.column_stack([self._grid.centres(cells), height[cells]])
        votes = np.zeros_like(height)
        votes[cells] = doubts(image, camera, world_camera, points, self._variance.reshape(-1)[cells], self.config.sight)
        votes[lower] = 1.0
        np.clip(doubt + votes, -self.config.votes, self.config.votes, out=doubt)

    @property
    def _hidden(self) -> NDArray[np.bool_]:
        """(n, n) which cells have had enough images against them."""
        return self._doubt > self.config.doubt

    def _shown(self, layer: Array) -> Array:
        """A layer (n, n, ...) without what is hidden."""
        hidden = self._hidden.reshape(self._doubt.shape + (1,) * (layer.ndim - 2))
        return np.where(hidden, np.nan, layer)

    def _agree(self, readings: CellReadings) -> NDArray[np.bool_]:
        """(m,) which readings may be of what the map has there."""
        height, variance = self._height.reshape(-1)[readings.cells], self._variance.reshape(-1)[readings.cells]
        squares = (readings.height - height) ** 2
        return np.asarray(squares <= self.config.gate**2 * (variance + readings.variance))

    def _lower(self, readings: CellReadings) -> NDArray[np.bool_]:
        """(m,) which readings are of lower ground than the map shows there."""
        cells = readings.cells
        below = readings.height < self._height.reshape(-1)[cells]
        return np.asarray(below & ~self._agree(readings) & ~self._hidden.reshape(-1)[cells])

    def _fuse(self, readings: CellReadings) -> None:
        """One step of a Kalman filter in each cell that knows something.

        New cells take the reading as it is, and so do hidden ones that it contradicts.

        The attitude errs for longer than from image to image, so many images do not average its errors away: no cell
        becomes surer by a reading than those leave it.
        """
        height, variance = self._height.reshape(-1), self._variance.reshape(-1)
        drift_variance = self._drift_variance.reshape(-1)
        cells = readings.cells
        agree, doubt = self._agree(readings), self._doubt.reshape(-1)
        new = np.isnan(height[cells]) | (~agree & self._hidden.reshape(-1)[cells])
        doubt[cells[new]] = 0.0
        height[cells[new]], variance[cells[new]] = readings.height[new], readings.variance[new]
        drift_variance[cells[new]] = 0.0

        both = cells[agree]
        prior, other = variance[both], readings.variance[agree]
        height[both] = (prior * readings.height[agree] + other * height[both]) / (prior + other)
        drift_variance[both] *= (other / (prior + other)) ** 2
        fused = prior * other / (prior + other)
        variance[both] = np.minimum(prior, np.maximum(fused, readings.lasting[agree]))

        variance[cells[~new & ~agree]] += self.config.multi_height_variance
        self._place_variance.reshape(-1, 2)[cells[new | agree]] = self.config.horizontal_variance[0]

    def _hold_variances(self) -> None:
        np.clip(self._variance, *self.config.variance, out=self._variance)
        np.clip(self._place_variance, *self.config.horizontal_variance, out=self._place_variance)


def _steepest(height: Array, axis: int) -> Array:
    """(n, n) the larger of the steps to a cell's two neighbours along an axis, where they are known, in [m]."""
    step = np.abs(np.diff(height, axis=axis))
    none = np.full_like(np.take(step, [0], axis=axis), np.nan)
    sides = np.concatenate([none, step], axis=axis), np.concatenate([step, none], axis=axis)
    return np.asarray(np.fmax(np.fmax(*sides), 0.0))


def _placement(what: str, matrix: ArrayLike) -> Array:
    """(4, 4) a checked placement."""
    placement = np.asarray(matrix, dtype=np.float64)
    if placement.shape != (4, 4) or not np.isfinite(placement).all():
        raise InputError(f"a placement of {what} of shape {placement.shape}", "expected a finite (4, 4) matrix")
    turn = placement[:3, :3]
    if np.abs(turn @ turn.T - np.eye(3)).max() > ROTATION_TOLERANCE or np.linalg.det(turn) < 0:
        raise InputError(f"the placement of {what} does not rotate", "expected an orthonormal right-handed matrix")
    return placement


def _covariance(matrix: ArrayLike) -> Array:
    covariance = np.asarray(matrix, dtype=np.float64)
    if covariance.shape != (6, 6) or not np.isfinite(covariance).all() or (np.diag(covariance) < 0).any():
        raise InputError(
            f"a pose covariance of shape {covariance.shape}", "expected a finite (6, 6) matrix, its diagonal from 0"
        )
    return covariance
