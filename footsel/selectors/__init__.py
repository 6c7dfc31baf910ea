"""One interface, many selectors: nominal, terrain_only, scorers from the literature, oracle, cnn, cnn+verify."""

from footsel.selectors.base import Selector
from footsel.selectors.registry import SELECTORS, make_selector

__all__ = ["SELECTORS", "Selector", "make_selector"]
