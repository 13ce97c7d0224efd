"""How numeric functions are compiled.

Numba counts references to every array that a function is handed, and to all of them in a tuple such as `Emitters`,
call by call: in a function of one sample that takes longer than what it computes. `LEAF` does without; it is for
functions that make no arrays, which Numba then refuses.
"""

from __future__ import annotations

from typing import Any

#: Options of `numba.njit`: cached on disk, without Python's lock, division as in IEEE 754.
COMPILED: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy"}
#: For functions that loops call for each sample.
LEAF: dict[str, Any] = {**COMPILED, "_nrt": False}
