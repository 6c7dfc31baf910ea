"""Where the base stands when a pair is sampled: family, course, pose. Everything comes from one random generator."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from footsel.errors import InputError, UnknownNameError
from footsel.footholds.layout import LegLayout
from footsel.footholds.pose import BasePose
from footsel.terrain import ElevationMap
from footsel.terrain.courses import FAMILIES, make_course, training_map

RECIPES = ("paper", "footsel", "four_headings")
#: What the family of samples on the paper's training map is called: that map is composed of many.
COMPOSED = "composed"

#: Families with obstacles that a leg can hit are drawn more often: terrain collisions are rare elsewhere.
FAMILY_WEIGHTS = {"flat": 0.4, "slopes": 0.8, "pillars": 2.0, "stones": 1.5, "rubble": 1.5, "blocks": 1.5}

#: Height of the base above the ground that the feet would stand on, as a share of the standing height: for ANYmal B
#: 0.36 to 0.59 m, from a crouch to where the workspace vanishes.
HEIGHT_SHARE = (0.74, 1.2)

#: The height is drawn as low + (high - low) * u ** 1.5 with u uniform: low bodies, where legs meet the body and each
#: other, come more often than high ones, where nearly every cell is merely out of range. For ANYmal B, self-collision
#: so decides 2.7 % of the known cells and the range 46 %; of a uniform height it was 2.2 % and 51 %.
HEIGHT_POWER = 1.5


@dataclass(frozen=True)
class SamplingRecipe:
    """How poses are drawn.

    map_seed: of the one composed training map that all samples lie on, as in the paper; None: a course per family.
    quarter_turns: yaw is a multiple of 90 degrees. tilt: roll and pitch lie within this, in [rad].
    holes: share of the local maps that get unknown cells.
    families: names to draw from, or what the composed map is made of.
    """

    map_seed: int | None
    quarter_turns: bool
    tilt: float
    holes: float
    families: tuple[str, ...] = field(default_factory=lambda: tuple(FAMILIES))

    @classmethod
    def of(
        cls, name: str, families: tuple[str, ...] = (), exclude: tuple[str, ...] = (), map_seed: int = 0
    ) -> "SamplingRecipe":
        """The recipe `paper` (section III-A: one map, four yaws, a level base), `footsel` (any yaw, tilt, holes), or
        `four_headings`, which is `footsel` with the paper's yaws: what any yaw is worth shows beside it.

        The paper's map is composed without excluded families; with families chosen, its recipe draws courses of those.
        """
        if name not in RECIPES:
            raise UnknownNameError("recipe", name, RECIPES)
        for family in (*families, *exclude):
            if family not in FAMILIES:
                raise UnknownNameError("terrain family", family, FAMILIES)
        chosen = tuple(family for family in families or FAMILIES if family not in exclude)
        if not chosen:
            raise InputError("no terrain family is left", "exclude fewer families")
        if name == "paper":
            return cls(None if families else map_seed, True, 0.0, 0.0, chosen)
        return cls(None, name == "four_headings", float(np.deg2rad(15.0)), 0.4, chosen)

    def draw_course(self, rng: np.random.Generator) -> tuple[str, int, ElevationMap]:
        """Family, seed and map of a course."""
        if self.map_seed is not None:
            return COMPOSED, self.map_seed, _composed_map(self.map_seed, self.families)
        seed = int(rng.integers(2**31))
        weights = np.array([FAMILY_WEIGHTS.get(family, 1.0) for family in self.families])
        family = self.families[rng.choice(len(self.families), p=weights / weights.sum())]
        return family, seed, make_course(family, seed)

    def draw_pose(self, rng: np.random.Generator, course: ElevationMap, layout: LegLayout) -> BasePose:
        """A base pose at least half a metre inside the course."""
        inside = np.array(course.size) / 2 - 0.5
        x, y = course.position + rng.uniform(-inside, inside)
        yaw = rng.integers(4) * np.pi / 2 if self.quarter_turns else rng.uniform(-np.pi, np.pi)
        roll, pitch = rng.uniform(-1, 1, 2) * self.tilt
        ground = layout.ground_height(course, x, y, yaw)
        low, high = HEIGHT_SHARE
        z = ground + (low + (high - low) * rng.random() ** HEIGHT_POWER) * layout.standing_height
        return BasePose(float(x), float(y), float(z), float(roll), float(pitch), float(yaw))


@lru_cache(maxsize=1)
def _composed_map(seed: int, families: tuple[str, ...]) -> ElevationMap:
    return training_map(seed, families=families)
