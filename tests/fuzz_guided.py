"""Damaged files that coverage leads to: ``python tests/fuzz_guided.py READER -runs=100000``, with Atheris installed.

READER is one of `fuzz_readers`, or ``ies`` or ``ldt``; what follows are options of libFuzzer. It starts from sound
files and ends at the first that is neither read nor refused in one line, takes 5 s, or more than 500 MB beyond what
the program takes itself.
"""

from __future__ import annotations

import resource
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType

import atheris
import fuzz_photometry
import fuzz_readers
from photofiles import CORPUS_IES, CORPUS_LDT

from lelight.errors import LelightError

#: What reads files; nothing else is followed.
FOLLOWED = (
    "lelight.reading",
    "lelight.photometry",
    "lelight.checkpoint",
    "lelight.pipelines",
    "lelight.reports",
    "lelight.writing",
)
#: Seconds that a file may take, and MB.
LONGEST, MOST = 5, 500


def followed_functions() -> Iterator[FunctionType]:
    """All functions and methods of the modules that are followed."""
    modules = [module for name, module in sorted(sys.modules.items()) if name.startswith(FOLLOWED)]
    for module in modules:
        owners = [module, *(each for each in vars(module).values() if isinstance(each, type))]
        for owner in owners:
            for each in list(vars(owner).values()):
                plain = getattr(each, "__func__", each)
                if isinstance(plain, FunctionType) and plain.__module__ == module.__name__:
                    yield plain


def reader(name: str, folder: Path) -> tuple[list[bytes], Callable[[bytes], object]]:
    """Sound files of a reader, and how it reads what became of them."""
    photometric = {"ies": CORPUS_IES, "ldt": CORPUS_LDT}
    if name in photometric:
        path = folder / f"mutated.{name}"
        sound = [text.encode("latin-1") for text in photometric[name]]
        return sound, lambda content: fuzz_photometry.tried(content, path, deep=False)
    return fuzz_readers.readers(folder)[name]


def main() -> None:
    """Hand the files on to libFuzzer, which does not come back."""
    name, options = sys.argv[1], sys.argv[2:]
    folder = Path(tempfile.mkdtemp())
    sound, read = reader(name, folder)
    corpus = folder / "corpus"
    corpus.mkdir()
    for number, content in enumerate(sound):
        (corpus / str(number)).write_bytes(content)

    def once(content: bytes) -> None:
        if name == "checkpoint" and content in sound:
            return  # Its reader is to notice damage.
        try:
            read(content)
        except LelightError as refusal:
            assert "\n" not in str(refusal), refusal

    for function in followed_functions():
        atheris.instrument_func(function)
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    limits = [f"-timeout={LONGEST}", f"-rss_limit_mb={own + MOST}", "-max_len=262144", "-len_control=0"]
    atheris.Setup([sys.argv[0], *limits, *options, str(corpus)], once)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
