"""A live page of one scene: sliders for the deviation of its relations and the steps of its order or plan."""

import io
from collections.abc import Sequence
from contextlib import redirect_stdout
from functools import partial
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.planner.planning.order import ordered
from topple.planner.planning.step import Orderer, order_by
from topple.planner.report.drawing import Drawing, DrawnObject, is_inferred
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import relation_colour
from topple.planner.report.plan_page import check_scene
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import NotInstalled
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

if TYPE_CHECKING:
    from topple.planner.planning.plan_format import Plan

Moves = Sequence[tuple[str, FloatArray | None]]
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
        self._rule, self._host = rule, host
        self.scene, self.relations, self.step = scene, relate(scene, rule=rule), 0
        self.moves: Moves = []
        if plan is not None:
            check_scene(plan, scene)
            self.moves = [(step.object, np.array(step.placement.pose_before_to_after)) for step in plan.steps]
        elif scene.up is not None and scene.movable:
            self.moves = [(n, None) for n in order_by(orderer, scene, None, self.relations, seed).order]
        self._drawing = Drawing.of(scene, LIMITS.live_points)
        with redirect_stdout(io.StringIO()):  # its banner: what is said, the caller says
            self._server: Any = viser.ViserServer(host=host, port=port, label="topple", verbose=False)
        self._server.scene.set_up_direction(tuple(self._drawing.up.tolist()))
        self._objects = {drawn.name: self._drawn(drawn) for drawn in self._drawing.objects}
        self._lines: list[Any] = []
        gui, begun = self._server.gui, 1e3 * self.relations.deviation
        deviation = gui.add_slider("deviation [mm]", LEAST, max(MOST, begun), 0.1, round(begun, 1))
        steps = gui.add_slider("steps done", 0, max(len(self.moves), 1), 1, 0, disabled=not self.moves)
        self._told, self._table = gui.add_markdown(""), gui.add_markdown("")
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
        rows = [f"| {_cell(p.a)} | {p.relation} | {_cell(p.b)} | {1e3 * p.gap:.1f} |" for p in meeting]
        more = f"\n\n{len(rows) - LIMITS.rows} more" if len(rows) > LIMITS.rows else ""
        head = ["| a | relation | b | gap mm |", "|---|---|---|---|"]
        self._table.content = "\n".join([*head, *rows[: LIMITS.rows]]) + more
        self.show_step(self.step)

    def show_step(self, count: int) -> None:
        """Show the scene as it is after some steps."""
        self.step = min(max(count, 0), len(self.moves))
        poses: dict[str, FloatArray | None] = {name: np.eye(4) for name in self.scene.names}
        for name, move in self.moves[: self.step]:
            before = poses[name]
            poses[name] = None if move is None or before is None else move @ before
        for name, pose in poses.items():
            for handle in self._objects[name]:
                handle.visible = pose is not None
                if pose is not None:
                    turn = Rotation.from_matrix(pose[:3, :3]).as_quat()
                    handle.position, handle.wxyz = pose[:3, 3], np.roll(turn, 1)
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

    def _drawn(self, drawn: DrawnObject) -> list[Any]:
        place, size = f"/objects/{drawn.name}/surface", max(drawn.spacing, 0.002)
        how: Any = {"point_size": size, "point_shape": "circle", "precision": "float32"}
        cloud = drawn.points.astype(np.float32)
        points = self._server.scene.add_point_cloud(place, cloud, drawn.colour, **how)
        if not drawn.fixed:
            self._server.scene.add_label(f"{place}/name", drawn.name, position=drawn.top)
        return [points]


def _viser() -> ModuleType:
    try:
        import viser
    except ModuleNotFoundError as error:
        raise NotInstalled("the live page needs viser", "view") from error
    return viser


def _cell(name: str) -> str:
    """A name in a table of Markdown, none of it taken for markup."""
    return "".join(f"\\{letter}" if letter in "\\`*_{}[]()<>#+-.!|&$~" else letter for letter in name)
