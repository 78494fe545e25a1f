"""A plate under cutlery, played from the first look to the report with one call.

    python examples/dishes.py [FOLDER] [SEED]

FOLDER then holds relations.json, order.json, plan.json, run.json and report.html, the steps as a page.
"""

import math
import sys

from topple.planner import demo


def main(folder: str = "topple-dishes", seed: str | None = None) -> int:
    """Play the scene and say what each action did to everything it was not about."""
    record = demo("dishes", seed=None if seed is None else int(seed), folder=folder)
    for number, step in enumerate(record.steps, start=1):
        moved = max((way for way, _ in step.disturbed.values()), default=0.0)
        tipped = max(step.tilts.values(), default=0.0)
        print(f"{number}. {step.action} {step.object}: {step.reason}")
        print(f"   others moved at most {1e3 * moved:.1f} mm and tipped {math.degrees(tipped):.1f} degrees")
        if step.slip is not None:
            print(f"   it slipped by {1e3 * step.slip[0]:.1f} mm in the hand")
    print(f"{record.goal}: {record.verdict}", *record.violations, sep="\n  ")
    return 0 if record.success else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
