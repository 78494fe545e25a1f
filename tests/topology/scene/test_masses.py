"""Masses and friction of a scene: refused where they cannot be true, kept wherever the scene goes."""

import copy
import json
import pickle
from pathlib import Path

import numpy as np
import pytest

from topple.topology import Scene, relate
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.io import load_scene
from topple.topology.scene.friction import friction_between
from topple.topology.scene.tolerances import FRICTION
from topple.topology.situation.situation import Situation
from topple.topology.statics.equilibrium import Weight, balance
from topple.topology.statics.rest import Statics, weigh

CUBE = np.random.default_rng(0).random((200, 3)) * 0.1
TABLE = np.random.default_rng(1).random((200, 3)) * [1, 1, 0]
CLOUDS = {"mug": CUBE + np.array([0.4, 0.4, 0]), "box": CUBE + np.array([0.1, 0.1, 0]), "table": TABLE}


def scene() -> Scene:
    return Scene(CLOUDS, ["table"], (0, 0, 1), masses={"mug": 0.35, "box": 1}, friction={"table": 0.6})


def test_a_scene_keeps_them_through_every_change():
    for same in (scene(), pickle.loads(pickle.dumps(scene())), copy.deepcopy(scene()), scene().upright()):
        assert same.masses == {"mug": 0.35, "box": 1.0}
        assert same.friction == {"table": 0.6}
    moved = scene().with_cloud("mug", CUBE).with_cloud("new", CUBE)
    assert moved.masses == scene().masses
    left = scene().without("mug").without("table")
    assert left.masses == {"box": 1.0}
    assert left.friction == {}
    again = scene().weighed({"mug": 0.4}, {"box": 0.3})
    assert again.masses == {"mug": 0.4, "box": 1.0}
    assert again.friction == {"table": 0.6, "box": 0.3}
    with pytest.raises(TypeError):
        again.masses["mug"] = 1.0  # type: ignore[index]


@pytest.mark.parametrize(
    ("masses", "says"),
    [
        ({"mug": 0}, "mass of 'mug' is 0 kg: expected more than 0"),
        ({"mug": -1.5}, "mass of 'mug' is -1.5 kg"),
        ({"mug": float("nan")}, "masses['mug'] is nan: expected number"),
        ({"mug": float("inf")}, "mass of 'mug' is not finite"),
        ({"mug": 10**400}, "mass of 'mug' is not finite"),
        ({"mug": "1"}, "masses['mug'] is '1': expected number"),
        ({"mug": True}, "masses['mug'] is True: expected number"),
        ({"mug": None}, "masses['mug'] is None: expected number"),
        ([0.1, 0.2], "masses is of <class 'list'>: expected Mapping[str, number]"),
    ],
)
def test_what_is_no_mass_is_refused_in_one_line(masses, says):
    for make in (lambda: Scene(CLOUDS, masses=masses), lambda: scene().weighed(masses)):  # type: ignore[arg-type]
        with pytest.raises(InvalidInput) as caught:
            make()
        assert says in str(caught.value)


@pytest.mark.parametrize("wrong", [-0.1, 10.5, float("nan"), "0.5"])
def test_what_is_no_friction_is_refused(wrong):
    with pytest.raises(InvalidInput, match=r"friction( of |\[)'mug'\]? is"):
        Scene(CLOUDS, friction={"mug": wrong})  # type: ignore[dict-item]


def test_names_that_are_not_there_are_refused():
    with pytest.raises(
        UnknownObject, match="unknown object with a mass 'cup': the scene has box, mug, table"
    ):
        Scene(CLOUDS, masses={"cup": 1.0})
    with pytest.raises(UnknownObject, match="unknown object with a friction 'cup'"):
        Scene(CLOUDS, friction={"cup": 0.5})


def test_two_surfaces_touch_with_the_product_of_their_coefficients():
    assert friction_between({}, "a", "b") == FRICTION
    assert friction_between({"a": 0.8, "b": 0.5}, "a", "b") == pytest.approx(0.4)
    assert friction_between({"a": 0.8}, "a", "b") == friction_between({"a": 0.8}, "b", "a")
    assert friction_between({"a": 0.8}, "a", "b") == pytest.approx(0.8 * FRICTION**0.5)


def test_a_guessed_and_a_given_weight_are_in_the_same_unit():
    grid = np.stack(np.meshgrid(*[np.linspace(0, 0.05, 14)] * 3), axis=-1).reshape(-1, 3)
    shell = grid[(np.isclose(grid, 0) | np.isclose(grid, 0.05)).any(axis=1)]
    thin = weigh(shell)
    assert thin.mass < 0.7 * 0.125 + 1e-6, "no more than 125 cm³ at 700 kg/m³"
    assert thin.mass > 0.5 * 0.7 * 0.125
    assert weigh(shell, 1.5).mass == pytest.approx(1.5)
    statics = Statics.of(
        Scene({"a": shell, "b": shell + np.array([0.2, 0, 0])}, up=(0, 0, 1), masses={"a": 2.0})
    )
    assert statics.weights["a"].mass == pytest.approx(2.0)
    assert statics.weights["b"].mass == pytest.approx(weigh(statics.surfaces["b"]).mass)


@pytest.mark.parametrize(
    ("coefficients", "holds"), [({"slope": 1.0, "body": 0.8}, True), ({"body": 0.3}, False)]
)
def test_friction_of_its_two_surfaces_decides_what_a_slope_holds(coefficients, holds):
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, 60), np.linspace(-0.2, 0.2, 60))
    flat = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    grid = np.stack(np.meshgrid(*[np.linspace(-0.03, 0.03, 16)] * 3), axis=-1).reshape(-1, 3)
    body = grid[(np.abs(np.abs(grid) - 0.03) < 1e-9).any(axis=1)] + [0, 0, 0.03]
    c, s = np.cos(np.radians(28)), np.sin(np.radians(28))
    tilt = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    clouds = {"slope": flat @ tilt.T, "body": body @ tilt.T}
    statics = Statics.of(Scene(clouds, ["slope"], (0, 0, 1), friction=coefficients))
    seen = [contact for contact in statics.contacts if not contact.inferred]
    assert (balance(statics.weights, seen).deficit["body"] < 0.01) is holds


