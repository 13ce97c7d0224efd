"""The plan: only what the scene contains is modelled, and it says why."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from rooms import grey, lamp, lit
from shapes import box

from lelight.plan import make_plan, stored_degree
from lelight.scene import Material


def plan_of(*materials, luminaires=(), method="sh"):
    scene = lit(*[box()] * len(materials), materials=list(materials), luminaires=luminaires)
    return make_plan(scene, method=method)


def decision(plan, name):
    (found,) = [one for one in plan.decisions if one.name == name]
    return found


def test_a_grey_diffuse_scene_pays_for_one_channel_and_one_number_a_node():
    plan = plan_of(
        grey("walls", 0.5), grey("lamp", 0.2, luminance=100.0), luminaires=(lamp((1.0, 1.0, 1.0)),)
    )
    assert (plan.channels, plan.degree) == (1, 0)
    assert np.array_equal(plan.degrees, [0, 0])
    assert decision(plan, "angular detail").value == "none"
    assert decision(plan, "emitters").value == "1 luminous materials, 1 point luminaires"


@pytest.mark.parametrize("quantity", ["diffuse", "specular", "luminance"])
def test_any_coloured_material_makes_three_channels_and_is_named(quantity):
    coloured = replace(grey("accent", 0.5), **{quantity: np.array([0.5, 0.4, 0.4])})
    plan = plan_of(grey("walls", 0.5), coloured)
    assert plan.channels == 3
    assert "accent" in decision(plan, "channels").reason
    assert "walls" not in decision(plan, "channels").reason


def test_a_coloured_luminaire_makes_three_channels_and_is_named():
    warm = replace(lamp((1.0, 1.0, 1.0), name="warm"), intensity=np.array([110.0, 100.0, 60.0]))
    plan = plan_of(grey("walls", 0.5), luminaires=(warm,))
    assert plan.channels == 3
    assert "warm" in decision(plan, "channels").reason


def test_many_coloured_things_are_not_all_listed():
    coloured = [Material(f"m{k}", np.array([0.5, 0.4, 0.3])) for k in range(5)]
    reason = decision(plan_of(*coloured), "channels").reason
    assert "m2" in reason
    assert "m3" not in reason
    assert reason.endswith("and others")


def test_rounding_of_equal_components_is_still_grey():
    nearly = Material("walls", np.array([0.5, 0.5 + 1e-7, 0.5]))
    assert plan_of(nearly).channels == 1
    assert plan_of(replace(nearly, diffuse=np.array([0.5, 0.5 + 1e-5, 0.5]))).channels == 3


@pytest.mark.parametrize(
    ("exponent", "degree"),
    [
        # L = ceil(sqrt(2 n ln 100)); below n = 16 the kink at the lobe's rim asks for the degree of n = 16.
        (1.0, 13),
        (16.0, 13),
        (17.0, math.ceil(math.sqrt(34 * math.log(100)))),
        (64.0, 25),
        (256.0, 49),
        (256.1, 0),
        (1e4, 0),
    ],
)
def test_the_degree_follows_the_exponent_up_to_where_lobes_are_not_stored(exponent, degree):
    material = grey("gloss", 0.3, specular=0.1, exponent=exponent)
    assert stored_degree(material) == degree
    plan = plan_of(grey("walls", 0.5), material)
    assert np.array_equal(plan.degrees, [0, degree])
    assert plan.degree == degree
    told = decision(plan, "gloss of gloss")
    assert (f"degree {degree}" in told.value) == (degree > 0)
    assert f"{exponent:g}" in told.reason


def test_an_exponent_without_specular_reflection_is_not_gloss():
    assert stored_degree(grey("matt", 0.5, exponent=64.0)) == 0


@pytest.mark.parametrize("method", ["sh", "grid"])
def test_the_method_is_kept_and_named(method):
    plan = plan_of(grey("gloss", 0.3, specular=0.1, exponent=20.0), method=method)
    assert plan.method == method
    assert decision(plan, "gloss of gloss").value.endswith(f"method {method}")


def test_every_decision_has_a_reason():
    plan = plan_of(grey("gloss", 0.3, specular=0.1, exponent=20.0), grey("lamp", 0.3, luminance=1.0))
    for one in plan.decisions:
        assert one.name
        assert one.value
        assert one.reason
