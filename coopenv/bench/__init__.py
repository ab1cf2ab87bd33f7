"""How fast it is on this machine: steps of an environment, decompositions, a control loop."""

from coopenv.bench.latency import Times, times_of_calls
from coopenv.bench.splits import SPLITS, SplitRate, split_rate
from coopenv.bench.steps import StepRate, full_step, full_steps, random_actions, step_rate

__all__ = [
    "SPLITS",
    "SplitRate",
    "StepRate",
    "Times",
    "full_step",
    "full_steps",
    "random_actions",
    "split_rate",
    "step_rate",
    "times_of_calls",
]
