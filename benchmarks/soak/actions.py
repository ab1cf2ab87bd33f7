"""Campaign of adversarial actions on every environment, with all of its features drawn at random.

A trial drives one batch of worlds for a while and looks at every step; then it replays the first
steps, to the bit, and drives one of its worlds alone until it touches something.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np
import numpy.typing as npt

from benchmarks.soak.alone import check_alone, growth
from benchmarks.soak.drawn.features import any_environment
from benchmarks.soak.drawn.pushes import any_actions
from benchmarks.soak.watch import Watch
from coopenv import Transport, TransportConfig
from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.errors import BodyLost
from coopenv.info import Info

NAME = "actions"
SHARE = 0.4
WORLD_STEPS, EPISODES = 400_000, 1_000  # about so many a trial; beginning one takes milliseconds
BY_CONIC = 600  # where that solver decomposes, which takes milliseconds as well
STEPS, REPLAYED = (20, 1_000), 150  # of a world, at least and at most; the first are replayed
MANY = 64  # worlds at least, in half of the trials


class Ride(NamedTuple):
    """One step of a batch."""

    obs: npt.NDArray[np.float32]
    reward: FloatArray
    info: Info
    again: BoolArray  # which worlds began anew before it


def trial(seed: int, folder: Path) -> dict[str, int]:
    """One batch, looked at, its beginning replayed, and one of its worlds alone."""
    rng = np.random.default_rng([1, seed])
    env, config, num_worlds = any_environment(rng, fewest_worlds=int(rng.choice([1, MANY])))
    most = BY_CONIC if config.decomposition.solver == "conic" else WORLD_STEPS
    steps = int(np.clip(most // num_worlds, *STEPS))
    core = Transport(num_worlds=num_worlds, config=config)
    plan = any_actions(rng, core, steps)
    early = rng.random((steps, num_worlds)) < rng.choice([0.0, 0.002, 0.02])
    in_step = bool(rng.random() < 0.5)
    watch = Watch(core, env)
    seen, agains, poses, touched, begun = [], [], [], [], num_worlds
    for ride in held(drive(core, seed, plan, early, in_step=in_step), watch):
        watch.look(*ride)
        if len(seen) < REPLAYED:
            seen.append(digest(core, ride))
        agains.append(ride.again)
        poses.append((core.world.pose, core.world.twist))
        touched.append((core.world.contact_impulse != 0) | (core.world.contact_shift != 0))
        begun += int(ride.again.sum())
        if begun >= num_worlds + EPISODES and len(agains) >= STEPS[0]:
            break
    replay = Transport(num_worlds=num_worlds, config=config)
    some = plan[: len(seen)], early[: len(seen)]
    check_replay(replay, drive(replay, seed, *some, in_step=in_step), seen, env)
    k = int(rng.integers(num_worlds))
    free = int(np.argmax([*(row[k] for row in touched), True]))  # steps before it touches anything
    alone = Transport(config=of_world(config, num_worlds, k))
    began = np.array(agains, dtype=np.bool_).reshape(-1, num_worlds)  # the first may lose a body
    own = plan[:free, k : k + 1], began[:free, k : k + 1]
    rides = drive(alone, seed + k, *own, in_step=in_step)
    among = [(pose[k], twist[k]) for pose, twist in poses]

    def explained() -> FloatArray:
        both = Transport(config=alone.config), Transport(config=alone.config)
        one, other = (drive(core, seed + k, *own, in_step=in_step) for core in both)
        return growth(both[0], one, both[1], other)

    check_alone(alone, rides, among, explained, f"{env}: world {k}")
    tried = {"steps": len(agains), "replayed": len(seen)}
    counts = {name: count * num_worlds for name, count in tried.items()}
    return counts | {"episodes": begun, "cut_short": int(watch.lost is not None)}


def held(rides: Iterator[Ride], watch: Watch) -> Iterator[Ride]:
    """All rides, up to one that loses a body too fast for its walls, which ``watch`` is told."""
    try:
        yield from rides
    except BodyLost as error:
        if error.world is None or not watch.may_lose(error.world):
            raise
        watch.lost = error.world


def check_replay(
    core: Transport, rides: Iterable[Ride], seen: Sequence[dict[str, int]], place: str
) -> None:
    """Raise unless every ride shows what was ``seen`` before, to the bit."""
    for step, (ride, before) in enumerate(zip(rides, seen, strict=True)):
        same = digest(core, ride)
        other = [name for name in same if same[name] != before.get(name)]
        assert not other, f"{place}: a replay differs at step {step} in {', '.join(other)}"


def drive(
    core: Transport,
    seed: int,
    plan: FloatArray | IntArray,
    early: BoolArray,
    *,
    in_step: bool,
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
