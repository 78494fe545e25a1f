"""Forces that are found without a programme, and the answers of the programme."""

import sys
from pathlib import Path

import numpy as np
import pytest

from topple.topology.statics.equilibrium import Weight, balance
from topple.topology.statics.falling import _sunk
from topple.topology.statics.holding import SMALL, deficits, is_held
from topple.topology.statics.rest import Statics, within_reach

sys.path.insert(0, str(Path(__file__).parents[1]))
from made import pile, whole


@pytest.mark.parametrize("seed", range(4))
def test_deficits_are_those_of_the_programme_whoever_is_gone(seed):
    rng = np.random.default_rng(seed)
    statics = Statics.of(whole(pile(rng, 8), rng))
    assert len(statics.weights) > 3
    for gone in statics.weights:
        left = {name: weight for name, weight in statics.weights.items() if name != gone}
        usable = within_reach([c for c in statics.contacts if gone not in (c.a, c.b)], left)
        assert deficits(left, usable) == pytest.approx(dict(balance(left, usable).deficit), abs=1e-7)


@pytest.mark.parametrize("bricks", [15, 24])  # of the second some of what falls is asked about alone
def test_falls_of_a_large_island_are_those_of_the_programme_whoever_is_gone(bricks):
    clouds = pytest.importorskip("topple.benchmarks.clouds", reason="the benches come with a checkout")
    statics = Statics.of(clouds.brick_wall(bricks, 0))
    points = sum(len(contact.gaps) for contact in statics._catchers)
    assert 6 * len(statics.weights) * 6 * points > SMALL  # none of it is solved one force at a time
    moving = 0
    for gone in statics.weights:
        near = [c for c in statics._catchers if gone not in (c.a, c.b)]
        programme, _ = _sunk({n: w for n, w in statics.weights.items() if n != gone}, near)
        far = {name: fall.beyond(statics._falls_at_rest[name]) for name, fall in programme.items()}
        asked = statics.fallen_without([gone])
        assert asked == pytest.approx({name: share for name, share in far.items() if share > 1.0})
        moving += len(asked)
    assert moving > 0


def test_what_nothing_touches_is_not_held():
    alone = {"body": Weight(1.0, np.zeros(3), 0.03)}
    assert not is_held(alone, [], 1e-9)
    assert deficits(alone, []) == {"body": 1.0}
