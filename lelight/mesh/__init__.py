"""From triangles to nodes: patches, remeshing, node placement, and where a surface point lies among them."""
