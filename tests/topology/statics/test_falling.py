import numpy as np
import pytest

from topple.topology.scene.scene import Scene
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import Weight
from topple.topology.statics.falling import falls
from topple.topology.statics.rest import Statics


def _feet(gaps: list[float], width: float = 0.1) -> Contact:
    """Four points under a body on a plane, with gaps."""
    corners = width / 2 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0.0]])
    return Contact("table", "body", corners, np.tile([0, 0, 1.0], (4, 1)), np.array(gaps), np.zeros(4))


def _body(x: float = 0.0) -> dict[str, Weight]:
    return {"body": Weight(1.0, np.array([x, 0, 0.03]), 0.03)}


def test_what_stands_on_its_feet_does_not_move():
    fall = falls(_body(), [_feet([0.0] * 4)])["body"]
    assert fall.distance == pytest.approx(0, abs=1e-6)
    assert fall.angle == pytest.approx(0, abs=1e-6)


def test_what_hangs_over_a_gap_falls_by_the_gap():
    fall = falls(_body(), [_feet([0.0085] * 4)])["body"]
    assert fall.distance == pytest.approx(0.008, abs=1e-4)


def test_what_stands_on_two_feet_tips_until_the_others_meet_the_ground():
    fall = falls(_body(0.01), [_feet([0, 0.0105, 0.0105, 0])])["body"]
    assert np.degrees(fall.angle) == pytest.approx(np.degrees(0.010 / 0.1), rel=0.15)


def test_what_nothing_carries_falls_as_far_as_is_followed():
    assert falls(_body(), [])["body"].distance == pytest.approx(0.02, rel=0.01)


def test_what_is_gone_carries_nothing_and_does_not_fall():
    low, high = Weight(1.0, np.array([0, 0, 0.03]), 0.03), Weight(1.0, np.array([0, 0, 0.09]), 0.03)
    foot = _feet([0.0] * 4)
    on = Contact("body", "top", foot.points + np.array([0, 0, 0.06]), foot.normals, foot.gaps, foot.turns)
    found = falls({"body": low, "top": high}, [foot, on], without=["body"])
    assert set(found) == {"top"}
    assert found["top"].distance > 0.015


def _box(size: tuple[float, float, float], low: tuple[float, float, float]) -> np.ndarray:
    axes = [np.linspace(0, length, round(length / 0.004) + 1) for length in size]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return points[(np.isclose(points, 0) | np.isclose(points, size)).any(axis=1)] + low


def test_a_plank_falls_without_the_weight_on_its_end_and_not_without_what_stands_aside():
    x, y = np.meshgrid(np.linspace(-0.3, 0.3, 60), np.linspace(-0.3, 0.3, 60))
    clouds = {
        "block": _box((0.08, 0.08, 0.06), (-0.08, -0.04, 0)),
        "plank": _box((0.16, 0.04, 0.024), (-0.06, -0.02, 0.06)),
        "weight": _box((0.04, 0.04, 0.1), (-0.06, -0.02, 0.084)),
        "aside": _box((0.04, 0.04, 0.04), (-0.2, 0.1, 0)),
        "table": np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1),
    }
    statics = Statics.of(Scene(clouds, fixed=["table"], up=(0, 0, 1)))
    assert "plank" in statics.fallen_without(["weight"])
    assert {"plank", "weight"} <= set(statics.fallen_without(["block"]))
    assert statics.fallen_without(["aside"]) == {}
