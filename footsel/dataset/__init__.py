"""Labelled pairs of local map and cost: sampling, parallel generation, storage."""

from footsel.dataset.samples import Samples
from footsel.dataset.store import Dataset, open_dataset

__all__ = ["Dataset", "Samples", "open_dataset"]
