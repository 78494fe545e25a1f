import pytest
from at_rest import at_rest

from topple.benchmarks.truth.resting import RestingScene
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at


@pytest.fixture(scope="module")
def stack() -> RestingScene:
    """A box on a box, and a ball apart."""
    return at_rest(
        (shapes.box("low", (0.1, 0.1, 0.05)), pose_at(0, 0, 0)),
        (shapes.box("high", (0.06, 0.06, 0.05)), pose_at(0, 0, 0.0502)),
        (shapes.can("apart", diameter=0.05, height=0.06), pose_at(0.2, 0, 0)),
    )
