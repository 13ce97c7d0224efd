"""Mutated photometric files in bulk: ``python tests/fuzz_photometry.py 10000 SEED``.

Each file either reads with a flux that is finite and not negative, or fails in one line; none takes long or much
memory. The suite runs the same on fewer files.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from mutations import mutated
from photofiles import CORPUS_IES, CORPUS_LDT

from lelight.errors import InputError
from lelight.metrics.cie190 import ugr_table
from lelight.photometry.facts import facts
from lelight.photometry.findings import findings
from lelight.photometry.reading import read_photometry
from lelight.photometry.writing import as_eulumdat, as_ies
from lelight.photometry.zones import luminous_flux

#: Longest time in s for one file, on a busy machine.
LONGEST = 5.0


def tried(source: bytes, path: Path, *, deep: bool) -> bool:
    """Read one file; True where it reads. Everything that a command does with it has to work too."""
    path.write_bytes(source)
    started = time.perf_counter()
    try:
        photometry = read_photometry(path)
    except InputError as failure:
        message = str(failure)
        assert str(path) in message, message
        assert "\n" not in message.strip(), message
        assert len(message) < 500, message
        return False
    flux = luminous_flux(photometry)
    assert math.isfinite(flux), flux
    assert flux >= 0, flux
    findings(photometry)
    if deep:
        facts(photometry)
        as_ies(photometry)
        as_eulumdat(photometry)
        if flux > 0 and photometry.opening.size > 0:
            ugr_table(photometry, spacing=1.0)
    assert time.perf_counter() - started < LONGEST
    return True


def fuzz(corpus: tuple[str, ...], ending: str, *, count: int, seed: int, folder: Path) -> int:
    """Try ``count`` mutated files; returns how many could be read."""
    rng = np.random.default_rng(seed)
    path = folder / f"mutated{ending}"
    read = 0
    for k in range(count):
        source = mutated(corpus[k % len(corpus)].encode("latin-1"), rng)
        try:
            read += tried(source, path, deep=k % 10 == 0)
        except Exception:
            (Path(tempfile.gettempdir()) / f"failed{ending}").write_bytes(source)
            raise
    return read


if __name__ == "__main__":
    import resource
    import warnings

    warnings.simplefilter("error")
    count, seed = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    with tempfile.TemporaryDirectory() as folder:
        for corpus, ending in ((CORPUS_IES, ".ies"), (CORPUS_LDT, ".ldt")):
            started = time.perf_counter()
            read = fuzz(corpus, ending, count=count, seed=seed, folder=Path(folder))
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            print(
                f"{ending}: {count} files, {read} read, {time.perf_counter() - started:.0f} s, {memory:.0f} MB peak"
            )
