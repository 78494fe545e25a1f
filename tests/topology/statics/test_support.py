import numpy as np
import pytest

from topple.topology import Scene
from topple.topology.situation.situation import Situation
from topple.topology.sixim.confidence import Evidence, confidence
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import Weight, balance


def box(
    size: tuple[float, float, float], centre: tuple[float, float, float], turn: float = 0.0
) -> np.ndarray:
    rng = np.random.default_rng(5)
    points = rng.uniform(-0.5, 0.5, (1800, 3))
    axis = rng.integers(0, 3, len(points))
    points[np.arange(len(points)), axis] = rng.choice([-0.5, 0.5], len(points))
    points = points * size
    c, s = np.cos(turn), np.sin(turn)
    return points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T + centre


def table() -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-0.4, 0.4, 50), np.linspace(-0.4, 0.4, 50))
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)


def found(clouds: dict[str, np.ndarray]) -> dict[tuple[str, str], str]:
    scene = Scene({**clouds, "table": table()}, fixed=["table"], up=(0, 0, 1))
    return {(s.supporter, s.supported): s.kind for s in Situation(scene).supports}


def test_a_stack_is_carried_from_below_only():
    clouds = {"low": box((0.1, 0.1, 0.06), (0, 0, 0.03)), "top": box((0.07, 0.07, 0.05), (0.01, 0, 0.085))}
    assert found(clouds) == {("table", "low"): "rests", ("low", "top"): "rests"}


def test_a_bridge_rests_on_both_piers():
    clouds = {
        "left": box((0.06, 0.08, 0.08), (-0.08, 0, 0.04)),
        "right": box((0.06, 0.08, 0.08), (0.08, 0, 0.04)),
        "bridge": box((0.24, 0.05, 0.03), (0, 0, 0.095)),
    }
    carried = found(clouds)
    assert carried["left", "bridge"] == carried["right", "bridge"] == "rests"
    assert ("table", "bridge") not in carried


def test_side_by_side_carries_nobody():
    clouds = {"a": box((0.08,) * 3, (-0.0405, 0, 0.04)), "b": box((0.08,) * 3, (0.0405, 0, 0.04))}
    assert set(found(clouds)) == {("table", "a"), ("table", "b")}


def _patch(points: list[list[float]], normal: list[float]) -> Contact:
    count = len(points)
    return Contact(
        "table", "body", np.array(points), np.tile(normal, (count, 1)), np.zeros(count), np.zeros(count)
    )


def test_a_weight_over_its_foot_is_in_equilibrium_and_beside_it_is_not():
    foot = _patch([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.1, 0.1, 0]], [0, 0, 1.0])
    over = Weight(1.0, np.array([0.05, 0.05, 0.05]), 0.03)
    beside = Weight(1.0, np.array([0.13, 0.05, 0.05]), 0.03)
    assert balance({"body": over}, [foot]).deficit["body"] == pytest.approx(0, abs=1e-6)
    assert balance({"body": beside}, [foot]).deficit["body"] > 0.5


def test_a_slope_holds_by_friction_up_to_its_angle():
    def missing(degrees: float) -> float:
        s, c = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
        along, across, normal = np.array([c, 0, s]), np.array([0, 1.0, 0]), np.array([-s, 0, c])
        corners = [0.05 * (i * along + j * across) for i in (-1, 1) for j in (-1, 1)]
        contact = _patch([list(p) for p in corners], list(normal))
        return balance({"body": Weight(1.0, 0.01 * normal, 0.03)}, [contact]).deficit["body"]

    assert missing(20) == pytest.approx(0, abs=1e-6)
    assert missing(35) > 0.05


def test_the_load_of_two_feet_is_the_weight():
    foot = _patch([[-0.1, 0, 0], [0.1, 0, 0]], [0, 0, 1.0])
    loads = balance({"body": Weight(2.0, np.array([0.05, 0, 0.1]), 0.03)}, [foot]).loads[0]
    assert loads.sum() == pytest.approx(2.0)
    assert loads[1] == pytest.approx(1.5)


@pytest.mark.parametrize("lower", [0.0, 0.004, 0.0085])
def test_a_support_is_believed_as_others_with_such_a_gap_were_true(lower):
    """A bridge from a pier to a board, which lies lower than the pier is high [m]."""
    x, y = np.meshgrid(np.linspace(0.05, 0.2, 40), np.linspace(-0.1, 0.1, 40))
    clouds = {
        "pier": box((0.06, 0.08, 0.08), (-0.08, 0, 0.04)),
        "board": np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.08 - lower)], axis=1),
        "bridge": box((0.24, 0.05, 0.03), (0, 0, 0.095)),
        "table": table(),
    }
    carried = Situation(Scene(clouds, fixed=["table", "board"], up=(0, 0, 1))).supports
    (found,) = (one for one in carried if (one.supporter, one.supported) == ("board", "bridge"))
    assert not found.inferred
    assert found.gap == pytest.approx(lower, abs=1e-6)
    assert found.confidence == confidence(Evidence.CARRIES, 0, lower)
