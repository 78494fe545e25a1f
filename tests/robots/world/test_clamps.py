"""A fixture in a world: what it keeps stays where it is, whatever is taken away, until it lets go."""

import numpy as np
import pytest

from topple.robots import scenario
from topple.robots.engines import fixture_in
from topple.robots.poses import angle_between
from topple.robots.world.clamps import Clamps
from topple.topology import UnknownObject


@pytest.mark.parametrize(
    ("seed", "kept", "gone"), [(0, "left", "right"), (1, "plank", "load"), (9, "bowl", "can")]
)
def test_it_keeps_what_would_fall_and_lets_go_of_it(seed, kept, gone):
    with scenario("hold", seed) as stage:
        world = stage.world
        before, clamps = world.poses(), Clamps(world, [kept])
        world.step(240)
        assert np.allclose(world.pose(kept), before[kept], atol=1e-5), "nor does it press on what is below"
        world.remove(gone)
        world.step(480)
        for name in set(before) - {gone}:
            assert np.linalg.norm((world.pose(name) - before[name])[:3, 3]) < 1e-3, name
        assert clamps.clamped == {kept}
        clamps.release(kept)
        world.step(480)
        assert not clamps.clamped
        assert np.degrees(angle_between(world.pose(kept), before[kept])) > 10.0
        clamps.release(kept)


def test_what_is_not_there_or_never_moves_is_refused():
    with scenario("hold", 1) as stage:
        for name in ("shelf", "table"):
            with pytest.raises(UnknownObject, match=name):
                Clamps(stage.world, [name])
        assert fixture_in(stage.world, ()) is None
