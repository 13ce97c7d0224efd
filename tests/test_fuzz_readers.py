"""Damaged files of every reader: read, or refused in one line; see `fuzz_readers`, which does it in bulk."""

from __future__ import annotations

import resource

import pytest
from fuzz_readers import fuzz, readers

#: Files a reader, and MB that all of them may take beside what the process has.
FILES, MOST_MEMORY = 2000, 300


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    return readers(tmp_path_factory.mktemp("fuzz"))


@pytest.mark.parametrize(
    "name", ["obj", "mtl", "toml", "checkpoint", "run.json", "metrics.json", "field.vtp"]
)
def test_damaged_files_are_read_or_refused_in_one_line(sources, name):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    accepted = fuzz(sources[name], count=FILES, seed=20, name=name)
    assert 0 < accepted < FILES
    assert (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024 < MOST_MEMORY


def test_blocks_of_zeros_do_not_end_the_process(sources):
    """What VTK's own reader did not survive: compressed blocks and their lengths zeroed."""
    (corpus, read), refused = sources["field.vtp"], 0
    content = corpus[0]
    start = content.index(b"_", content.index(b"<AppendedData")) + 1
    for first in range(start, len(content) - 200, (len(content) - start) // 40):
        try:
            read(content[:first] + bytes(160) + content[first + 160 :])
        except Exception as refusal:
            refused += type(refusal).__name__ == "OutputError"
    assert refused >= 38
