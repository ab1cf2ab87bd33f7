"""Pictures of environments for docs: moments of one episode of the scripted controller.

python -m benchmarks.pictures                      # draws every id, into docs/tasks/
python -m benchmarks.pictures coopenv/BeamLift-v0  # or these
"""

import sys

import gymnasium
import numpy as np

from benchmarks.pages import DOCS
from coopenv.agents.controllers import find_controller
from coopenv.agents.record import episode_steps
from coopenv.envs.registry import PREFIX, find_config
from coopenv.render import Renderer, save_png
from coopenv.render.canvas import Picture

WIDTH = 400  # [px] of a moment; what is written below it is still read where two take 600
MOMENTS = (0.05, 0.3, 0.55, 1.0)  # parts of the episode, in reading order


def strip(name: str) -> Picture:
    """Moments of the first held-out episode, two beside each other and two below."""
    config = find_config(name, {})
    steps = episode_steps(find_controller(config), config)
    conditions = steps[0].conditions
    renderer = Renderer(conditions.bodies, conditions.scenes, width=WIDTH)
    chosen = [renderer.picture(steps[round(part * (len(steps) - 1))]) for part in MOMENTS]
    return np.concatenate([np.concatenate(pair, axis=1) for pair in (chosen[:2], chosen[2:])])


def main() -> None:
    """Draw the ids of the command line."""
    folder = DOCS / "tasks"
    folder.mkdir(exist_ok=True)
    for name in sys.argv[1:] or [name for name in gymnasium.registry if name.startswith(PREFIX)]:
        path = folder / f"{name.removeprefix(PREFIX).partition('-')[0]}.png"
        save_png(path, strip(name))
        print(path)


if __name__ == "__main__":
    main()
