"""A live page of one scene: sliders for the deviation of its relations and the steps of its order or plan."""

import io
from collections.abc import Sequence
from contextlib import redirect_stdout
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from topple.planner.planning.order import ordered
from topple.planner.planning.step import Orderer, order_by
from topple.planner.report.drawing import Drawing
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import relation_colour
from topple.planner.report.plan_page import check_scene
from topple.planner.report.view import is_inferred
from topple.topology.arrays import FloatArray
from topple.topology.errors import NotInstalled
from topple.topology.relations import relate
from topple.topology.scene import Scene
from topple.topology.sixim.table import Relation

if TYPE_CHECKING:
    from topple.planner.formats.plan_format import Plan

Moves = Sequence[tuple[str, FloatArray | None]]
"""What each step does: the object, and the rigid transform (4, 4) of it; None takes it away."""
LEAST, MOST = 0.5, 12.0  # [mm] of the deviation: below any camera's noise, and above the worst


class LivePage:
    """Serves a scene to browsers until it is closed.

    Attributes:
        relations: Of the scene at the deviation that is chosen.
        step: How many steps are done.
        moves: What each step does: the object, and the rigid transform (4, 4) of it; None takes it away.
    """

    def __init__(
        self,
        scene: Scene,
        plan: "Plan | None" = None,
        *,
        rule: str | None = None,
        orderer: Orderer | None = None,
        seed: int = 0,
        host: str = "127.0.0.1",
        port: int = 8080,
    ) -> None:
        """Relate and order the scene, and begin to serve it.

        Args:
            scene: The scene; without `up` there is no order.
            plan: What is done in it; the order, where None.
            rule: Name of what relates; topple's own where None.
            orderer: What orders; the fewest removals where None.
            seed: Of every search of the order.
            host: Which addresses may connect: this machine alone, or "0.0.0.0" for any.
            port: Where to listen, or the next that is free.

        Raises:
            NotInstalled: viser is not there.
            InvalidInput: The plan is of other objects, or there is no such rule.
        """
        viser = _viser()
        self._rule = rule
        self.scene, self.relations, self.step = scene, relate(scene, rule=rule), 0
        self.moves = _done_by(plan, scene) if plan is not None else self._taken(orderer or ordered, seed)
        self._drawing = Drawing.of(scene, LIMITS.live_points)
        with redirect_stdout(io.StringIO()):  # its banner: what is said, the caller says
            self._server: Any = viser.ViserServer(host=host, port=port, label="topple", verbose=False)
        self._host = host
        self._server.scene.set_up_direction(tuple(self._drawing.up.tolist()))
        self._objects: dict[str, list[Any]] = {}
        self._lines: list[Any] = []
        self._draw()
        self._sliders()
        self.show_step(0)
        self.show_deviation(self.relations.deviation)

    @property
    def url(self) -> str:
        """Where a browser finds the page."""
        return f"http://{'localhost' if self._host == '0.0.0.0' else self._host}:{self._server.get_port()}"

    def show_deviation(self, deviation: float) -> None:
        """Relate the scene at another deviation, and draw that.

        Args:
            deviation: The deviation factor δ [m].
        """
        if deviation != self.relations.deviation:
            self.relations = relate(self.scene, deviation, rule=self._rule)
        self._relate()

    def show_step(self, count: int) -> None:
        """Show the scene as it is after some steps.

        Args:
            count: How many are done.
        """
        self.step = min(max(count, 0), len(self.moves))
        poses: dict[str, FloatArray | None] = {name: np.eye(4) for name in self.scene.names}
        for name, move in self.moves[: self.step]:
            before = poses[name]
            poses[name] = None if move is None or before is None else move @ before
        for name, pose in poses.items():
            for handle in self._objects[name]:
                handle.visible = pose is not None
                if pose is not None:
                    handle.position, handle.wxyz = pose[:3, 3], _quaternion(pose)
        for line in self._lines:
            line.visible = self.step == 0  # relations are those of the scene that was seen
        done = [name for name, _ in self.moves[: self.step]]
        self._told.content = f"Done: {', '.join(done)}" if done else "Nothing is done yet."

    def wait(self) -> None:
        """Serve until interrupted."""
        self._server.sleep_forever()

    def close(self) -> None:
        """Stop serving."""
        with redirect_stdout(io.StringIO()):
            self._server.stop()

    def _taken(self, orderer: Orderer, seed: int) -> Moves:
        """The order that an orderer gives of the scene, each object taken away."""
        if self.scene.up is None or not self.scene.movable:
            return []
        found = order_by(orderer, self.scene, None, self.relations, seed)
        return [(name, None) for name in found.order]

    def _draw(self) -> None:
        add = self._server.scene
        for drawn in self._drawing.objects:
            points = add.add_point_cloud(
                f"/objects/{drawn.name}/surface",
                drawn.points.astype(np.float32),
                drawn.colour,
                point_size=max(drawn.spacing, 0.002),
                point_shape="circle",
                precision="float32",
            )
            self._objects[drawn.name] = [points]
            if not drawn.fixed:
                add.add_label(f"/objects/{drawn.name}/surface/name", drawn.name, position=drawn.top)

    def _sliders(self) -> None:
        gui, begun = self._server.gui, 1e3 * self.relations.deviation
        deviation = gui.add_slider("deviation [mm]", LEAST, max(MOST, begun), 0.1, round(begun, 1))
        steps = gui.add_slider("steps done", 0, max(len(self.moves), 1), 1, 0, disabled=not self.moves)
        self._told = gui.add_markdown("")
        self._table = gui.add_markdown("")
        deviation.on_update(lambda event: self.show_deviation(1e-3 * float(event.target.value)))
        steps.on_update(lambda event: self.show_step(int(event.target.value)))

    def _relate(self) -> None:
        """Lines between the objects that meet, and the table of them."""
        for line in self._lines:
            line.remove()
        centres = {drawn.name: drawn.centre for drawn in self._drawing.objects}
        meeting = [pair for pair in self.relations if pair.relation is not Relation.DISJOINT]
        self._lines = [
            self._server.scene.add_line_segments(
                f"/relations/{number}",
                np.array([[centres[pair.a], centres[pair.b]]]),
                relation_colour(pair.relation),
                thickness=1.5 if is_inferred(pair.to_json()) else 3.0,
                thickness_units="screen",
            )
            for number, pair in enumerate(meeting)
        ]
        rows = [
            f"| {_cell(p.a)} | {p.relation} | {_cell(p.b)} | {1e3 * p.gap:.1f} |"
            for p in meeting[: LIMITS.rows]
        ]
        more = f"\n\n{len(meeting) - LIMITS.rows} more" if len(meeting) > LIMITS.rows else ""
        self._table.content = "\n".join(["| a | relation | b | gap mm |", "|---|---|---|---|", *rows]) + more
        self.show_step(self.step)


def _viser() -> ModuleType:
    try:
        import viser
    except ModuleNotFoundError as error:
        raise NotInstalled("the live page needs viser", "view") from error
    return viser


def _done_by(plan: "Plan", scene: Scene) -> Moves:
    """What each step of a plan does."""
    check_scene(plan, scene)
    return [(step.object, np.array(step.placement.pose_before_to_after)) for step in plan.steps]


def _cell(name: str) -> str:
    """A name in a table of Markdown, none of it taken for markup."""
    return "".join(f"\\{letter}" if letter in "\\`*_{}[]()<>#+-.!|&$~" else letter for letter in name)


def _quaternion(pose: FloatArray) -> FloatArray:
    """The turn of a pose (4, 4) as w, x, y, z."""
    from scipy.spatial.transform import Rotation

    return np.roll(Rotation.from_matrix(pose[:3, :3]).as_quat(), 1)
