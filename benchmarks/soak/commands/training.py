"""What holds of a run's folder while it is trained in, and when it is done."""

from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.soak.commands.scenes import (
    RUN,
    SCENES,
    TRAIN,
    Scene,
    check_end,
    input_of,
    undisturbed,
)
from benchmarks.soak.commands.whole import table_rows
from coopenv.agents.training.checkpoint import CHECKPOINT, POLICY, Checkpoint


def warm_up() -> None:
    """Make and read once what trials make and read: it imports torch, pyarrow and the like."""
    for name in {name for scene in SCENES for name in scene.inputs}:
        input_of(name)
    with TemporaryDirectory() as folder:
        path = Path(folder) / POLICY
        path.write_bytes(input_of(POLICY))
        Checkpoint.read(path)


def check_progress(folder: Path, before: int) -> int:
    """Control steps that the run holds; raise where it lost some or its curves go backwards."""
    run = folder / RUN
    kept = [Checkpoint.read(path) for name in (POLICY, CHECKPOINT) if (path := run / name).exists()]
    steps = max((each.progress.steps for each in kept), default=0)
    assert steps >= before, f"the run held {before} steps and now holds {steps}"
    for each in kept:
        rows = [int(row["steps"]) for row in each.progress.rows]
        _check_order(rows, f"{each.path.name} of {steps} steps")
    curves = run / "curves.csv"
    if curves.exists():
        rows = [int(row["steps"]) for row in table_rows(curves.read_bytes())]
        _check_order(rows, "curves.csv")
    return steps


def finish(scene: Scene, folder: Path, before: str) -> None:
    """Run a command to its end; raise unless all is as if nobody had disturbed it."""
    ended = scene.run(folder)
    assert ended.code == 0, f"the run after {before} fails: {ended}"
    check_end(scene, folder)
    if scene.is_training:
        check_finished(folder)


def check_finished(folder: Path) -> None:
    """Raise unless it is the run that nobody disturbed, with every update in its curves."""
    wanted = undisturbed(TRAIN).files
    run = folder / RUN
    found = Checkpoint.read(run / POLICY)
    for name, steps in (("curves.csv", "steps"), ("table.csv", "policy")):
        rows = [
            [row[steps] for row in table_rows(content)]
            for content in (wanted[f"{RUN}/{name}"], (run / name).read_bytes())
        ]
        assert rows[0] == rows[1], f"{name} has {rows[1]}, undisturbed {rows[0]}"
    others = [table_rows(each)[1:] for each in (wanted[f"{RUN}/table.csv"], _table(run))]
    assert others[0] == others[1], "policies that were not trained are evaluated otherwise"
    (folder / "undisturbed.zip").write_bytes(wanted[f"{RUN}/{POLICY}"])
    try:
        names = Checkpoint.read(folder / "undisturbed.zip").provenance.differences(found.provenance)
    finally:
        (folder / "undisturbed.zip").unlink()
    assert not names, f"it is another run now, in {', '.join(names)}"


def _table(run: Path) -> bytes:
    return (run / "table.csv").read_bytes()


def _check_order(steps: list[int], what: str) -> None:
    assert steps == sorted(set(steps)), f"{what} goes backwards: {steps}"
