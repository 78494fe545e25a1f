"""A live page of one scene: its relations at any deviation, its order or plan played, a reason at a click."""

import io
import time
from collections.abc import Sequence
from contextlib import redirect_stdout
from functools import partial
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.planner.decide.names import spoken, spoken_names
from topple.planner.decide.words import order_rows, sentence
from topple.planner.formats.plan_robot import arm_from
from topple.planner.planning.order import ordered
from topple.planner.planning.step import Orderer, order_by
from topple.planner.report.drawing import Drawing, DrawnObject, is_inferred, outline
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import relation_colour
from topple.planner.report.plan_page import check_scene, plan_motion
from topple.robots.arm.visuals import visuals
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import NotInstalled
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

if TYPE_CHECKING:
    from topple.planner.planning.plan_format import Plan

Moves = Sequence[tuple[str, FloatArray | None]]
LEAST, MOST = 0.5, 12.0  # [mm] of the deviation: below any camera's noise, and above the worst
PACE = {"seconds": 0.1, "steps done": 1.0}  # [s] from one picture to the next as motions or steps are played


class LivePage:
    """Serves a scene to browsers until it is closed.

    Attributes:
        relations: Of the scene at the deviation that is chosen.
        step: How many steps are done.
        moves: What each step does: the object, and the rigid transform (4, 4) of it; None takes it away.
        reasons: Object -> why it goes when it does, in a sentence.
    """

    def __init__(
        self,
        scene: Scene,
        plan: "Plan | None" = None,
        *,
        rule: str | None = None,
        orderer: Orderer = ordered,
        seed: int = 0,
        host: str = "127.0.0.1",
        port: int = 8080,
    ) -> None:
        """Relate and order the scene, and begin to serve it.

        Args:
            scene: The scene; without `up` there is no order.
            plan: What is done in it; the order, where None.
            rule: Name of what relates; topple's own where None.
            orderer: What orders; the fewest removals where not given.
            seed: Of every search of the order.
            host: Which addresses may connect: this machine alone, or "0.0.0.0" for any.
            port: Where to listen, or the next that is free.

        Raises:
            NotInstalled: viser is not there.
            InvalidInput: The plan is of other objects, or there is no such rule.
        """
        viser = _viser()
        self._rule, self._host, self._names = rule, host, spoken_names(scene)
        self.scene, self.relations, self.step = scene, relate(scene, rule=rule), 0
        self.moves: Moves = []
        self.reasons: dict[str, str] = {}
        self._motion, self._arm, self._playing = None, list[tuple[int, Any]](), False
        if plan is not None:
            check_scene(plan, scene)
            self.moves = [(step.object, np.array(step.placement.pose_before_to_after)) for step in plan.steps]
            self.reasons = {step.object: sentence(spoken(scene, step.reason)) for step in plan.steps}
        elif scene.up is not None and scene.movable:
            found = order_by(orderer, scene, None, self.relations, seed)
            self.moves = [(name, None) for name in found.order]
            told = order_rows(spoken(scene, found.to_json()))
            self.reasons = {name: row[2] for name, row in zip(found.order, told, strict=True)}
        self._drawing = Drawing.of(scene, LIMITS.live_points)
        with redirect_stdout(io.StringIO()):  # its banner: what is said, the caller says
            self._server: Any = viser.ViserServer(host=host, port=port, label="topple", verbose=False)
        self._server.scene.set_up_direction(tuple(self._drawing.up.tolist()))
        self._server.on_client_connect(self._frame)
        self._objects = {drawn.name: self._draw(drawn) for drawn in self._drawing.objects}
        if plan is not None and plan.arm is not None:
            arm = arm_from(plan.arm, plan.robot)
            self._motion = plan_motion(plan, arm)
            add = self._server.scene.add_mesh_simple
            self._arm = [
                (link, add(f"/arm/{link}/{number}", part.vertices, part.faces, color=part.colour))
                for link, parts in enumerate(visuals(arm, LIMITS.arm_triangles) if self._motion else [])
                for number, part in enumerate(parts)
            ]
        self._lines: list[Any] = []
        gui, begun = self._server.gui, 1e3 * self.relations.deviation
        deviation = gui.add_slider("deviation [mm]", LEAST, max(MOST, begun), 0.1, round(begun, 1))
        self._steps = steps = gui.add_slider(
            "steps done", 0, max(len(self.moves), 1), 1, 0, disabled=not self.moves
        )
        played = steps
        if self._motion is not None:
            played = gui.add_slider(
                "seconds", 0.0, round(float(self._motion.times[-1]), 1), PACE["seconds"], 0.0
            )
            played.on_update(lambda event: self.show_time(float(event.target.value)))
        gui.add_button("play", disabled=not self.moves).on_click(lambda _: self.play(played))
        self._told, self._why, self._table = (gui.add_markdown("") for _ in range(3))
        self._why.content = "Click an object: why it goes when it does."
        deviation.on_update(lambda event: self.show_deviation(1e-3 * float(event.target.value)))
        steps.on_update(lambda event: self.show_step(int(event.target.value)))
        self.show_deviation(self.relations.deviation)

    @property
    def url(self) -> str:
        """Where a browser finds the page."""
        return f"http://{'localhost' if self._host == '0.0.0.0' else self._host}:{self._server.get_port()}"

    def show_deviation(self, deviation: float) -> None:
        """Relate the scene at another deviation δ [m], and draw lines between what meets, and their table."""
        if deviation != self.relations.deviation:
            self.relations = relate(self.scene, deviation, rule=self._rule)
        for line in self._lines:
            line.remove()
        centres = {drawn.name: drawn.centre for drawn in self._drawing.objects}
        meeting = [pair for pair in self.relations if pair.relation is not Relation.DISJOINT]
        draw = partial(self._server.scene.add_line_segments, thickness_units="screen")
        self._lines = [
            draw(f"/relations/{number}", ends, relation_colour(pair.relation), thickness=thick)
            for number, pair in enumerate(meeting)
            for ends in [np.array([[centres[pair.a], centres[pair.b]]])]
            for thick in [1.5 if is_inferred(pair.to_json()) else 3.0]
        ]
        named = [(self._cell(pair.a), pair, self._cell(pair.b)) for pair in meeting]
        rows = [f"| {a} | {pair.relation} | {b} | {1e3 * pair.gap:.1f} |" for a, pair, b in named]
        more = f"\n\n{len(rows) - LIMITS.rows} more" if len(rows) > LIMITS.rows else ""
        head = ["| a | relation | b | gap mm |", "|---|---|---|---|"]
        self._table.content = "\n".join([*head, *rows[: LIMITS.rows]]) + more
        self.show_step(self.step)

    def show_step(self, count: int) -> None:
        """Show the scene, and the arm where there is a plan, as it is after some steps."""
        self.step = min(max(count, 0), len(self.moves))
        poses: dict[str, FloatArray | None] = {name: np.eye(4) for name in self.scene.names}
        for name, move in self.moves[: self.step]:
            before = poses[name]
            poses[name] = None if move is None or before is None else move @ before
        ends = () if self._motion is None else (0, *self._motion.ends)
        self._show(poses, ends[self.step] if ends else 0)
        done = [self._names.get(name, name) for name, _ in self.moves[: self.step]]
        self._told.content = f"Done: {', '.join(done)}" if done else "Nothing is done yet."

    def show_time(self, seconds: float) -> None:
        """Show arm and objects as they are at a time of the plan's motion [s]."""
        assert self._motion is not None
        at = int(np.argmin(np.abs(self._motion.times - seconds)))
        moved = {name: carried[at] for name, carried in self._motion.carried.items()}
        self._show({name: moved.get(name, np.eye(4)) for name in self.scene.names}, at)
        self._told.content = f"{seconds:.1f} s: {self._motion.kinds[at]}"

    def play(self, slider: Any) -> None:
        """Move a slider on to its end, from its start where it is there; called meanwhile, stop it."""
        self._playing, pace = not self._playing, PACE[slider.label]
        if slider.value >= slider.max:
            slider.value = slider.min
        while self._playing and slider.value < slider.max:
            time.sleep(pace)
            slider.value = min(round(slider.value + pace, 1), slider.max)
        self._playing = False

    def show_reason(self, name: str) -> None:
        """Say of an object why it goes when it does."""
        self._why.content = f"**{self._cell(name)}**: {self.reasons.get(name, 'it stays where it is.')}"

    def wait(self) -> None:
        """Serve until interrupted."""
        self._server.sleep_forever()

    def close(self) -> None:
        """Stop serving."""
        self._playing = False
        with redirect_stdout(io.StringIO()):
            self._server.stop()

    def _show(self, poses: dict[str, FloatArray | None], frame: int) -> None:
        """Put objects where they are, none where they are gone, and the arm's links to a key frame."""
        for name, pose in poses.items():
            self._objects[name].visible = pose is not None
            if pose is not None:
                _set_pose(self._objects[name], pose)
        if (motion := self._motion) is not None:
            for link, handle in self._arm:
                _set_pose(handle, motion.links[frame, link])
        for line in self._lines:  # relations are those of the scene that was seen
            line.visible = all(
                pose is not None and np.array_equal(pose, np.eye(4)) for pose in poses.values()
            )

    def _frame(self, client: Any) -> None:
        """Look at the objects."""
        view, camera = self._drawing, client.camera
        camera.up_direction = view.up
        camera.position, camera.look_at = (view.eye + view.centre) / 2, view.centre  # its field is wide

    def _draw(self, drawn: DrawnObject) -> Any:
        place, size, scene = f"/objects/{drawn.name}", max(drawn.spacing, 0.002), self._server.scene
        frame = scene.add_frame(place, show_axes=False)
        how: Any = {"point_size": size, "point_shape": "circle", "precision": "float32"}
        scene.add_point_cloud(f"{place}/surface", drawn.points.astype(np.float32), drawn.paint, **how)
        if not drawn.fixed:
            scene.add_label(f"{place}/name", self._names.get(drawn.name, drawn.name), position=drawn.top)
            body = scene.add_mesh_simple(
                f"{place}/body", *outline(drawn.points), opacity=0.0, cast_shadow=False
            )
            body.on_click(lambda _: self.show_reason(drawn.name))
        return frame

    def _cell(self, name: str) -> str:
        """How an object is called, as Markdown that takes none of it for markup."""
        said = self._names.get(name, name)
        return "".join(f"\\{letter}" if letter in "\\`*_{}[]()<>#+-.!|&$~" else letter for letter in said)


def _set_pose(handle: Any, pose: FloatArray) -> None:
    handle.position = pose[:3, 3]
    handle.wxyz = np.roll(Rotation.from_matrix(pose[:3, :3]).as_quat(), 1)


def _viser() -> ModuleType:
    try:
        import viser
    except ModuleNotFoundError as error:
        raise NotInstalled("the live page needs viser", "view") from error
    return viser
