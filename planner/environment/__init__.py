"""Gymnasium environments in which to learn what to take: piles, dishes and a bowl of fruit.

Importing this registers `topple/Pile-v0`, `topple/Dishes-v0` and `topple/Lemon-v0`, as does `import topple`
after `import gymnasium`; `gymnasium.make("topple.planner.environment:topple/Pile-v0")` needs neither.
"""

from topple.topology.base.errors import NotInstalled

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
