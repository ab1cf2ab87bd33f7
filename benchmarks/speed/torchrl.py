"""Benchmark of the TorchRL view: its step beside the core's, and beside PettingZoo's environments.

Every environment acts at random, the same way in each repeat; what is compared runs in turn, and
ratios are medians of the repeats' own.
"""

import time
from collections.abc import Callable

import numpy as np
import torch
from torchrl.envs import EnvBase, PettingZooWrapper, SerialEnv

from benchmarks.speed.transport import REPEATS, median
from coopenv import Transport, TransportTask, beam_transport_v0
from coopenv.agents import torchrl
from coopenv.bench import full_steps, random_actions

SIZES = (64, 256, 1024)
TARGETS = {256: 2.0, 1024: 1.5}  # of a step in TorchRL to `Transport.step`
PETTINGZOO = 64  # environments
TARGET_PETTINGZOO = 30  # times as fast as they are one after the other
STEPS = 40  # a run; no episode ends in them
FIRST = 20  # before them, not timed: what ran in between has left the processor's caches
ACTION = "agents", "action"
NEVER = TransportTask(position_tolerance=1e-9)

Run = Callable[[], float]  # seconds a step of all worlds


def core_run(core: Transport) -> Run:
    """A step of the core."""

    def run() -> float:
        seconds = [*full_steps(core, random_actions(core, FIRST + STEPS))]
        return sum(seconds[FIRST:]) / STEPS

    return run


def torch_run(env: EnvBase, *, resets: bool = False) -> Run:
    """A step in TorchRL; with ``resets`` also the look whether a world has to be reset."""

    def run() -> float:
        torch.manual_seed(0)
        data = env.reset()
        actions = [env.full_action_spec.rand()[ACTION] for _ in range(FIRST + STEPS)]
        began = 0.0
        for number, action in enumerate(actions):
            if number == FIRST:
                began = time.perf_counter()
            data.set(ACTION, action)  # as a policy does
            data = env.step_and_maybe_reset(data)[1] if resets else env.step(data)["next"]
        return (time.perf_counter() - began) / STEPS

    return run


def pettingzoo_run(count: int) -> Run:
    """A step of ``count`` PettingZoo environments, one after the other."""
    envs = [beam_transport_v0.parallel_env(task=NEVER) for _ in range(count)]
    shape = FIRST + STEPS, len(envs[0].possible_agents), envs[0].transport.action_size
    joint = np.random.default_rng(0).uniform(-1, 1, shape).astype(np.float32)
    actions = [dict(zip(envs[0].possible_agents, each, strict=True)) for each in joint]

    def run() -> float:
        for k, env in enumerate(envs):
            env.reset(seed=k)
        began = 0.0
        for number, action in enumerate(actions):
            if number == FIRST:
                began = time.perf_counter()
            for env in envs:
                env.step(action)
        return (time.perf_counter() - began) / STEPS

    return run


def wrapped_run(count: int) -> Run:
    """A step of ``count`` PettingZoo environments in TorchRL's own wrapper, as one batch."""

    def one() -> EnvBase:
        return PettingZooWrapper(
            beam_transport_v0.parallel_env(task=NEVER),
            return_state=False,
            group_map={"agents": ["agent_0", "agent_1"]},
        )

    return torch_run(SerialEnv(count, one))


def medians(runs: dict[str, Run]) -> tuple[dict[str, float], dict[str, float]]:
    """Seconds of each run, and its ratio to the first one."""
    for run in runs.values():
        run()
    times = {name: [] for name in runs}
    for _ in range(REPEATS):
        for name, run in runs.items():
            times[name].append(run())
    first = next(iter(times.values()))
    ratios = {name: median(np.divide(each, first)) for name, each in times.items()}
    return {name: median(each) for name, each in times.items()}, ratios


def beside_core(num_worlds: int) -> list[str]:
    """A row: how much TorchRL adds to the core's step."""
    core = Transport(num_worlds=num_worlds, task=NEVER)
    bare = torchrl.make_env(num_worlds=num_worlds, task=NEVER)
    told = torchrl.make_env(num_worlds=num_worlds, task=NEVER, info=True, return_state=True)
    times, ratios = medians(
        {
            "core": core_run(core),
            "step": torch_run(bare),
            "resets": torch_run(bare, resets=True),
            "told": torch_run(told),
        }
    )
    target = TARGETS.get(num_worlds)
    return [
        f"{num_worlds:,}",
        f"{times['core'] * 1e6:,.0f}",
        f"{times['step'] * 1e6:,.0f}",
        *(f"{ratios[name]:.2f} ×" for name in ("step", "resets", "told")),
        "" if target is None else f"≤ {target:g} ×",
    ]


def beside_pettingzoo() -> list[str]:
    """The row of many worlds at once beside as many environments."""
    batch = torchrl.make_env(num_worlds=PETTINGZOO, task=NEVER)
    runs = {
        "batch": torch_run(batch),
        "one by one": pettingzoo_run(PETTINGZOO),
        "wrapped": wrapped_run(PETTINGZOO),
    }
    times, ratios = medians(runs)
    return [
        *(f"{time * 1e3:.2f}" for time in times.values()),
        f"{ratios['one by one']:.0f} ×",
        f"{ratios['wrapped']:.0f} ×",
        f"≥ {TARGET_PETTINGZOO} ×",
    ]


def tables() -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, columns and rows of what this module measures."""
    torch.set_num_threads(1)
    core = [
        "worlds",
        "Transport.step [µs]",
        "EnvBase.step [µs]",
        "EnvBase.step",
        "step_and_maybe_reset",
        "step, all infos and state",
        "target",
    ]
    zoo = [
        f"TorchRL, {PETTINGZOO} worlds [ms]",
        f"{PETTINGZOO} parallel_env [ms]",
        "those in PettingZooWrapper and SerialEnv [ms]",
        "parallel_env / TorchRL",
        "wrapped / TorchRL",
        "target",
    ]
    return [
        ("A step in TorchRL, to that of the core", core, [beside_core(n) for n in SIZES]),
        ("A step of all, beside as many PettingZoo environments", zoo, [beside_pettingzoo()]),
    ]
