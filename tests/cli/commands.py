"""Every command with the least that it has to be given."""

LEAST: dict[str, list[str]] = {
    "train": [],
    "evaluate": ["random"],
    "export": ["policy.zip"],
    "experiment": ["tiny.toml"],
    "sweep": ["wasted_cost", "0"],
    "report": ["runs"],
    "benchmark": ["random"],
    "show": ["--grips", "-0.9", "0", "0.9", "0", "--applied", "3", "0", "0", "-1", "0", "0"],
    "replay": ["random"],
    "study": ["beam"],
    "decompose": ["trial.csv"],
    "inspect": ["trial.csv"],
    "bench": [],
    "warmup": [],
    "completion": ["bash"],
}
STUDIES = ("walker-turn", "walker-avoid", "beam", "dyads", "snapshots")
