"""Where everything is once a transfer is done."""

from collections.abc import Sequence

from topple.planner.placement.away import Away
from topple.planner.transfer.transfer import Transfer
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.tolerances import GRAIN
from topple.topology.geometry.samples import sample
from topple.topology.situation.situation import Situation


def after(situation: Situation, transfer: Transfer, looked_at: bool = False) -> Situation:
    """Predict the situation once a transfer is done.

    What was put down on a table rests there on its underside, which cameras will see the edge of: where its
    cloud ends above that, points of its body are added below.

    Args:
        situation: Before it.
        transfer: The transfer.
        looked_at: Whether cameras look again, and see what stands on an area that was vouched for.

    Returns:
        The situation with the object and what rides in it at its place, or without them where that is none
        of the scene; all else is where it was.
    """
    place = transfer.placement
    names = (transfer.object, *transfer.riding)
    if place.how in tuple(Away) and not (looked_at and place.how is Away.ZONE):
        return situation.without(*names)
    return rest_at(situation, names, place.pose_at_rest(situation.up), place.into is None)


def rest_at(situation: Situation, names: Sequence[str], pose: FloatArray, on_table: bool) -> Situation:
    """Predict the situation once things were moved, as `after` does.

    Args:
        situation: Before it.
        names: The object, and what rides in it.
        pose: (4, 4) rigid transform in the world to where it lies.
        on_table: Whether that is on a table.
    """
    up, name = situation.up, names[0]
    hidden = None
    if on_table:
        body = sample(situation.solids[name], 2.0 * GRAIN)
        seen_above = float((situation.scene.clouds[name] @ pose[:3, :3].T @ up).min())
        hidden = body[body @ pose[:3, :3].T @ up < seen_above]
    return situation.moved(names, pose, hidden)