def _files(folder: Path, described: object) -> Path:
    for name, cloud in CLOUDS.items():
        np.savetxt(folder / f"{name}.xyz", cloud)
    (folder / "scene.json").write_text(json.dumps(described))
    return folder


def test_scene_json_gives_them(tmp_path):
    told = {"fixed": ["table"], "masses": {"mug": 0.35}, "friction": {"table": 0.6, "mug": 1}}
    found = load_scene(_files(tmp_path, told))
    assert found.masses == {"mug": 0.35}
    assert found.friction == {"table": 0.6, "mug": 1.0}


@pytest.mark.parametrize(
    ("told", "says"),
    [
        ({"masses": {"cup": 1}}, "'cup'"),
        ({"masses": {"mug": "heavy"}}, "masses['mug'] is 'heavy': expected number"),
        ({"masses": [1, 2]}, "masses is of <class 'list'>"),
        ({"friction": {"mug": 30}}, "friction of 'mug' is 30"),
    ],
)
def test_a_wrong_scene_json_is_refused_with_its_name(tmp_path, told, says):
    with pytest.raises(InvalidInput) as caught:
        load_scene(_files(tmp_path, told))
    assert says in str(caught.value)
    assert str(tmp_path) in str(caught.value)


def test_an_npz_gives_them_as_json_text(tmp_path):
    path = tmp_path / "scene.npz"
    np.savez(path, **CLOUDS, masses=json.dumps({"mug": 0.35}), friction=json.dumps({"box": 0.2}))
    found = load_scene(path)
    assert found.names == ("mug", "box", "table")
    assert found.masses == {"mug": 0.35}
    assert found.friction == {"box": 0.2}


def test_an_object_may_be_called_masses(tmp_path):
    path = tmp_path / "scene.npz"
    np.savez(path, **CLOUDS, masses=CUBE)
    found = load_scene(path)
    assert "masses" in found.names
    assert found.masses == {}


@pytest.mark.parametrize(
    ("array", "says"),
    [
        (np.array([0.3, 0.2, 1.0]), "masses is an array (3,) of float64, which names no object"),
        (np.array("mug: 1"), "masses is not JSON"),
        (np.array('{"mug": 1, "mug": 2}'), "masses has the key 'mug' twice"),
    ],
)
def test_masses_of_an_npz_that_name_no_object_are_refused(tmp_path, array, says):
    path = tmp_path / "scene.npz"
    np.savez(path, **CLOUDS, masses=array)
    with pytest.raises(InvalidInput) as caught:
        load_scene(path)
    assert says in str(caught.value)


def test_an_rgbd_frame_gives_them_by_label(tmp_path):
    depth, label = np.full((20, 20), 0.8), np.ones((20, 20), dtype=np.int64)
    depth[5:12, 5:12], label[5:12, 5:12] = 0.7, 2
    path, k = tmp_path / "frame.npz", np.array([[50.0, 0, 10], [0, 50, 10], [0, 0, 1]])
    np.savez(path, depth=depth, K=k, label=label, masses='{"2": 0.8}', friction='{"1": 0.4}')
    found = load_scene(path, fixed=["1"])
    assert found.masses == {"2": 0.8}
    assert found.friction == {"1": 0.4}


def test_heavier_things_load_their_feet_more():
    grid = np.stack(np.meshgrid(*[np.linspace(0, 0.06, 16)] * 3), axis=-1).reshape(-1, 3)
    body = grid[(np.isclose(grid, 0) | np.isclose(grid, 0.06)).any(axis=1)]
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, 60), np.linspace(-0.2, 0.2, 60))
    flat = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    statics = Statics.of(Scene({"body": body, "table": flat}, ["table"], (0, 0, 1), masses={"body": 7.0}))
    loads = balance(statics.weights, statics.contacts).loads
    carried = Weight(float(sum(load.sum() for load in loads)), np.zeros(3), 0.03)
    assert carried.mass == pytest.approx(7.0)


def test_a_pair_is_carried_once_with_its_strongest_confidence():
    import topple.topology.statics.support as support
    from topple.topology.statics.contact import Contact

    rng = np.random.default_rng(2)
    low, top = rng.random((900, 3)) * [0.1, 0.1, 0.05], rng.random((900, 3)) * 0.05 + [0.02, 0.02, 0.05]
    scene = Scene({"low": low, "top": top, "table": TABLE}, ["table"], (0, 0, 1))
    whole = Statics.of(scene)
    patch = next(c for c in whole.contacts if {c.a, c.b} == {"low", "top"})
    again = Contact(patch.a, patch.b, patch.points, patch.normals, patch.gaps, patch.turns, inferred=True)
    for contacts in ((*whole.contacts, again), (again, *whole.contacts)):
        doubled = Statics(whole.upright, whole.surfaces, contacts, whole.weights, whole.unexplained)
        found = [s for s in support.supports(doubled, relate(scene)) if s.supported == "top"]
        assert [(s.supporter, s.inferred) for s in found] == [("low", False)]
    assert len(Situation(scene).supports) == 2


def test_numbers_of_any_width_are_taken():
    for kind in (np.float16, np.float32, np.float64, np.int8, int):
        assert Scene({"cube": CUBE}, masses={"cube": kind(2)}).masses == {"cube": 2.0}
