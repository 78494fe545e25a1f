"""`python -m topple`, where this file is installed as `topple/__main__.py`: the `topple` command."""

import sys

from topple.planner.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
