"""Radiance's programs, as the wheel ``pyradiance`` brings them."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

import pytest


def program(name: str) -> Path:
    """Path of a program; the test that asks is skipped where the wheel is not installed."""
    return _wheel(name) / "bin" / name


def environment() -> dict[str, str]:
    """Variables with which the programs find their own files."""
    return {**os.environ, "RAYPATH": str(_wheel("Radiance") / "lib")}


def _wheel(asked: str) -> Path:
    package = importlib.util.find_spec("pyradiance")
    if package is None or package.origin is None:
        pytest.skip(f"pyradiance, which brings {asked}, is not installed")
    return Path(package.origin).parent
