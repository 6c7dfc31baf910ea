"""Geometry alone: the terrain cost c_m and the distance to the nominal foothold, no kinematics and no collisions."""

from footsel.footholds import CellScores
from footsel.footholds.cost import INFEASIBLE_COST, MAX_FEASIBLE_COST
from footsel.footholds.request import LegRequest
from footsel.oracle.terrain_cost import terrain_costs
from footsel.selectors.base import Selector


class TerrainOnlySelector(Selector):
    """`255 c_m + k d_n` over all known cells."""

    def score(self, request: LegRequest) -> CellScores:
        local_map = request.local_map
        cost = terrain_costs(local_map.heights, local_map.resolution) * INFEASIBLE_COST
        return CellScores(cost.clip(max=MAX_FEASIBLE_COST), local_map.known)
