"""Spectral bands: from spectra to the channels that are carried, and from channels back to a spectrum.

A band's channel is C times its luminous share, so that the mean of all C is the luminance. What the scene
does to light between lamp and eye is smooth in wavelength, what a lamp emits is not: so the transfer, band
by band, is put on the lamps' own spectrum when a spectrum is made of bands again.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lelight.scene import FloatArray, Material, PointLuminaire, Scene, Spectrum

#: nm; visible range that is carried, and bands of 10 nm in it.
SHORTEST, LONGEST = 380.0, 780.0
BANDS = 40
#: nm; where the blue, green and red thirds of a colour without a spectrum meet.
BLUE_GREEN, GREEN_RED = 490.0, 580.0
#: nm; step of sums over wavelengths.
STEP = 1.0


def band_edges(count: int = BANDS) -> FloatArray:
    """Edges (count + 1,) of equal bands, nm."""
    return np.linspace(SHORTEST, LONGEST, count + 1)


def band_centres(count: int = BANDS) -> FloatArray:
    """Middles (count,) of equal bands, nm."""
    edges = band_edges(count)
    return np.asarray((edges[1:] + edges[:-1]) / 2)


def is_spectral_scene(scene: Scene) -> bool:
    """Say whether any emitter or material of a scene has a spectrum."""
    emitters = [lamp.spectrum for lamp in scene.luminaires]
    materials = [each for m in scene.materials for each in (m.reflectance_spectrum, m.emission_spectrum)]
    return any(spectrum is not None for spectrum in [*emitters, *materials])


def fine_wavelengths() -> FloatArray:
    """Wavelengths (n,) in nm of sums: the middles of steps of 1 nm, ten or so in every band."""
    return np.arange(SHORTEST + STEP / 2, LONGEST, STEP)


def band_numbers(count: int) -> FloatArray:
    """Band (n,) int of each of the fine wavelengths."""
    return np.asarray(np.searchsorted(band_edges(count), fine_wavelengths(), side="right") - 1)


def luminous_efficiency() -> FloatArray:
    """V(λ) (n,) at the fine wavelengths (CIE 1924 photopic observer, from colour-science)."""
    from lelight.spectral.colorimetry import photopic

    return photopic(fine_wavelengths())


def luminous_share(spectrum: Spectrum, count: int) -> FloatArray:
    """Share (count,) of the luminous flux of a light that lies in each band; the sum is 1."""
    lumens = _in_bands(spectrum.at(fine_wavelengths()) * luminous_efficiency(), count)
    return np.asarray(lumens / lumens.sum())


def reflectance_in_bands(spectrum: Spectrum, count: int) -> FloatArray:
    """Mean reflectance (count,) of each band; beyond its samples a spectrum goes on level."""
    fine = np.interp(fine_wavelengths(), spectrum.wavelengths, spectrum.amounts)
    per_band = _in_bands(np.ones_like(fine), count)
    return _in_bands(fine, count) / per_band


def diffuse_in_channels(materials: Sequence[Material], matrix: FloatArray) -> FloatArray:
    """Lambertian reflectance (M, C) of materials; a spectrum wins over the colour where bands are carried.

    Parameters
    ----------
    matrix : (3, C) float; turns linear Rec. 709 components into channels
    """
    from lelight.channels import is_spectral

    diffuse = np.array([m.diffuse for m in materials]).reshape(-1, 3) @ matrix
    count = matrix.shape[1]
    if is_spectral(count):
        for number, material in enumerate(materials):
            if material.reflectance_spectrum is not None:
                diffuse[number] = reflectance_in_bands(material.reflectance_spectrum, count)
    return diffuse


def emission_in_channels(
    colours: Sequence[FloatArray], spectra: Sequence[Spectrum | None], matrix: FloatArray
) -> FloatArray:
    """Luminances or intensities (n, C) of emitters.

    Parameters
    ----------
    colours : (3,) float each, linear Rec. 709 components
    spectra : None for an emitter without one
    matrix : (3, C) float
    """
    from lelight.channels import is_spectral
    from lelight.scene import LUMINANCE_WEIGHTS

    rgb = np.array(colours, dtype=np.float64).reshape(-1, 3)
    emitted = rgb @ matrix
    count = matrix.shape[1]
    if is_spectral(count):
        for number, spectrum in enumerate(spectra):
            if spectrum is not None:
                luminous = float(rgb[number] @ LUMINANCE_WEIGHTS)
                emitted[number] = luminous * count * luminous_share(spectrum, count)
    return emitted


def mixed_spectrum(spectra: Sequence[Spectrum], fluxes: Sequence[float]) -> Spectrum:
    """Spectrum of all lamps together, each by its luminous flux (lm), in W per nm and unit of area or solid.

    It is sampled where the lamps' own spectra are.
    """
    from lelight.spectral.colorimetry import LUMINOUS_EFFICACY

    wavelengths = np.unique(np.concatenate([each.wavelengths for each in spectra]))
    inside = (wavelengths >= SHORTEST) & (wavelengths <= LONGEST)
    wavelengths = np.unique(np.concatenate([[SHORTEST], wavelengths[inside], [LONGEST]]))
    amounts = np.zeros(len(wavelengths))
    fine, efficiency = fine_wavelengths(), luminous_efficiency()
    for spectrum, flux in zip(spectra, fluxes, strict=True):
        lumens = LUMINOUS_EFFICACY * STEP * float(spectrum.at(fine) @ efficiency)
        amounts += flux / lumens * spectrum.at(wavelengths)
    return Spectrum("mixture of the lamps", wavelengths, amounts)


def spectrum_of_bands(bands: FloatArray, lamps: Spectrum) -> Spectrum:
    """Make a spectrum of channels (C,): the lamps' spectrum times a smooth transfer with the mean of every band.

    Parameters
    ----------
    bands : (C,) float, as carried: C times the luminous quantity of each band
    lamps : mixture of all lamps that light the scene

    Returns
    -------
    Spectrum in W per nm of what the bands were in lm (irradiance for illuminance); its luminous quantity is
    the mean of the bands
    """
    from lelight.spectral.colorimetry import LUMINOUS_EFFICACY

    count = len(bands)
    fine, efficiency = fine_wavelengths(), luminous_efficiency()
    emitted = LUMINOUS_EFFICACY * STEP * _in_bands(lamps.at(fine) * efficiency, count)
    known = emitted > 1e-12 * emitted.sum()
    if not known.any():
        return Spectrum(lamps.name, lamps.wavelengths, np.zeros_like(lamps.amounts))
    transfer = np.maximum(bands[known], 0.0) / count / emitted[known]
    means = np.interp(band_centres(count), band_centres(count)[known], transfer)
    # Never closer than lamps are tabulated: tables every 5 nm are meant to be summed as they stand.
    wavelengths = np.union1d(lamps.wavelengths, np.union1d(band_edges(count), band_centres(count)))
    made = Spectrum(lamps.name, wavelengths, lamps.at(wavelengths) * _of_means(means, wavelengths))
    lumens = LUMINOUS_EFFICACY * STEP * float(made.at(fine) @ efficiency)
    scale = float(np.mean(bands)) / lumens if lumens > 0 else 0.0
    return Spectrum(made.name, made.wavelengths, np.maximum(made.amounts * scale, 0.0))


def lamp_mixture(scene: Scene, fluxes: FloatArray) -> Spectrum | None:
    """Mixture of a scene's lamps; None without spectra.

    Parameters
    ----------
    fluxes : (emitting materials + luminaires,) float, lm, in the order of the scene
    """
    spectra = emitter_spectra(scene)
    known = [(s, float(f)) for s, f in zip(spectra, fluxes, strict=True) if s is not None and f > 0]
    if not known:
        return None
    return mixed_spectrum([s for s, _ in known], [f for _, f in known])


def emitter_spectra(scene: Scene) -> list[Spectrum | None]:
    """Spectra of the emitting materials, then of the luminaires, None where none is given."""
    materials = [m.emission_spectrum for m in scene.materials if m.emits]
    return [*materials, *(lamp.spectrum for lamp in scene.luminaires)]


def without_spectrum(scene: Scene) -> list[str]:
    """Names of the emitters of a scene that have no spectrum."""
    emitters: list[Material | PointLuminaire] = [m for m in scene.materials if m.emits]
    names = [each.name for each in [*emitters, *scene.luminaires]]
    return [name for name, s in zip(names, emitter_spectra(scene), strict=True) if s is None]


def _of_means(means: FloatArray, wavelengths: FloatArray) -> FloatArray:
    """Smooth function (n,) of wavelength that has these means (C,) in the bands, and is nowhere below zero.

    It is the slope of a cubic spline through the sums over whole bands.
    """
    from scipy.interpolate import CubicSpline

    edges = band_edges(len(means))
    sums = np.concatenate([[0.0], np.cumsum(means * np.diff(edges))])
    slope = CubicSpline(edges, sums).derivative()
    return np.asarray(np.maximum(slope(np.clip(wavelengths, edges[0], edges[-1])), 0.0))


def _in_bands(fine: FloatArray, count: int) -> FloatArray:
    """Sum (count,) over the fine wavelengths (n,) of each band."""
    return np.bincount(band_numbers(count), weights=fine, minlength=count).astype(np.float64)
