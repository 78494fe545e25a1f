"""A run as one recording of Rerun: what was seen, how the arm moved, the camera's pictures, the relations.

Everything lies on a timeline of simulated seconds, `time`; what was seen also on one of looks, `look`.
"""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from topple.planner.formats.pictures import picture, png
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.report.drawing import Drawing, DrawnObject
from topple.planner.report.limits import LIMITS
from topple.planner.report.words import order_in_words
from topple.robots.collision.convex import hull_of
from topple.topology.arrays import FloatArray
from topple.topology.errors import NotInstalled
from topple.topology.image import DepthImage
from topple.topology.scene import Scene
from topple.topology.sixim.table import Relation

if TYPE_CHECKING:
    from topple.robots.world.recording import Recording

RATE = 20.0  # samples of every pose a second of simulated time: motion is smooth, and a run stays small
ARM = (205, 208, 214)  # light grey, apart from every object's colour
MILLIMETRE = 1000.0  # steps of a stored depth image in a metre, as Kinects have it

Document = Mapping[str, Any]


@dataclass(frozen=True)
class _Moment:
    """A look: when it was taken, what it showed, what was decided from it."""

    time: float
    scene: Scene | None
    relations: Document | None
    order: Document | None
    step: StepRecord | None


def rerun_file(record: RunRecord, recording: "Recording") -> bytes:
    """Writes a run as an `.rrd` file.

    Args:
        record: The run.
        recording: Where everything was meanwhile, sampled from the first look on.

    Returns:
        The bytes of the file.

    Raises:
        NotInstalled: The library that writes it.
    """
    rr = library()
    stream = rr.RecordingStream("topple")
    stream.set_log_time_enabled(False)  # when it was written says nothing about the run
    memory = stream.memory_recording()
    stream.send_blueprint(_layout(rr))
    stream.send_recording_name(f"{record.goal}, {record.robot}, seed {record.seed}")
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    _log_motion(rr, stream, recording)
    known: set[str] = set()
    for number, moment in enumerate(_moments(record, recording.times[0])):
        stream.set_time("time", duration=moment.time)
        stream.set_time("look", sequence=number)
        if moment.scene is not None:
            _log_scene(rr, stream, moment.scene, known)
        _log_words(rr, stream, record, moment, number)
    stream.flush()
    return bytes(memory.drain_as_bytes())


def library() -> Any:
    """The library that writes recordings.

    Raises:
        NotInstalled: It is not installed.
    """
    try:
        import rerun  # an extra: only recordings need it
    except ImportError as error:
        raise NotInstalled("a recording needs the Rerun SDK", "rerun") from error
    return rerun


def _moments(record: RunRecord, begun: float) -> list[_Moment]:
    """The look before each step, and the one at the end."""
    moments: list[_Moment] = []
    time = begun
    for step in record.steps:
        moments.append(_Moment(time, step.scene, step.relations, step.order, step))
        time += step.robot_seconds or 0.0
    return [*moments, _Moment(time, record.scene, record.relations, record.order, None)]


def _log_motion(rr: Any, stream: Any, recording: "Recording") -> None:
    """Links of the arm and true bodies: shapes once, poses (4, 4) in the world over time."""
    import trimesh

    arm, world = recording.robot.arm, recording.robot.world
    times = [rr.TimeColumn("time", duration=recording.times)]
    for link, parts in zip(arm.links, arm.parts, strict=True):
        if parts:
            shape: Any = trimesh.util.concatenate([trimesh.Trimesh(*hull_of(part)) for part in parts])
            mesh = rr.Mesh3D(vertex_positions=shape.vertices, triangle_indices=shape.faces, albedo_factor=ARM)
            path = rr.new_entity_path(["world", "arm", link])
            stream.log(path, mesh, static=True)
            stream.send_columns(path, times, _transforms(rr, [sample[link] for sample in recording.links]))
    for name in world.names:
        path = rr.new_entity_path(["world", "bodies", name])
        body = world.body(name)
        vertices, triangles = body.mesh.vertices, body.mesh.faces
        colour = [round(255 * share) for share in body.color]
        mesh = rr.Mesh3D(vertex_positions=vertices, triangle_indices=triangles, albedo_factor=colour)
        stream.log(path, mesh, static=True)
        poses = [sample.get(name, world.pose(name)) for sample in recording.poses]  # what is fixed stands
        stream.send_columns(path, times, _transforms(rr, poses))


