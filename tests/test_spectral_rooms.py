"""Colour of interreflected light, against closed forms: an enclosure that glows evenly."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from photofiles import batwing, ldt
from photorooms import luminaire, scene_of
from rooms import furnace, grey, lit, panel

from lelight.calculation import calculate
from lelight.channels import luminance_weighted
from lelight.errors import SceneError
from lelight.metrics.cies026 import daylight_efficacy_ratio
from lelight.metrics.colour_figures import colour_figures
from lelight.metrics.ohno2013 import temperature_and_distance
from lelight.plan import make_plan
from lelight.scene import MeasuringPlane, Observer, PointLuminaire, Spectrum
from lelight.settings import Settings
from lelight.spectral.bands import BANDS, mixed_spectrum, spectrum_of_bands
from lelight.spectral.colorimetry import illuminant

WAVELENGTHS = np.arange(380.0, 781.0, 5.0)
#: A wall that reflects red: 0.1 below 550 nm, 0.7 above 650 nm.
RED = Spectrum("red", WAVELENGTHS, 0.1 + 0.6 / (1 + np.exp(-(WAVELENGTHS - 600) / 15)))
WHITE = Spectrum("white", np.array([380.0, 780.0]), np.array([0.6, 0.6]))


def glowing(lamp: Spectrum, wall: Spectrum | None):
    """A closed box that emits a spectrum everywhere: L = L_e / (1 - ρ) in every direction."""
    room = furnace(0.6)
    (walls,) = room.materials
    walls = replace(walls, emission_spectrum=lamp, reflectance_spectrum=wall)
    return replace(
        room,
        materials=(walls,),
        planes=(MeasuringPlane("p", np.full(3, 0.3), np.array([0.4, 0, 0]), np.array([0, 0.4, 0])),),
        observers=(Observer("eye", np.full(3, 0.5), np.array([1.0, 0, 0])),),
    )


def run(scene, *, batches=4, target=None):
    return calculate(scene, Settings(preset="draft", batches=batches, target=target, edge=0.5, threads=1))


@pytest.mark.parametrize("name", ["F11", "LED-B3"])
def test_a_white_room_leaves_the_lamps_colour_alone(name):
    lamp = illuminant(name)
    found = run(glowing(lamp, WHITE))
    assert found.plan.channels == BANDS
    kelvin, duv = temperature_and_distance(lamp)
    for bands in (found.planes[0].band_replicates.mean(axis=1), found.observers[0].band_replicates):
        figures = colour_figures(bands, mixed_spectrum([lamp], [1.0]))
        assert figures["cct"].value == pytest.approx(kelvin, abs=1.0)
        assert figures["duv"].value == pytest.approx(duv, abs=1e-4)
        assert figures["melanopic_der"].value == pytest.approx(
            daylight_efficacy_ratio(lamp, "melanopic"), abs=2e-3
        )


def test_a_red_room_has_the_colour_of_endless_reflection():
    lamp = illuminant("LED-B3")
    # The colour is that of the indirect light, which needs far more samples than its amount.
    found = run(glowing(lamp, RED), batches=12, target=0.003)
    bands = found.observers[0].band_replicates
    fine = np.arange(380.0, 781.0)
    lit = Spectrum("exact", fine, lamp.at(fine) / (1 - RED.at(fine)))
    figures = colour_figures(bands, mixed_spectrum([lamp], [1.0]))
    exact, lamps_own = temperature_and_distance(lit)[0], temperature_and_distance(lamp)[0]
    # The walls take the lamp's 4100 K down by a thousand kelvin.
    assert exact < lamps_own - 800
    noise = 4 * figures["cct"].std_error
    assert figures["cct"].value == pytest.approx(exact, abs=2.0 + noise)
    assert noise < 20.0
    der = daylight_efficacy_ratio(lit, "melanopic")
    assert figures["melanopic_der"].value == pytest.approx(
        der, abs=2e-3 + 4 * figures["melanopic_der"].std_error
    )
    assert figures["melanopic_edi"].value == pytest.approx(
        der * float(luminance_weighted(bands).mean()), rel=0.01
    )


#: A wall that reflects 0.3 of blue and 0.75 of red.
PINK = Spectrum("pink", WAVELENGTHS, 0.3 + 0.45 / (1 + np.exp(-(WAVELENGTHS - 600) / 15)))
LAMP_AT, EYE_AT = np.array([0.5, 0.5, 0.3]), np.array([0.5, 0.5, 0.65])


def between_two_walls(lamp: Spectrum, wall: Spectrum):
    """A lamp of 1 cd between two parallel squares 1 m wide and 1 m apart; an eye that looks away from it."""
    lower, upper = panel((0, 0, 0), (1, 0, 0), (0, 1, 0)), panel((0, 0, 1), (0, 1, 0), (1, 0, 0))
    walls = [replace(grey(name, 0.5), reflectance_spectrum=wall) for name in ("lower", "upper")]
    made = lit(
        lower,
        upper,
        materials=walls,
        luminaires=(PointLuminaire("lamp", LAMP_AT, np.ones(3), spectrum=lamp),),
    )
    return replace(made, observers=(Observer("eye", EYE_AT, np.array([0, 0, 1.0])),))


def light_by_bounces(bounces: int, order: int = 24):
    """Illuminance (bounces,) lx at that eye after 1, 2, ... reflections by walls of reflectance 1.

    Nyström's method with Gauss-Legendre points: the kernel between parallel squares is smooth.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)
    x, y = np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2)
    across = np.stack([x.ravel(), y.ravel()], axis=1)
    areas = np.outer(weights, weights).ravel() / 4

    def kernel(a, b, distance):
        """cos cos' / r² between points (i, 2) and (j, 2) on parallel planes."""
        return distance**2 / (np.sum((a[:, None] - b) ** 2, axis=2) + distance**2) ** 2

    off = np.sum((across - LAMP_AT[:2]) ** 2, axis=1)
    height = np.array([LAMP_AT[2], 1 - LAMP_AT[2]])
    arriving = height[:, None] / (off + height[:, None] ** 2) ** 1.5
    between = kernel(across, across, 1.0) * areas / np.pi
    toward_eye = kernel(EYE_AT[None, :2], across, 1 - EYE_AT[2])[0] * areas / np.pi
    found = []
    for _ in range(bounces):
        found.append(float(toward_eye @ arriving[1]))
        arriving = (between @ arriving.T).T[::-1]
    return np.array(found)


