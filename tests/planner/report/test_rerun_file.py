"""A recording for the Rerun viewer holds what was seen, done and said, and is read back."""

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from topple.planner.formats.run_record import RunRecord
from topple.planner.report.rerun_file import RATE, rerun_file
from topple.robots.catalog import robot
from topple.robots.poses import inverse
from topple.robots.shapes import box
from topple.robots.world.recording import Recording
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World

rerun = pytest.importorskip("rerun", reason="recordings need the Rerun SDK (dev extra)")
chunks = pytest.importorskip("rerun.chunk", reason="an older Rerun SDK reads recordings otherwise")

Columns = dict[str, dict[str, list[object]]]


@pytest.fixture
def recording() -> Iterator[Recording]:
    """A box on a table, and an arm that turns by its first joint."""
    with World() as world:
        world.add_table()
        world.add(box("box", (0.1, 0.1, 0.1)), np.eye(4))
        arm = SimulatedArm(world, robot("panda"), np.eye(4))
        recording = Recording(arm, RATE)
        arm.q_target = np.add(arm.q_target, [0.8, 0, 0, 0, 0, 0, 0])
        arm.wait(1.0)
        recording.stop()
        yield recording


def _read(data: bytes, path: Path) -> Columns:
    """Entity -> component -> values of all its rows."""
    path.write_bytes(data)
    found: Columns = defaultdict(lambda: defaultdict(list))
    for chunk in chunks.RrdReader(str(path)).stream().to_chunks():
        batch = chunk.to_record_batch()
        for name in filter(lambda name: ":" in name, batch.schema.names):
            found[chunk.entity_path][name] += batch.column(name).to_pylist()
    return found


def test_a_recording_is_read_back(run_record: RunRecord, recording: Recording, tmp_path: Path) -> None:
    found = _read(rerun_file(run_record, recording), tmp_path / "out.rrd")
    samples = len(recording.times)
    assert samples >= RATE
    for link in ("panda_link0", "panda_hand", "panda_leftfinger"):
        assert len(found[f"/world/arm/{link}"]["Transform3D:translation"]) == samples
        assert len(found[f"/world/arm/{link}"]["Mesh3D:vertex_positions"]) == 1
    last = found["/world/arm/panda_hand"]["Transform3D:translation"][-1][0]
    assert np.allclose(last, recording.links[-1]["panda_hand"][:3, 3], atol=1e-5)
    assert not np.allclose(last, found["/world/arm/panda_hand"]["Transform3D:translation"][0][0], atol=0.1)
    assert len(found["/world/bodies/box"]["Transform3D:mat3x3"]) == samples
    looks = sum(step.scene is not None for step in run_record.steps) + (run_record.scene is not None)
    for name in run_record.steps[0].scene.names:
        seen = rerun.new_entity_path(["world", "seen", name])
        assert len(found[f"{seen}/cloud"]["Points3D:positions"]) >= 1
        assert len(found[f"{seen}/hull"]["LineStrips3D:strips"]) >= 1
    assert len(found["/relations"]["TextDocument:text"]) == len(run_record.steps) + 1 >= looks
    said = [str(line[0]) for line in found["/log"]["TextLog:text"]]
    assert any(run_record.violations[0] in line for line in said)
    assert any(run_record.steps[0].reason in line for line in said)


def test_links_stand_as_the_kinematics_say(recording: Recording) -> None:
    arm, base = recording.robot.arm, inverse(recording.robot.pose_base_to_world)
    (expected,) = arm.forward(recording.robot.q)
    for link in ("panda_link0", "panda_link4", "panda_hand"):
        pose = base @ recording.links[-1][link]
        assert np.allclose(pose, expected[arm.links.index(link)], atol=5e-3)
