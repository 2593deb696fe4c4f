"""From bare triangles to the exact surfaces that they stand for."""

from models.recovery.recover import Recovered, RecoveryOptions, recover

__all__ = ["Recovered", "RecoveryOptions", "recover"]
