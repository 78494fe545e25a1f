import numpy as np
import pytest

from topple.planner.decide.dependency import Dependency, DependencyGraph, dependencies, reason_out
from topple.robots import shapes
from topple.topology import Scene, UnknownObject
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.samples import sample
from topple.topology.situation.situation import Situation
from topple.topology.statics.sweep import overlap


def slab(x: float, z: float, size: float = 0.1) -> np.ndarray:
    steps = np.arange(0, size, 0.004)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return np.column_stack([grid[:, 0] + x, grid[:, 1], np.full(len(grid), z)])


def test_what_hangs_over_must_be_pushed_aside_by_its_overhang():
    found, thin = overlap(slab(0.06, 0.1), slab(0.0, 0.0)), overlap(slab(0.05, 0.1, 0.004), slab(0.0, 0.0))
    assert found is not None and found.evasion == pytest.approx(0.04, abs=0.006) and found.broad > 0.002
    assert thin is not None and thin.broad == 0.0 < thin.area


def test_above_is_not_below_and_beside_is_neither():
    assert overlap(slab(0, 0.0), slab(0, 0.1)) is None
    assert overlap(slab(0.2, 0.1), slab(0, 0.0)) is None


def test_what_is_higher_than_the_lift_is_not_met():
    assert overlap(slab(0, 0.5), slab(0, 0.0)) is None


def test_an_edge_to_nobody_is_refused():
    with pytest.raises(UnknownObject, match="c"):
        DependencyGraph(("a", "b"), (Dependency("a", "c", "supported", 1.0),))


def test_the_surer_of_two_reasons_stays():
    edges = [Dependency("a", "b", "leaning", 0.4), Dependency("a", "b", "supported", 0.8)]
    assert DependencyGraph.of(("a", "b"), edges).dependencies == (edges[1],)


def test_cycles_and_ancestors():
    pairs = (("a", "b"), ("b", "a"), ("b", "c"))
    graph = DependencyGraph(tuple("abcd"), tuple(Dependency(x, y, "leaning", 0.5) for x, y in pairs))
    assert graph.cycles() == (("a", "b"),)
    assert graph.before("c") == {"a", "b"}
    assert graph.before("d") == frozenset()


def test_an_edge_is_believed_as_the_chance_of_its_pair():
    rng = np.random.default_rng(0)
    low, top = shapes.box("low", (0.1, 0.1, 0.06)), shapes.box("top", (0.07, 0.07, 0.05))
    table = np.column_stack([rng.uniform(-0.3, 0.3, (3000, 2)), np.zeros(3000)])
    clouds = {"low": low.surface(2000, rng), "top": top.surface(2000, rng), "table": table}
    clouds["top"][:, 2] += 0.06
    scene = Scene(clouds, fixed=["table"], up=(0, 0, 1))
    graph, chance = reason_out(Situation(scene))
    (edge,) = graph.dependencies
    assert (edge.first, edge.then, edge.reason) == ("top", "low", "supported")
    assert edge.confidence == chance["top", "low"] > 0.95
    assert chance["low", "top"] < 0.1


def _block(x: float, y: float, z: float, at: tuple[float, float, float]) -> FloatArray:
    """Corners of a box (8, 3) of three extents that stands at a place [m]."""
    return (np.indices((2, 2, 2)).reshape(3, -1).T - (0.5, 0.5, 0.0)) * (x, y, z) + at


@pytest.mark.parametrize("height", [0.02, 0.12])
@pytest.mark.parametrize("floor", [False, True])
def test_what_is_around_holds_what_stands_on_its_floor_alone(height, floor):
    sides = [_block(0.14, 0.01, height, (0.0, y, 0.0)) for y in (-0.065, 0.065)]
    sides += [_block(0.01, 0.14, height, (x, 0.0, 0.0)) for x in (-0.065, 0.065)]
    table = np.stack(np.meshgrid(np.arange(-0.3, 0.3, 0.01), np.arange(-0.3, 0.3, 0.01), 0.0), -1)
    under = [_block(0.14, 0.14, 0.005, (0.0, 0.0, 0.0))] * floor
    clouds = {
        "table": table.reshape(-1, 3),
        "frame": sample([*sides, *under], 0.003),
        "can": sample([_block(0.06, 0.06, 0.08, (0.0, 0.0, 0.0055 if floor else 0.0005))], 0.003),
    }
    found = dependencies(Scene(clouds, fixed=["table"], up=(0, 0, 1))).dependencies
    assert [(edge.first, edge.then) for edge in found] == [("can", "frame")] * floor


def test_what_a_counterweight_presses_on_through_a_plank_stays():
    parts = {
        "table": _block(0.6, 0.6, 0.02, (0.0, 0.0, -0.02)),
        "base": _block(0.06, 0.06, 0.06, (0.0, 0.0, 0.0005)),
        "plank": _block(0.24, 0.05, 0.01, (0.06, 0.0, 0.061)),
        "weight": _block(0.05, 0.05, 0.08, (-0.03, 0.0, 0.0715)),
    }
    mixed = np.random.default_rng(3).permutation  # such that the base's feet seem to tilt
    clouds = {name: mixed(sample([part], 0.001))[:2000] for name, part in parts.items()}
    scene = Scene({**clouds, "table": sample([parts["table"]], 0.012)}, ["table"], (0, 0, 1))
    assert dependencies(scene).cycles() == (("plank", "weight"),)