def test_red_walls_move_the_lamps_colour_bounce_by_bounce():
    """E = S (ρ g1 + ρ² g2 + ...), the g from quadrature: nothing reaches the eye unreflected."""
    lamp, bounces = illuminant("LED-B3"), light_by_bounces(40)
    np.testing.assert_allclose(bounces, light_by_bounces(40, order=32), rtol=1e-6)
    found = run(between_two_walls(lamp, PINK), batches=40, target=0.003).observers[0]

    def coloured(upto):
        powers = PINK.amounts[:, None] ** np.arange(1, upto + 1)
        return Spectrum("exact", WAVELENGTHS, lamp.at(WAVELENGTHS) * (powers @ bounces[:upto]))

    figures = colour_figures(found.band_replicates, mixed_spectrum([lamp], [1.0]))
    kelvin = {upto: temperature_and_distance(coloured(upto))[0] for upto in (1, 2, 40)}
    # 4102 K of the lamp; 2595, 2402 and 2385 K after one, two and all reflections.
    assert kelvin[1] > kelvin[2] + 100 > kelvin[40] + 110
    noise = 4 * figures["cct"].std_error
    assert noise < 6.0
    assert figures["cct"].value == pytest.approx(kelvin[40], abs=2.0 + noise)
    der = daylight_efficacy_ratio(coloured(40), "melanopic")
    assert figures["melanopic_der"].value == pytest.approx(
        der, abs=1e-3 + 4 * figures["melanopic_der"].std_error
    )


def test_bands_keep_the_illuminance_of_a_white_furnace():
    found = run(glowing(illuminant("F11"), WHITE))
    # 1 lm/m² from every wall, over 1 - 0.6.
    values = found.observers[0]
    total = luminance_weighted(values.band_replicates)
    assert total.mean() == pytest.approx(2.5, rel=0.02)
    assert total.mean() == pytest.approx(values.direct + values.indirect, rel=1e-9)


def test_bands_go_to_a_spectrum_and_back():
    lamp = illuminant("F11")
    lamps = mixed_spectrum([lamp], [500.0])
    from lelight.spectral.bands import luminous_share

    made = spectrum_of_bands(BANDS * luminous_share(lamp, BANDS) * 320.0, lamps)
    np.testing.assert_allclose(
        made.at(WAVELENGTHS) / lamp.at(WAVELENGTHS),
        made.at(np.array([545.0]))[0] / lamp.at(np.array([545.0]))[0],
        rtol=1e-6,
    )
    assert math.isfinite(float(made.amounts.sum()))


def test_the_light_of_a_photometric_file_has_the_spectrum_that_the_scene_gives_it(tmp_path):
    grey = '[materials]\n"*" = { reflectance = 0.5 }\n'
    eye = '[[observers]]\nname = "eye"\nposition = [1, 1, 1]\ndirection = [1, 1, 0]\n'

    def observed(**keys):
        toml = grey + eye + luminaire("lamp.ldt", (2, 2, 2.9), **keys)
        return run(scene_of(tmp_path, toml, lamp_ldt=ldt(batwing))).observers[0]

    lit, plain = observed(spectrum="F11"), observed()
    kelvin = temperature_and_distance(illuminant("F11"))[0]
    figures = colour_figures(lit.band_replicates, mixed_spectrum([illuminant("F11")], [1.0]))
    assert figures["cct"].value == pytest.approx(kelvin, abs=1.0)
    # Neither the direct light of the file nor what the grey room makes of it changes with the spectrum.
    assert lit.direct == pytest.approx(plain.direct, rel=1e-6)
    assert lit.direct > 0
    assert lit.indirect == pytest.approx(plain.indirect, rel=0.03)


def test_one_photometric_lamp_without_a_spectrum_among_others_is_refused(tmp_path):
    toml = luminaire("lamp.ldt", (1, 1, 2), spectrum="D65") + luminaire("lamp.ldt", (3, 3, 2)).replace(
        '"L"', '"M"'
    )
    with pytest.raises(SceneError, match=r'no spectrum: "M"; .*every emitter needs'):
        scene_of(tmp_path, toml, lamp_ldt=ldt())


def test_a_scene_without_spectra_stays_grey():
    assert make_plan(furnace(0.5)).channels == 1
