"""Reading scenes: OBJ, MTL and TOML files into a `lelight.scene.Scene`, and what is odd about them."""
