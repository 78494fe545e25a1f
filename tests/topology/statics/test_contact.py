import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.topology import InvalidInput, Scene
from topple.topology.bodies.upright import Upright
from topple.topology.statics.contact import find_contacts
from topple.topology.statics.grounds import Plane


def box(
    size: tuple[float, float, float], centre: tuple[float, float, float], count: int = 1500
) -> np.ndarray:
    """Points on the whole surface of a box."""
    rng = np.random.default_rng(3)
    points = rng.uniform(-0.5, 0.5, (count, 3))
    areas = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    axis = rng.choice(3, count, p=areas / areas.sum())
    points[np.arange(count), axis] = rng.choice([-0.5, 0.5], count)
    return points * size + centre


def table() -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-0.3, 0.3, 40), np.linspace(-0.3, 0.3, 40))
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)


def scene(**clouds: np.ndarray) -> Scene:
    return Scene({**clouds, "table": table()}, fixed=["table"], up=(0, 0, 1))


def test_a_box_on_a_box_touches_it_with_a_normal_up():
    upright = Upright.of(
        scene(low=box((0.1, 0.1, 0.05), (0, 0, 0.025)), top=box((0.06, 0.06, 0.06), (0, 0, 0.08)))
    )
    contact = next(c for c in find_contacts(upright) if {c.a, c.b} == {"low", "top"})
    assert (contact.a, contact.b) == ("low", "top")
    assert contact.normals[contact.gaps < 0.003][:, 2].mean() > 0.9
    assert abs(contact.points[:, 2].mean() - 0.05) < 0.005


def test_far_apart_means_no_contact():
    upright = Upright.of(
        scene(a=box((0.1, 0.1, 0.05), (-0.1, 0, 0.025)), b=box((0.05,) * 3, (0.1, 0, 0.025)))
    )
    assert {frozenset((c.a, c.b)) for c in find_contacts(upright)} == {
        frozenset(("a", "table")), frozenset(("b", "table")),
    }  # fmt: skip


def test_a_tilted_frame_finds_the_same_contacts():
    clouds = {
        "low": box((0.1, 0.1, 0.05), (0, 0, 0.025)),
        "top": box((0.06,) * 3, (0, 0, 0.08)),
        "table": table(),
    }
    turn = Rotation.from_rotvec([1.1, 0.4, -0.3]).as_matrix()
    tilted = Scene({n: c @ turn for n, c in clouds.items()}, fixed=["table"], up=turn[2])
    pairs = {frozenset((c.a, c.b)) for c in find_contacts(Upright.of(tilted)) if c.gaps.min() < 0.002}
    assert pairs == {frozenset(("low", "table")), frozenset(("low", "top"))}


def test_without_up_the_message_says_how_to_give_it():
    with pytest.raises(InvalidInput, match=r"up=\[0, 0, 1\]"):
        Upright.of(Scene({"a": box((0.1,) * 3, (0, 0, 0))}))


@pytest.mark.parametrize(("beyond", "touching"), [(-0.05, True), (0.035, True), (0.06, False), (2.0, False)])
def test_a_table_goes_on_a_little_beyond_what_was_seen_of_it(beyond, touching):
    """A thin bar along the edge of the table, its near side that far beyond the last point [m]."""
    bar = box((0.02, 0.2, 0.02), (0.3 + beyond + 0.01, 0, 0.01))
    found = {frozenset((c.a, c.b)) for c in find_contacts(Upright.of(scene(bar=bar)))}
    assert (frozenset(("bar", "table")) in found) is touching


@pytest.mark.parametrize(("beyond", "over"), [(0.015, True), (0.025, False), (1.0, False)])
def test_a_top_whose_edge_was_seen_ends_there(beyond, over):
    plane = Plane(np.array([0, 0, 1.0]), 0.0, np.array([-0.3, -0.3, 0]), np.array([0.3, 0.3, 0]), ends=True)
    assert plane.over(np.array([[0.3 + beyond, 0.0, 0.0]])).tolist() == [over]
