"""Plans checked again by other means than they were made with."""

from topple.planner.verify.verification import Residual, Verification
from topple.planner.verify.verify import verify

__all__ = ["Residual", "Verification", "verify"]
