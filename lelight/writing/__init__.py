"""Writing results: VTK files, luminance pictures, the ParaView script; whole files or none."""
