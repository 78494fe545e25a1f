"""What predicates answer of real worlds of MuJoCo and PyBullet, and of scenes: three values, physically."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from topple.predicates import Clear, In, On, Predicate, Stable, State, Supports
from topple.robots import World, shapes
from topple.topology import InvalidInput, Mesh, Scene, UnknownObject
from topple.topology.io.geometry import sampled_mesh

BOX = '<geom type="box" size="{0} {1} {2}" mass="{3}"/>'
BODY = '<body name="{0}" pos="{1}"><freejoint/>{2}</body>'
TRAY = "".join(
    f'<geom type="box" size="{size}" pos="{at}" mass="0.1"/>'
    for size, at in (
        (".1 .1 .005", "0 0 0"), (".1 .005 .03", "0 .095 .03"), (".1 .005 .03", "0 -.095 .03"),
        (".005 .1 .03", ".095 0 .03"), (".005 .1 .03", "-.095 0 .03"),
    )
)  # fmt: skip


def box(x: float, y: float, z: float, mass: float = 0.2) -> str:
    return BOX.format(x, y, z, mass)


def mujoco_world(bodies: str, more: str = "") -> tuple[Any, Any]:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><geom name="floor" type="plane" size="2 2 .1"/>{bodies}'
        f"</worldbody>{more}</mujoco>"
    )
    data = mujoco.MjData(model)
    for _ in range(1500):
        mujoco.mj_step(model, data)
    return model, data


@pytest.fixture
def client() -> Iterator[int]:
    pybullet = pytest.importorskip("pybullet")
    number = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0, 0, -9.81, physicsClientId=number)
    yield number
    pybullet.disconnect(number)


def bullet_box(
    client: int, half: tuple[float, float, float], at: tuple[float, float, float], mass: float
) -> int:
    import pybullet

    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
    return int(pybullet.createMultiBody(mass, shape, -1, at, physicsClientId=client))


def stacked() -> tuple[Any, Any]:
    """A plate with a mug with a lid; an orange in a tray on top of another; a plank that leans on a post."""
    return mujoco_world(
        BODY.format("plate", "0 0 .011", box(0.08, 0.08, 0.01))
        + BODY.format("mug", "0 0 .062", box(0.03, 0.03, 0.04))
        + BODY.format("lid", "0 0 .112", box(0.03, 0.03, 0.01, 0.02))
        + BODY.format("tray", "1 0 .006", TRAY)
        + BODY.format("low", "1 0 .032", box(0.02, 0.02, 0.02))
        + BODY.format("orange", "1 0 .073", box(0.02, 0.02, 0.015))
        + f'<body name="post" pos="-1 0 .3">{box(0.02, 0.1, 0.3)}</body>'
        + '<body name="plank" pos="-.93 0 .116" euler="0 -20 0"><freejoint/>'
        + box(0.005, 0.03, 0.12)
        + "</body>"
    )


def test_what_lies_on_what_is_told_of_a_mujoco_world_with_nested_and_leaning_things():
    world = stacked()
    told: dict[Predicate, bool | None] = {
        On("mug", "plate"): True,
        On("lid", "plate"): False,
        On("plate", "mug"): False,
        On("plate", "world"): True,
        Supports("plate", "lid"): True,
        Supports("world", "lid"): True,
        Supports("lid", "plate"): False,
        Clear("lid"): True,
        Clear("plate"): False,
        In("low", "tray"): True,
        On("orange", "low"): True,
        In("mug", "tray"): False,
        In("mug", "plate"): False,
        Clear("tray"): False,
        On("plank", "post"): False,
        On("plank", "world"): True,
        Stable("plank"): True,
        Stable("mug"): True,
        Stable("post"): True,
    }
    assert {predicate: predicate(*world) for predicate in told} == told


def test_what_is_held_over_a_plate_is_not_on_it_until_it_is_let_go():
    """A weld holds it high, then a fifth of a millimetre above the plate; then it is let go."""
    mujoco = pytest.importorskip("mujoco")
    hand = '<body name="hand" mocap="true" pos="0 0 .3"/>'
    model, data = mujoco_world(
        BODY.format("plate", "0 0 .011", box(0.08, 0.08, 0.01))
        + BODY.format("mug", "0 0 .1", box(0.03, 0.03, 0.04))
        + hand,
        '<equality><weld name="grip" body1="hand" body2="mug" relpose="0 0 -.2 1 0 0 0"/></equality>',
    )
    assert On("mug", "plate")(model, data) is False
    assert Supports("world", "mug")(model, data) is False
    assert Stable("mug")(model, data) is False
    assert Clear("plate")(model, data) is True
    data.mocap_pos[0, 2] = 0.2612  # 0.2 mm over it
    for _ in range(1500):
        mujoco.mj_step(model, data)
    assert On("mug", "plate")(model, data) is False
    data.eq_active[0] = 0
    for _ in range(1500):
        mujoco.mj_step(model, data)
    assert On("mug", "plate")(model, data) is True
    assert Stable("mug")(model, data) is True


def test_what_slides_is_not_told_and_what_rides_on_a_moving_tray_is_on_it(client):
    import pybullet

    floor = bullet_box(client, (5, 5, 0.1), (0, 0, -0.1), 0.0)
    tray = bullet_box(client, (0.2, 0.2, 0.01), (0, 0, 0.01), 1.0)
    load = bullet_box(client, (0.03, 0.03, 0.03), (0, 0, 0.05), 0.3)
    pybullet.changeDynamics(floor, -1, lateralFriction=0.0, physicsClientId=client)
    names = {n: f"body_{n}" for n in (floor, tray, load)}

    def step(count: int) -> None:
        for _ in range(count):
            pybullet.stepSimulation(physicsClientId=client)

    on = On(names[load], names[tray])
    assert on(client) is False or on(client) is None  # before a step no force is known
    step(240)
    assert on(client) is True
    assert Stable(names[load])(client) is True
    for body in (tray, load):
        pybullet.resetBaseVelocity(body, [0.5, 0, 0], physicsClientId=client)
    step(20)
    assert on(client) is True
    assert Stable(names[load])(client) is False
    assert On(names[tray], names[floor])(client) is None
    pybullet.resetBaseVelocity(load, [0, 0.6, 0], physicsClientId=client)
    step(2)
    assert on(client) is None
    pybullet.resetBasePositionAndOrientation(load, [0, 0, 0.4], [0, 0, 0, 1], physicsClientId=client)
    step(5)
    assert on(client) is False
    pybullet.setGravity(0, 0, 0, physicsClientId=client)
    assert On(names[tray], names[floor])(client) is None


def test_worlds_of_topple_and_scenes_answer_alike():
    with World() as world:
        world.add_table(size=(1.0, 1.0))
        at = np.eye(4)
        world.add(shapes.bowl("bowl"), at)
        at[:3, 3] = 0, 0, 0.06
        world.add(shapes.ball("orange", diameter=0.05), at)
        world.settle(4.0)
        assert In("orange", "bowl")(world) is True
        assert On("orange", "bowl")(world) is True
        assert Supports("table", "orange")(world) is True
        assert Clear("bowl")(world) is False
        assert Stable("bowl")(world) is True


def test_scenes_say_what_statics_says_and_not_what_no_camera_saw():
    def block(size: tuple[float, float, float], at: tuple[float, float, float]) -> Mesh:
        corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
        from topple.robots.collision.convex import hull_of

        return Mesh(corners * size + np.array(at), hull_of(corners)[1])

    meshes = {
        "table": block((1, 1, 0.04), (0, 0, -0.02)),
        "book": block((0.2, 0.15, 0.03), (0, 0, 0.015)),
        "mug": block((0.06, 0.06, 0.1), (0, 0, 0.08)),
        "high": block((0.06, 0.06, 0.05), (0.3, 0, 0.1)),
        "sunk": block((0.06, 0.06, 0.05), (-0.3, 0, 0.02)),
    }
    clouds = {name: sampled_mesh(mesh.vertices, mesh.faces) for name, mesh in meshes.items()}
    scene = Scene(clouds, ["table"], (0, 0, 1), meshes=meshes)
    assert On("mug", "book")(scene) is True
    assert Supports("table", "mug")(scene) is True
    assert Stable("mug")(scene) is True
    assert Stable("high")(scene) is False
    assert On("high", "table")(scene) is False
    assert On("sunk", "table")(scene) is None
    with pytest.raises(UnknownObject, match="cup"):
        On("cup", "book")(scene)
    with pytest.raises(InvalidInput, match=r"expected a mujoco\.MjModel"):
        On("mug", "book")("scene.npz")


def test_piles_of_twenty_bodies_are_answered_in_both_simulators(client):
    import pybullet

    bullet_box(client, (1, 1, 0.1), (0, 0, -0.1), 0.0)
    for k in range(20):
        bullet_box(client, (0.03, 0.03, 0.02), (0.1 * (k // 4), 0, 0.02 + 0.04 * (k % 4)), 0.2)
    for _ in range(120):
        pybullet.stepSimulation(physicsClientId=client)
    piles = "".join(
        BODY.format(f"b{k}", f"{0.1 * (k // 4)} 0 {0.02 + 0.04 * (k % 4)}", box(0.03, 0.03, 0.02))
        for k in range(20)
    )
    for names, world in ((("body_2", "body_1"), (client,)), (("b1", "b0"), mujoco_world(piles))):
        said = (On(*names), In(*names), Supports(*names[::-1]), Clear(names[1]), Stable(names[0]))
        assert [predicate(*world) for predicate in said] == [True, False, True, False, True]
    state = State.of(client)
    assert On("body_2", "body_1")(state) is True
