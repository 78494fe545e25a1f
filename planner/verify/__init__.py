"""Plans checked again by other means than they were made with; the package itself is called as `verify`."""

import sys
from types import ModuleType
from typing import Any

from topple.planner.verify.verification import Residual, Verification
from topple.planner.verify.verify import verify

__all__ = ["Residual", "Verification", "verify"]


class _Verify(ModuleType):
    """`topple.planner.verify` names the package and the function: calling the one is calling the other."""

    def __call__(self, *args: Any, **more: Any) -> Verification:
        return verify(*args, **more)


sys.modules[__name__].__class__ = _Verify
