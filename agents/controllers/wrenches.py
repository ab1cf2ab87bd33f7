"""Refusal of actions that are no wrenches, where a policy or a partner gives wrenches."""

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput


def require_wrenches(config: TransportConfig, who: str) -> None:
    """Raise `InvalidInput` if hands carry out the actions; ``who`` gives wrenches."""
    if config.hands is not None:
        raise InvalidInput(
            f"action must be 'wrench', 'force' or 'discrete' for {who}, which gives wrenches, got "
            f"{config.action!r}; choose one of them, or coopenv.agents.controllers.MotionController"
        )
