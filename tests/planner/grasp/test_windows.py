import numpy as np
import pytest

from topple.planner.grasp.frames import frames
from topple.planner.grasp.jaw import hand_shape
from topple.planner.grasp.shape import Sought
from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.planner.grasp.windows import State, windows
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box, can
from topple.robots.shapes.tableware import bowl, mug
from topple.topology.kernels import compiled
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

UP = np.array([0.0, 0.0, 1.0])
HAND = hand_shape(robot("panda"))


def crowded() -> Scene:
    rng, axis = np.random.default_rng(3), np.arange(-0.3, 0.3, 0.006)
    found = {"table": np.stack(np.meshgrid(axis, axis, [0.0]), axis=-1).reshape(-1, 3)}
    things = (can("can"), box("wide", (0.12, 0.1, 0.05)), bowl("bowl"), mug("mug"))
    for body, x, y in zip(things, (0.0, 0.02, 0.0, 0.09), (0.0, 0.09, -0.12, 0.0), strict=True):
        points = body.surface(4000, rng)
        points += np.array([x, y, -points[:, 2].min()])
        found[body.name] = points + rng.normal(0.0, 0.0005, points.shape)
    return Scene(found, fixed=["table"], up=UP)


@pytest.mark.skipif(compiled.kernels() is None, reason="no kernels were compiled here")
def test_pads_close_on_the_same_by_kernel_and_twin(monkeypatch):
    situation, met = Situation(crowded()), set[int]()
    for name in ("can", "wide", "bowl", "mug"):
        sought = Sought.of(name, situation)
        for directions in frames(sought.surface, UP, GRASP_TOLERANCES.tilts, count=6):
            monkeypatch.delenv(compiled.VARIABLE, raising=False)
            ours = windows(directions, sought, HAND)
            monkeypatch.setenv(compiled.VARIABLE, "numpy")
            twin = windows(directions, sought, HAND)
            assert np.array_equal(ours.states, twin.states)
            assert np.array_equal(ours.barring, twin.barring)
            holds = ours.states == State.HOLDS
            assert np.allclose(ours.values[holds], twin.values[holds], rtol=0.0, atol=1e-9)
            met.update(ours.states.ravel().tolist())
    assert met >= set(State) - {State.EMPTY, State.PADS}
