"""A plan as a behaviour tree: BehaviorTree.CPP, version 4."""

import xml.etree.ElementTree as ElementTree

from topple.planner.formats.plan_structs import Step
from topple.planner.placement.away import IN_HAND
from topple.planner.planning.plan_format import Plan
from topple.planner.transfer.segments import Segment

_WAY, _HAND = ("step", "segment", "holding"), ("object", "tool", "opening", "cup_extension")
ACTIONS = {
    **dict.fromkeys(("move", "approach", "lift", "transfer", "place", "retreat"), ("FollowTrajectory", _WAY)),
    "grasp": ("Grasp", _HAND),
    "release": ("Release", _HAND),
}
"""Per kind of segment the action node and its input ports; trajectories are looked up in plan.json."""
HAND_ON = "HandOn", ("object", "how")
"""What a skill of one's own does with what a step leaves in the hand."""


def behavior_tree(plan: Plan) -> str:
    """Write the tree: a sequence of steps, each a sequence of actions.

    Args:
        plan: The plan.

    Returns:
        XML with a model of the action nodes, so that editors can open it.
    """
    root = ElementTree.Element("root", BTCPP_format="4", main_tree_to_execute="Plan")
    tree = ElementTree.SubElement(root, "BehaviorTree", ID="Plan")
    sequence = ElementTree.SubElement(tree, "Sequence", name=plan.goal)
    for number, step in enumerate(plan.steps):
        branch = ElementTree.SubElement(sequence, "Sequence", name=f"{step.action} {step.object}")
        for index, segment in enumerate(step.segments):
            _action(branch, number, index, step, segment)
        if step.placement.how in IN_HAND:
            told = {"object": step.object, "how": step.placement.how}
            ElementTree.SubElement(branch, "Action", told, ID=HAND_ON[0], name=f"hand on {step.object}")
    model = ElementTree.SubElement(root, "TreeNodesModel")
    for identifier, ports in dict((*ACTIONS.values(), HAND_ON)).items():
        node = ElementTree.SubElement(model, "Action", ID=identifier)
        for port in ports:
            ElementTree.SubElement(node, "input_port", name=port)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _action(branch: ElementTree.Element, number: int, index: int, step: Step, segment: Segment) -> None:
    identifier, ports = ACTIONS[segment.kind]
    values = {
        "step": str(number),
        "segment": str(index),
        "holding": segment.holding or "",
        "object": step.object,
        "tool": segment.tool,
        "opening": f"{segment.hand.opening:g}",
        "cup_extension": f"{segment.hand.cup_extension:g}",
    }
    node = ElementTree.SubElement(branch, "Action", ID=identifier, name=f"{segment.kind} {step.object}")
    for port in ports:
        node.set(port, values[port])
