"""What a dataset is made of. With the versions of the software it fixes every byte."""

from collections.abc import Iterator
from dataclasses import dataclass

from footsel.dataset.sampling import SamplingRecipe
from footsel.errors import InputError
from footsel.legs import check_pair
from footsel.robot import read_description


@dataclass(frozen=True)
class DatasetConfig:
    """How many local maps, of which legs and on what terrain.

    maps: local maps per pair of legs. families, exclude: terrain families to draw from (default all) and to leave out.
    maps_per_shard: in one file. maps_per_course: local maps that lie on the same course, one after the other.

    Raises InputError for a name or a number that makes no dataset.
    """

    robot: str
    pairs: tuple[str, ...]
    maps: int
    seed: int
    recipe: str
    families: tuple[str, ...] = ()
    exclude: tuple[str, ...] = ()
    maps_per_shard: int = 250
    maps_per_course: int = 10

    def __post_init__(self) -> None:
        for name in ("maps", "maps_per_shard", "maps_per_course"):
            if getattr(self, name) < 1:
                raise InputError(f"{name} is {getattr(self, name)}", "give 1 or more")
        if not self.pairs:
            raise InputError("no pair of legs is given", "name at least one")
        for pair in self.pairs:
            check_pair(pair)
        read_description(self.robot)
        self.sampling()

    @property
    def shards(self) -> int:
        """Number of shards per pair of legs."""
        return -(-self.maps // self.maps_per_shard)

    def shard_keys(self) -> Iterator[tuple[str, int]]:
        """(pair, number) of every shard, in the manifest's order."""
        return ((pair, number) for pair in self.pairs for number in range(self.shards))

    def maps_in(self, number: int) -> int:
        """Local maps in a shard: the last one may be smaller."""
        return min(self.maps_per_shard, self.maps - number * self.maps_per_shard)

    def sampling(self) -> SamplingRecipe:
        """Where and how the base stands."""
        return SamplingRecipe.of(self.recipe, self.families, self.exclude, map_seed=self.seed)