def _transforms(rr: Any, poses: Sequence[FloatArray]) -> Any:
    stacked = np.array(poses)
    return rr.Transform3D.columns(translation=stacked[:, :3, 3], mat3x3=stacked[:, :3, :3])


def _log_scene(rr: Any, stream: Any, scene: Scene, known: set[str]) -> None:
    """Clouds and hulls of one look, and what the cameras took; what is seen no more is cleared."""
    for name in known - set(scene.names):
        stream.log(rr.new_entity_path(["world", "seen", name]), rr.Clear(recursive=True))
    known |= set(scene.names)
    for thing in Drawing.of(scene, LIMITS.look_points).objects:
        _log_object(rr, stream, thing)
    for number, image in enumerate(scene.images, start=1):
        _log_camera(rr, stream, f"world/cameras/{number}", image)


def _log_object(rr: Any, stream: Any, thing: DrawnObject) -> None:
    path = rr.new_entity_path(["world", "seen", thing.name])
    points = rr.Points3D(thing.points, colors=thing.colour, radii=thing.spacing / 2)
    stream.log(f"{path}/cloud", points)
    hull = rr.LineStrips3D(thing.corners[thing.edges], colors=thing.colour, radii=rr.Radius.ui_points(1.0))
    stream.log(f"{path}/hull", hull)


def _log_camera(rr: Any, stream: Any, path: str, image: DepthImage) -> None:
    from PIL import Image

    pose = image.pose_camera_to_world
    stream.log(path, rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
    height, width = image.depth.shape
    stream.log(
        path, rr.Pinhole(image_from_camera=image.K, width=width, height=height, image_plane_distance=0.1)
    )
    if image.rgb is not None:
        stream.log(f"{path}/picture", rr.EncodedImage(contents=picture(image.rgb), media_type="image/png"))
    steps = np.round(np.nan_to_num(image.depth) * MILLIMETRE).clip(0, 65535).astype(np.uint16)
    depth = rr.EncodedDepthImage(png(Image.fromarray(steps)), media_type="image/png", meter=MILLIMETRE)
    stream.log(f"{path}/depth", depth)


def _log_words(rr: Any, stream: Any, record: RunRecord, moment: _Moment, number: int) -> None:
    """What was decided and why, the relations it was decided from, and what went wrong."""
    step = moment.step
    text = io.StringIO()
    if step is not None:
        title = f"{step.action} {step.object}"
        text.write(f"# Step {number + 1}: {title}\n\n{step.reason}\n")
        stream.log("log", rr.TextLog(f"{title}: {step.reason}", level="INFO"))
        for event in step.events:
            text.write(f"- {event}\n")
            stream.log("log", rr.TextLog(f"{step.object}: {event}", level="WARN"))
        if step.tool_path is not None:
            stream.log("world/tool_path", rr.LineStrips3D([step.tool_path], radii=rr.Radius.ui_points(1.5)))
    else:
        word = record.verdict
        text.write(f"# End: the goal is {word}\n\n")
        stream.log("log", rr.TextLog(f"{record.goal}: {word}", level="INFO"))
        for violation in record.violations:
            text.write(f"- {violation}\n")
            stream.log("log", rr.TextLog(violation, level="ERROR"))
    if moment.order is not None:
        text.write("\n## Order\n\n")
        text.writelines(f"1. **{name}** {why}\n" for name, why in order_in_words(moment.order))
    if moment.relations is not None:
        text.write("\n## Relations\n\n| a | relation | b |\n| --- | --- | --- |\n")
        text.writelines(
            f"| {pair['a']} | {pair['relation']} | {pair['b']} |\n"
            for pair in moment.relations["relations"]
            if pair["relation"] != Relation.DISJOINT
        )
    stream.log("relations", rr.TextDocument(text.getvalue(), media_type=rr.MediaType.MARKDOWN))


def _layout(rr: Any) -> Any:
    """The scene at the left; the first camera, the words and the log at the right."""
    import rerun.blueprint as layout

    views = layout.Vertical(
        layout.Spatial2DView(origin="world/cameras/1", name="camera 1"),
        layout.TextDocumentView(origin="relations", name="relations"),
        layout.TextLogView(origin="log", name="log"),
    )
    scene = layout.Spatial3DView(origin="world", name="scene")
    return layout.Blueprint(layout.Horizontal(scene, views, column_shares=[2, 1]))
