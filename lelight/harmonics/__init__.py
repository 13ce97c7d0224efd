"""Angular distributions as real spherical harmonics.

Convention: orthonormal over the sphere, no Condon-Shortley phase, index l² + l + m, m > 0 for cosines and
m < 0 for sines of the azimuth; polar angle from z, azimuth from x. Radiance at a node is written in the
node's local frame, whose z axis is the normal.

A route through the folder: ``indices`` (which coefficient is which), ``basis`` (values of the harmonics),
``frames`` (scene axes to local axes), ``projection`` (light to coefficients and back, by the loop of ``deposit``
or ducc0 in ``transform``), ``zonal`` (reflection as a product of coefficients), ``moments`` (illuminances of an
incident field), ``hemigrid`` (fits to a fixed grid of directions), ``spectrum`` (what a truncation leaves out),
``dark`` (nothing below zero is stored).

Modules that compile kernels are imported where they are used; nothing is imported here.
"""
