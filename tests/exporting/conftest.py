"""A run of two untrained networks, whose normalisations are as uneven as after a training, and its export."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import torch
from torch import nn

from footsel.exporting import export_run as export_run_module
from footsel.exporting.export_run import export_run
from footsel.exporting.trial_maps import trial_maps
from footsel.footholds import LegLayout
from footsel.learning.build import build_network
from footsel.learning.checkpoint import save_model
from footsel.learning.network import FootholdNetwork
from footsel.learning.recipe import Recipe
from footsel.learning.skeleton import LegSkeleton
from footsel.robot import load_robot

PARITY_MAPS = 60


def uneven_network(seed: int, layout: LegLayout, recipe: str = "footsel") -> FootholdNetwork:
    """Logits that spread over several units, negative and positive scales in every normalisation."""
    torch.manual_seed(seed)
    network = build_network(used_recipe(recipe), layout, LegSkeleton.of(load_robot("anymal_b"), "LF"))
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            nn.init.uniform_(module.weight, -0.5, 1.5)
            nn.init.normal_(module.bias, 0, 0.5)
            module.running_mean.normal_(0, 0.3)
            module.running_var.uniform_(0.02, 0.5)
    nn.init.normal_(network.get_parameter(network.class_bias.replace("bias", "weight")), 0, 0.4)
    network.eval()
    maps = trial_maps(layout, "LF", 20, seed=seed)
    encoding = used_recipe(recipe).encoding(layout.height_range)
    with torch.no_grad():
        logits = network(torch.from_numpy(encoding.encode(maps.heights, maps.roll, maps.pitch)))
        # Every class is the likeliest somewhere.
        network.get_parameter(network.class_bias).sub_(logits.mean(dim=(0, 2, 3)))
    return network


def used_recipe(name: str) -> Recipe:
    """With a second output, where there can be one."""
    recipe = Recipe.load(name)
    return replace(recipe, reason_weight=0.3) if recipe.architecture == "footnet" else recipe


def write_run(
    run: Path, layout: LegLayout, recipe: str = "footsel", **changes: object
) -> Mapping[str, FootholdNetwork]:
    """The files of `footsel train` that an export reads."""
    networks = {}
    for seed, pair in enumerate(("front", "hind")):
        used = used_recipe(recipe)
        network = networks[pair] = uneven_network(seed, layout, recipe)
        info: dict[str, Any] = {
            "robot": "anymal_b",
            "pair": pair,
            "layout": layout.to_dict(),
            "skeleton": LegSkeleton.of(load_robot("anymal_b"), "LF").to_dict(),
            "recipe": used.to_dict(),
            "encoding": used.encoding(layout.height_range).to_dict(),
            "in_channels": network.in_channels,
            "classes": network.classes,
            "class_shares": [1 / 14] * 14,
            "dataset": {
                "robot": "anymal_b",
                "pairs": ["front", "hind"],
                "maps": 1000,
                "seed": 7,
                "recipe": "footsel",
                "families": [],
                "exclude": ["pillars", "gaps"],
            },
            "dataset_sha256": "ab" * 32,
            "maps": {"training": 900, "validation": 100},
            "seed": seed,
            "epochs_done": 1,
            "feasible_below": 0.1,
            "validation": {"maps": 100, "cells": {"accuracy": 0.875, "cost_mae": None}, "picks": {"missed": 3}},
            "version": "0.1.0",
        }
        folder = run / pair
        folder.mkdir(parents=True)
        save_model(folder, network.state_dict(), {**info, **changes})
    return networks


@pytest.fixture(scope="session")
def makers() -> SimpleNamespace:
    return SimpleNamespace(uneven_network=uneven_network, write_run=write_run)


@pytest.fixture(scope="session")
def released(tmp_path_factory: pytest.TempPathFactory, anymal_layout: LegLayout) -> SimpleNamespace:
    """run: the folder of the training. out: its export, both variants. networks: pair -> network in torch."""
    root = tmp_path_factory.mktemp("export")
    networks = write_run(root / "run", anymal_layout)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(export_run_module, "CALIBRATION_MAPS", 60)
        out = export_run(root / "run", root / "out", int8=True, parity_maps=PARITY_MAPS)
    return SimpleNamespace(run=root / "run", out=out, networks=networks)
