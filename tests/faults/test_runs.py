"""A run in which something goes wrong reaches its goal or names it, and disturbs nothing else."""

import pytest

from topple.benchmarks.faults.inject import FAULTS, play

SEED = 0


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name.replace(" ", "-"))
def test_a_run_survives(fault):
    run = play(fault, SEED)
    assert run.crashed == ""
    assert not run.lied, run.text
    assert run.disturbed == 0, run.text
    assert run.reached or run.named, run.text
