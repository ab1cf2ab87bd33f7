"""Inside of a training run: its progress, its checkpoints, and the folder it leaves."""
