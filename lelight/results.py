"""What a run found, as plain arrays: at nodes, on planes, at eyes. Writers and metrics read these."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lelight.scene import FloatArray, IntArray, MeasuringPlane, Observer


@dataclass(frozen=True)
class NodeValues:
    """Light at the n nodes of a mesh, in C channels.

    Attributes
    ----------
    illuminance : (n, C) float, lx, direct and indirect
    std_error : (n,) float, lx, one standard error of the luminance-weighted illuminance
    direct : (n, C) float, lx, the part that comes straight from emitters
    scalar_illuminance : (n, C) float, lx, a quarter of the integral of radiance over the node's hemisphere
    light_vector : (n, 3, C) float, lx, scene axes
    sh_degree : (n,) int; degree of the reflected radiance that is stored, 0 for diffuse nodes
    radiance_sh : (n, (L + 1)**2, C) float32, L the largest degree; reflected radiance in cd/m², real
        orthonormal harmonics, index l² + l + m, no Condon-Shortley phase, local frame of the node;
        without the direct highlights of emitters
    truncation : (n,) float32, cd/m², root mean square over directions of what the degree leaves out of lobes
    """

    illuminance: FloatArray
    std_error: FloatArray
    direct: FloatArray
    scalar_illuminance: FloatArray
    light_vector: FloatArray
    sh_degree: IntArray
    radiance_sh: NDArray[np.float32]
    truncation: NDArray[np.float32]


@dataclass(frozen=True)
class PlaneValues:
    """Light on a measuring plane's grid of rows x columns points, luminance-weighted.

    Attributes
    ----------
    points : (rows * columns, 3) float, m; row by row, u running fastest
    illuminance, std_error, cylindrical : (rows * columns,) float, lx
    replicates : (R, rows * columns) float, lx: illuminance by each independent batch
    cylindrical_replicates : (R, rows * columns) float, lx
    moment_replicates : (R, rows * columns, 6) float, lx; rows as in `lelight.receivers`
    vertical_replicates : (R, rows * columns, 4) float, lx, on faces toward +x, +y, -x, -y
    area_replicates : (R, k) float, lx, by ``surrounding`` and ``background``, where they are asked for
    band_replicates : (R, rows * columns, C) float, lx in spectral bands; None without spectra
    """

    plane: MeasuringPlane
    shape: tuple[int, int]
    points: FloatArray
    illuminance: FloatArray
    std_error: FloatArray
    cylindrical: FloatArray
    replicates: FloatArray
    cylindrical_replicates: FloatArray
    moment_replicates: FloatArray | None = None
    vertical_replicates: FloatArray | None = None
    area_replicates: dict[str, FloatArray] = field(default_factory=dict)
    band_replicates: FloatArray | None = None


@dataclass(frozen=True)
class ObserverValues:
    """Light at an eye, luminance-weighted, on the plane normal to the line of sight.

    Attributes
    ----------
    direct, indirect : float, lx: straight from emitters, and all the rest
    indirect_replicates : (R,) float, lx: by each independent batch
    moment_replicates : (R, 6) float, lx; rows as in `lelight.receivers`
    turned_indirect, turned_total : (R, 24) float, lx: were the eye turned in steps of 15 degrees, itself first
    band_replicates : (R, C) float, lx in spectral bands; None without spectra
    """

    observer: Observer
    direct: float
    indirect: float
    indirect_replicates: FloatArray
    moment_replicates: FloatArray | None = None
    turned_indirect: FloatArray | None = None
    turned_total: FloatArray | None = None
    band_replicates: FloatArray | None = None
