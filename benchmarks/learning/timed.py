"""One training in a process of its own, timed for `benchmarks.learning.speed`: prints JSON."""

import json
import resource
import sys
import time
from pathlib import Path


def seconds_of_processor() -> float:
    """Of this process since it began, and of its children."""
    spent = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in spent)


def main() -> None:
    """Train as the JSON of the first argument says; it began at the time of the second [s]."""
    settings, began = json.loads(sys.argv[1]), float(sys.argv[2])
    episodes = settings.pop("episodes")
    from coopenv.agents.evaluate import evaluate
    from coopenv.agents.settings import TrainConfig
    from coopenv.agents.train import train
    from coopenv.agents.training.threads import torch_threads

    told: list[str] = []
    out = Path(settings.pop("out"))
    moments: list[tuple[float, float]] = []

    def tell(line: str) -> None:
        """Of a target that is reached, when its policy is written; curves are drawn after that."""
        told.append(line)
        moments.append((time.time() - began, seconds_of_processor()))

    policy = train(TrainConfig(**settings, out=out), tell=tell)
    moments.append((time.time() - began, seconds_of_processor()))
    wall, processor = moments[0]
    with torch_threads(1):
        seen = evaluate(policy, episodes=episodes)
    found = {
        "wall": wall,
        "processor": processor,
        "steps": policy.model.num_timesteps,
        "success": seen.success_rate,
        "low": seen.success_interval[0],
        "relative_cost": seen.relative_cost,
        "time": seen.success_time,
        "told": told,
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main()
