"""Veiling luminance in the eye, CIE 146:2002, per lux on the plane across the line of sight.

The equations agree in three public programs and with the report's abstract; its text was not opened.
"""

from __future__ import annotations


def general(theta: float, *, age: float, pigment: float) -> float:
    """Veiling luminance (cd/m² per lx), CIE general disability glare equation, 0.1° to 100°.

    ``10/θ³ + (5/θ² + 0.1 p/θ)(1 + (A/62.5)⁴) + 0.0025 p``

    Parameters
    ----------
    theta : float, degrees from the line of sight
    age : float, years
    pigment : float, 0 dark brown eyes, 0.5 brown, 1 blue-green, 1.2 very light
    """
    _require_angle(theta, 0.1, 100.0)
    ageing = 1 + (age / 62.5) ** 4
    return 10 / theta**3 + (5 / theta**2 + 0.1 * pigment / theta) * ageing + 0.0025 * pigment


def stiles_holladay(theta: float, *, age: float) -> float:
    """Veiling luminance (cd/m² per lx), age-adjusted Stiles-Holladay, ``10/θ² (1 + (A/70)⁴)``, 1° to 30°."""
    _require_angle(theta, 1.0, 30.0)
    return 10 / theta**2 * (1 + (age / 70) ** 4)


def visible_contrast(contrast: float, *, background: float, veil: float) -> float:
    """Weber contrast that a veil leaves: ``C L_b / (L_b + L_v)``, luminances in cd/m²."""
    return contrast * background / (background + veil)


def _require_angle(theta: float, low: float, high: float) -> None:
    if not low <= theta <= high:
        raise ValueError(f"theta: found {theta:g} degrees, allowed is {low:g} to {high:g}")
