"""The ways to estimate indirect light, held against each other: which are right, and what is wrong with the rest."""

from __future__ import annotations

import numpy as np
import pytest
from rooms import furnace
from test_estimators import RHO, THREADS, cube_receivers, furnace_base, furnace_world, illuminance
from verdicts import agrees

from lelight.calculation import calculate
from lelight.estimate.batch import estimate_batch
from lelight.estimate.blocks import Effort
from lelight.estimate.effort import bound_for
from lelight.estimate.variants import VARIANTS
from lelight.settings import Settings

BATCHES = 12
TRUE = 1 / (1 - RHO)


def found_by(name):
    """Illuminance (batches, receivers) in the furnace: middle of the floor, edge, corner, nearer the corner, space."""
    world = furnace_world()
    variant = VARIANTS[name]
    effort = Effort(log2_chains=11, log2_direct=6, log2_near=10, bound=bound_for(world.area, 2.0**11))
    batches = [
        estimate_batch(
            world,
            cube_receivers(),
            effort=effort,
            seed=(2, k),
            base=furnace_base() if variant.on_base else None,
            detail=None,
            executor=THREADS,
            variant=variant,
        )
        for k in range(BATCHES)
    ]
    return illuminance(np.array([batch.direct + batch.indirect for batch in batches]))


@pytest.mark.parametrize("name", [name for name, variant in VARIANTS.items() if not variant.bias])
def test_unbiased_variants_give_the_furnace_everywhere(name):
    assert agrees(found_by(name), TRUE, relative_error=0.03)


@pytest.mark.parametrize(("name", "least_share"), [("clamped", 0.9), ("averaged", 0.95)])
def test_clamping_and_averaging_alone_lose_light_in_the_corner(name, least_share):
    """In the open both are near the truth; 1 cm from two walls they are short of it, beyond their noise."""
    light = found_by(name)
    mean, error = light.mean(axis=0), light.std(axis=0, ddof=1) / np.sqrt(BATCHES)
    assert mean[0] == pytest.approx(TRUE, rel=0.05)
    assert mean[2] + 4 * error[2] < least_share * TRUE


def test_raw_local_estimation_is_quiet_in_the_open_and_wild_in_the_corner():
    light = found_by("raw")
    spread = light.std(axis=0, ddof=1) / TRUE
    assert spread[0] < 0.05
    assert spread[2] > 4 * spread[0]
    assert np.median(light[:, 3]) < 0.8 * TRUE


@pytest.mark.parametrize("name", VARIANTS)
def test_every_variant_runs_from_the_scene_file_s_key(name):
    run = calculate(furnace(0.5), Settings(edge=0.5, batches=2, target=0.2, estimator=name))
    assert np.all(np.isfinite(run.field.values.illuminance))
    assert run.field.illuminance.mean() == pytest.approx(2.0, rel=0.4)
