"""Pictures of what is internal and what is not, drawn by the renderer: docs/concepts/.

python -m benchmarks.site.concepts
"""

import numpy as np

from benchmarks.pages import DOCS
from coopenv import Scene, Transport
from coopenv.render import Renderer, save_png
from coopenv.render.canvas import Picture

FOLDER = DOCS / "concepts"
# name -> force and torque of the left and of the right agent, object frame [N, N, N·m]
CASES: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "together": ((6.0, 0.0, 0.0), (6.0, 0.0, 0.0)),
    "alone": ((8.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    "against": ((9.0, 0.0, 0.0), (-3.0, 0.0, 0.0)),
    "squeeze": ((8.0, 0.0, 0.0), (-8.0, 0.0, 0.0)),
    "couple": ((0.0, -6.0, 0.0), (0.0, 6.0, 0.0)),
    "across": ((6.0, 6.0, 0.0), (6.0, -6.0, 0.0)),
}


def picture(name: str) -> Picture:
    """The beam in a small room while the two of that case push."""
    wrenches = np.array(CASES[name])
    core = Transport(scene=Scene(size=(3.0, 2.4)))
    core.reset(seed=0, pose=(0.0, 0.0, 0.0), goal=(0.0, 0.8, 0.0))
    wrenches[1, :2] *= -1  # the right agent's own axes point the other way
    action = wrenches / np.array([10.0, 10.0, 5.0])  # [N, N, N·m] an action of 1 stands for
    core.step(action[None])
    assert core.transition is not None
    renderer = Renderer(core.bodies, core.scenes, mode="rgb_array")
    drawn = renderer.draw(core.transition)
    renderer.close()
    assert drawn is not None
    return drawn


def main() -> None:
    """Draw all cases."""
    FOLDER.mkdir(exist_ok=True)
    for name in CASES:
        path = FOLDER / f"{name}.png"
        save_png(path, picture(name))
        print(path.relative_to(DOCS.parent))


if __name__ == "__main__":
    main()
