"""Campaign of adversarial actions on every environment, with all of its features drawn at random.

A trial drives one batch of worlds for a while and looks at every step; then it replays the batch,
to the bit, and drives one of its worlds alone until it touches something.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np
import numpy.typing as npt

from benchmarks.soak.drawn.features import any_environment
from benchmarks.soak.drawn.pushes import any_pushes
from benchmarks.soak.watch import Watch
from coopenv import Transport, TransportConfig
from coopenv.arrays import BoolArray, FloatArray
from coopenv.info import Info

NAME = "actions"
SHARE = 0.4
WORLD_STEPS, EPISODES = 100_000, 1_000  # about so many a trial; beginning one takes milliseconds
BY_CONIC = 600  # where that solver decomposes, which takes milliseconds as well
STEPS = 20, 400  # of a world, at least and at most
ALONE = 1e-9  # [m, rad, m/s, rad/s] by which company may change a world, by rounding


class Ride(NamedTuple):
    """One step of a batch."""

    obs: npt.NDArray[np.float32]
    reward: FloatArray
    info: Info
    again: BoolArray  # which worlds began anew before it


def trial(seed: int, folder: Path) -> dict[str, int]:
    """One batch, looked at, replayed, and one of its worlds alone."""
    rng = np.random.default_rng([1, seed])
    env, config, num_worlds = any_environment(rng)
    most = BY_CONIC if config.decomposition.solver == "conic" else WORLD_STEPS
    most = min(most, EPISODES * config.horizon)
    steps = int(np.clip(most // num_worlds, *STEPS))
    core = Transport(num_worlds=num_worlds, config=config)
    plan = any_pushes(rng, steps, (num_worlds, len(core.learners), core.action_size))
    early = rng.random((steps, num_worlds)) < rng.choice([0.0, 0.02])
    in_step = bool(rng.random() < 0.5)
    watch = Watch(core, env)
    seen, agains, poses, touched = [], [], [], []
    for ride in drive(core, seed, plan, early, in_step=in_step):
        watch.look(*ride)
        seen.append(digest(core, ride))
        agains.append(ride.again)
        poses.append((core.world.pose, core.world.twist))
        touched.append((core.world.contact_impulse != 0) | (core.world.contact_shift != 0))
    replay = Transport(num_worlds=num_worlds, config=config)
    for step, ride in enumerate(drive(replay, seed, plan, early, in_step=in_step)):
        same = digest(replay, ride)
        other = [name for name in same if same[name] != seen[step].get(name)]
        assert not other, f"{env}: a replay differs at step {step} in {', '.join(other)}"
    k = int(rng.integers(num_worlds))
    free = int(np.argmax([*(row[k] for row in touched), True]))  # steps before it touches anything
    alone = Transport(config=of_world(config, num_worlds, k))
    own = np.array(agains)[:free, k : k + 1]
    for step, _ in enumerate(drive(alone, seed + k, plan[:free, k : k + 1], own, in_step=in_step)):
        for mine, theirs in zip((alone.world.pose, alone.world.twist), poses[step], strict=True):
            off = np.abs(mine[0] - theirs[k]).max()
            assert off <= ALONE, f"{env}: world {k} alone is {off:.1e} off at step {step}"
    begun = num_worlds + int(np.sum(agains))
    return {"steps": steps * num_worlds, "replayed": steps * num_worlds, "episodes": begun}


def drive(
    core: Transport, seed: int, plan: FloatArray, early: BoolArray, *, in_step: bool
) -> Iterator[Ride]:
    """Step through ``plan``; worlds begin anew where ``early`` says so or their episode ended.

    They do so within the step or by a reset before it.
    """
    core.reset(seed=seed)
    ended = np.zeros(core.num_worlds, dtype=np.bool_)
    for action, dropped in zip(plan, early, strict=True):
        again = ended | dropped
        if again.any() and not in_step:
            core.reset(mask=again)
        restart = again if in_step else None
        obs, reward, terminated, truncated, info = core.step(action, restart=restart)
        ended = terminated | truncated
        yield Ride(obs, reward, info, again)


def of_world(config: TransportConfig, num_worlds: int, k: int) -> TransportConfig:
    """The configuration of world ``k`` alone."""
    body, scene = config.bodies(num_worlds)[k], config.scenes(num_worlds)[k]
    return replace(config, body=body, scene=scene)


def digest(core: Transport, ride: Ride) -> dict[str, int]:
    """Checksums of all that a step showed, by name."""
    shown: dict[str, npt.NDArray[Any]] = {"obs": ride.obs, "reward": ride.reward}
    shown |= {"again": ride.again, "pose": core.world.pose, "twist": core.world.twist}
    shown |= ride.info
    return {name: crc32(np.ascontiguousarray(value).data) for name, value in shown.items()}
