"""Networks, recipes, training and evaluation. Importing this package alone loads neither torch nor a dataset."""

from footsel.learning.recipe import RECIPES, Recipe

__all__ = ["RECIPES", "Recipe"]
