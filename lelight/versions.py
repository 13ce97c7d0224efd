"""Versions of the program and of the packages that its numbers rest on."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

import lelight

#: Packages whose versions may change a figure.
PACKAGES = ("numpy", "scipy", "numba", "embreex", "pymeshlab", "ducc0", "vtk", "pyvista")


def versions() -> dict[str, str]:
    """Versions by name, the program's own first; packages that are not there are left out."""
    return {"lelight": lelight.__version__, **package_versions()}


def package_versions() -> dict[str, str]:
    """Versions of the packages alone."""
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found
