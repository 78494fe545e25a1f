"""Gymnasium environments: `topple/Pile-v0`, `topple/Dishes-v0`, `topple/Lemon-v0`, once this is imported.

`gymnasium.make("topple.planner.environment:topple/Pile-v0")` imports it.
"""

from topple.topology.errors import NotInstalled

try:
    import gymnasium
except ModuleNotFoundError as error:
    raise NotInstalled("environments need Gymnasium", "gym") from error

for _name in ("pile", "dishes", "lemon"):
    gymnasium.register(
        f"topple/{_name.capitalize()}-v0",
        entry_point="topple.planner.environment.picking:Picking",
        kwargs={"scenario": _name},
    )
