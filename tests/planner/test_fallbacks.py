"""The table of relaxations: what it says, and that what a caller leaves out is not tried."""

import re
from pathlib import Path

import pytest

from topple.planner.fallbacks import RELAXATIONS, select
from topple.topology.base.errors import InvalidInput


def test_every_relaxation_has_words_of_its_own_and_the_count_that_the_benchmark_wrote():
    text = (Path(__file__).parents[2] / "benchmarks" / "run.md").read_text()
    for row in RELAXATIONS:
        stood = re.search(rf"steps by {row}, of 3951 \| (\d+)", text)
        share = re.search(rf"of these succeeded: {row} \| ([\d.]+) %", text)
        counted = round(int(stood[1]) * float(share[1] if share else 0) / 100) if stood else None
        assert row.saved == counted
    assert len({words for row in RELAXATIONS for words in (row.when, row.changes)}) == 2 * len(RELAXATIONS)


def test_a_selection_is_of_the_table_alone():
    assert select("narrow") == {"narrow"}
    with pytest.raises(InvalidInput, match="unknown relaxation 'magic': expected some of another first, "):
        select(["narrow", "magic"])
