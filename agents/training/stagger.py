"""Staggered episodes: worlds that begin together are brought out of step."""

import numpy as np

from ..vec_env import TransportVecEnv

CLOCKS = "episodes"  # part of a snapshot: how far each world's episode is


def stagger(venv: TransportVecEnv) -> None:
    """Let the episodes under way count as begun at different times, evenly over the horizon.

    Worlds that all begin at once run out of time at once as well, for as long as hardly any
    succeeds. Where an episode lasts for many rollouts, each update then sees one part of it alone:
    nothing but ways, later nothing but goals. Only the episodes under way are cut shorter; those
    that follow last as long as ever.

    Parameters
    ----------
    venv
        Reset, so that every world has just begun.
    """
    state = venv.get_state()
    worlds, horizon = len(state), venv.transport.config.horizon
    clocks = {**state.parts[CLOCKS], "steps": np.arange(worlds) * horizon // worlds}
    venv.set_state(state.with_part(CLOCKS, clocks))
