"""Cartons and a can into a tray, flat ones first: a built-in scene with one call.

python examples/pack.py [FOLDER [SEED]]
"""

import sys

from topple.planner import demo


def main(folder: str = "pack", seed: str = "0") -> int:
    """Play it, leave relations, order, plan, run and page in a folder, and tell where everything went."""
    record = demo("pack", seed=int(seed), folder=folder)
    for step in record.steps:
        moved = {name: f"{1e3 * way:.1f} mm" for name, (way, _) in step.disturbed.items() if way > 1e-3}
        print(f"{step.action} {step.object}: {step.reason}; moved besides: {moved or 'nothing'}")
    print("success" if record.success else "; ".join(record.violations))
    return 0 if record.success else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
