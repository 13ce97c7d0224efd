"""The plan: only what the scene contains is modelled, and it says why."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from rooms import grey, lamp, lit
from shapes import box

from lelight.plan import Forced, make_plan
from lelight.reach import without_dark_lamps
from lelight.scene import Material
from lelight.storeddegree import stored_degree


def plan_of(*materials, luminaires=(), method="sh", reached=None, **forced):
    scene = lit(*[box()] * len(materials), materials=list(materials), luminaires=luminaires)
    reached = None if reached is None else np.array(reached)
    return make_plan(scene, method=method, forced=Forced(**forced), reached=reached)


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
        # L = ceil(sqrt(2 n ln(1 / 0.001))); below n = 16 the kink at the lobe's rim asks for the degree of n = 16.
        (1.0, 15),
        (16.0, 15),
        (17.0, math.ceil(math.sqrt(34 * math.log(1000)))),
        (64.0, 30),
        (256.0, 60),
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


COLOURED = Material("accent", np.array([0.5, 0.4, 0.3]))


def test_colour_that_no_light_reaches_costs_nothing_and_is_named():
    plan = plan_of(grey("walls", 0.5), COLOURED, reached=[True, False])
    assert plan.channels == 1
    assert "accent" in decision(plan, "channels").reason
    assert plan_of(grey("walls", 0.5), COLOURED, reached=[True, True]).channels == 3


def test_a_coloured_lamp_counts_whether_its_own_surface_is_lit_or_not():
    shining = replace(grey("lamp", 0.5), luminance=np.array([100.0, 90.0, 50.0]))
    assert plan_of(grey("walls", 0.5), shining, reached=[True, False]).channels == 3


def test_gloss_that_no_light_reaches_keeps_no_harmonics():
    floor = grey("floor", 0.3, specular=0.1, exponent=64.0)
    plan = plan_of(grey("carpet", 0.3), floor, reached=[True, False])
    assert np.array_equal(plan.degrees, [0, 0])
    assert decision(plan, "gloss of floor").value == "left out"
    assert np.array_equal(plan_of(grey("carpet", 0.3), floor, reached=[True, True]).degrees, [0, 30])


def test_a_hair_above_exponent_1_changes_no_decision():
    plans = [plan_of(grey("gloss", 0.3, specular=0.1, exponent=n)) for n in (1.0, 1.0001)]
    assert plans[0].degree == plans[1].degree == 15
    assert [one.value for one in plans[0].decisions] == [one.value for one in plans[1].decisions]


@pytest.mark.parametrize("lamps", [(), (lamp((1.0, 1.0, 1.0)),)])
def test_what_reflects_nothing_is_left_to_direct_light(lamps):
    plan = plan_of(grey("walls", 0.0, luminance=1.0), luminaires=lamps)
    assert (plan.indirect, plan.residual) == (False, False)
    assert "direct light is all" in decision(plan, "indirect light").reason
    for reflecting in (grey("walls", 1e-3), grey("walls", 0.0, specular=1e-3, exponent=400.0)):
        assert plan_of(reflecting).indirect


def test_what_reflects_counts_only_where_light_gets():
    materials = grey("walls", 0.0), grey("inside", 0.7)
    assert not plan_of(*materials, reached=[True, False]).indirect
    assert plan_of(*materials, reached=[True, True]).indirect


def test_a_lamp_without_flux_is_dark_and_any_other_is_not():
    dark, dim = lamp((1.0, 1.0, 1.0), intensity=0.0), lamp((1.0, 1.0, 1.0), intensity=1e-9)
    scene = lit(box(), materials=[grey("walls", 0.5)], luminaires=(dark, dim))
    assert without_dark_lamps(scene).luminaires == (dim,)


@pytest.mark.parametrize(
    ("asked", "found"),
    [
        ({"colour": "grey"}, {"channels": 1}),
        ({"colour": "rgb"}, {"channels": 3}),
        ({"colour": "bands"}, {"channels": 40}),
        ({"degree": 11}, {"degree": 11}),
        ({"degree": 0}, {"degree": 0}),
        ({"mirrors": "stored"}, {"degree": 75}),
        ({"mirrors": "reflected"}, {"degree": 0}),
        ({"angular": "all"}, {"angular": "all"}),
        ({"angular": "seen"}, {"angular": "seen"}),
        ({"sides": "both"}, {"sides": "both"}),
        ({"indirect": False}, {"indirect": False, "residual": False, "degree": 0}),
        ({"residual": False}, {"residual": False, "indirect": True}),
    ],
)
def test_every_decision_can_be_forced_and_says_so(asked, found):
    materials = COLOURED, grey("gloss", 0.3, specular=0.1, exponent=20.0)
    sharp = grey("sharp", 0.3, specular=0.1, exponent=400.0)
    plan = plan_of(*materials, *([sharp] if "mirrors" in asked else []), **asked)
    assert {name: getattr(plan, name) for name in found} == found
    if "sides" not in asked:
        assert any("[calc]" in one.reason for one in plan.decisions)


def test_black_can_be_made_to_look_for_reflected_light():
    assert plan_of(grey("walls", 0.0), indirect=True).indirect


def test_costs_grow_with_what_is_carried():
    costs = [
        decision(plan_of(grey("walls", 0.5), colour=c), "channels").cost for c in ("grey", "rgb", "bands")
    ]
    assert [cost.time for cost in costs] == sorted({cost.time for cost in costs})
    assert [cost.memory for cost in costs] == [384.0, 1152.0, 15360.0]
    blunt, sharp = (
        decision(plan_of(grey("gloss", 0.3, specular=0.1, exponent=n)), "gloss of gloss").cost
        for n in (16.0, 64.0)
    )
    assert 1.0 < blunt.time < sharp.time
    assert (blunt.memory, sharp.memory) == (32.0 * 16**2, 32.0 * 31**2)


def test_every_decision_has_a_reason_and_a_cost():
    plan = plan_of(grey("gloss", 0.3, specular=0.1, exponent=20.0), grey("lamp", 0.3, luminance=1.0))
    for one in plan.decisions:
        assert one.name
        assert one.value
        assert one.reason
        assert str(one.cost)
