"""Files of options, and numbers of body, scene, task and reward on the command line."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import Actuators, TransportConfig, cli
from coopenv.agents.provenance import Provenance
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.cli.environments import environments_of
from coopenv.cli.options.reading import read

RUN = """
steps = 1000
num-worlds = 4
hidden = [8, 8]
gif = false
out = "runs/heavy"
[environment]
env = "coopenv/BeamDoorway-v0"
reward = "harmony"
horizon = 70
body = { mass = 4.0, grips = [[-0.8, 0.0], [0.9, 0.0]] }
[environment.weights]
progress = 2.0
[evaluation]
episodes = 7
seed = 3
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "run.toml"
    path.write_text(RUN)
    return path


def command(*arguments):
    return read([str(argument) for argument in arguments], cli.COMMANDS)


def test_a_file_says_what_is_trained_and_options_win(file):
    made = command("train", "--config", file)
    assert (made.training.steps, made.training.hidden, made.gif) == (1000, (8, 8), False)
    assert made.training.num_worlds == 4
    assert str(made.training.out) == "runs/heavy"
    environment = made.training.environment.config()
    assert environment.body.mass == 4.0
    assert environment.body.grips == ((-0.8, 0.0), (0.9, 0.0))
    assert environment.horizon == 70
    assert environment.terms["progress"].weight == 2.0
    made = command(
        "train", f"--config={file}", "--steps", 2000, "--body", "mass=5", "--weights", "time=0.5",
        "--horizon", 80, "--gif",
    )  # fmt: skip
    assert (made.training.steps, made.training.hidden, made.gif) == (2000, (8, 8), True)
    environment = made.training.environment.config()
    assert (environment.body.mass, environment.horizon) == (5.0, 80)
    assert environment.body.grips == ((-0.8, 0.0), (0.9, 0.0))
    weights = {name: term.weight for name, term in environment.terms.items()}
    assert (weights["progress"], weights["time"], weights["relative_cost"]) == (2.0, 0.5, 0.3)


def test_a_file_may_begin_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "run.toml"
    path.write_text("steps = 20_000\n", encoding="utf-8-sig")
    assert command("train", "--config", path).training.steps == 20_000


def test_the_same_file_says_how_to_evaluate(file):
    made = command("evaluate", "random", "scripted", "--config", file, "--seed", 4)
    assert made.policies == ("random", "scripted")
    assert (made.episodes, made.seed, made.out) == (7, 4, None)
    assert made.environment.env == "coopenv/BeamDoorway-v0"
    assert made.environment.config().body.mass == 4.0


def test_the_configuration_that_a_run_leaves_is_such_a_file(file, tmp_path):
    first = command("train", "--config", file, "--body", "linear_drag=2").training
    first.save(tmp_path / "config.json")
    assert command("train", "--config", tmp_path / "config.json").training == first


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("stepz = 3", "got 'stepz'; did you mean 'steps'"),
        ("lr = 0.1", "did you mean 'learning_rate'"),
        ("reward = 'task'", r"put it under [environment]"),
        ("body = {mass = 3}", r"put it under [environment]"),
        ("[environment]\nsteps = 3", "put it on top of the file"),
        ("[environment]\nhorizn = 3", "did you mean 'horizon'"),
        ("[environment]\nbody = {mas = 3}", "name in body must be one of the known names"),
        ("[environment]\nbody = 3", "body must be a table"),
        ("[environment]\nenv = 3", "env must be an id"),
        ("[environment]\nweights = {progres = 3}", "did you mean 'progress'"),
        ("[environment]\nweights = {progress = 'much'}", "weight of reward 'progress' must be"),
        ("[environment]\nscene = {obstacles = [{center = [0, 0]}]}", "center and size"),
        ("[environment]\nscene = {obstacles = 3}", "list of tables"),
        ("[environment]\ntask = {clearance = -1}", "task.clearance must be"),
        ("[environment]\nrandomise = {mass = [3]}", "randomise.mass must be (low, high)"),
        ("[evaluation]\nepisode = 3", "did you mean 'episodes'"),
        ("environment = 3", "must be a name with a value"),
        ("steps = 0", "steps must be a whole number"),
        ("steps = 'many'", "steps must be a number"),
        ("hidden = 3", "hidden must be"),
        ("gif = 3", "gif must be true or false"),
        ("out = 3", "out must be the name of a place"),
        ("= 3", "must be whole and of the format"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_file_is_named(text, says, tmp_path, capsys):
    path = tmp_path / "run.toml"
    path.write_text(text)
    assert cli.main(["train", "--config", str(path), f"--out={tmp_path / 'out'}"]) == 1
    said = capsys.readouterr().err
    assert says in said
    assert said.count("\n") == 1


def test_a_file_that_is_not_there_or_of_another_kind_is_named(tmp_path, capsys):
    for name in ("nowhere.toml", "run.yaml"):
        assert cli.main(["evaluate", "random", "--config", str(tmp_path / name)]) == 1
        assert name in capsys.readouterr().err
    broken = tmp_path / "run.json"
    broken.write_text('{"steps": ')
    assert cli.main(["train", f"--config={broken}"]) == 1
    assert str(broken) in capsys.readouterr().err


def choice(*options) -> Any:
    given = command("evaluate", "random", *options).environment
    (place,) = environments_of({"random": "random"}, given)[0].values()
    return place.config


def test_only_what_is_named_changes():
    walker = choice("--env", "coopenv/WalkerTurn-v0", "--body", "mass=30")
    assert walker.body.mass == 30
    assert walker.body.nonholonomic
    assert walker.body.inertia == 4.17
    beam = choice(
        "--body", "mass=15.4", "--scene", "size=[8, 7]", "--task", "position-tolerance=0.2"
    )
    plain = choice()
    assert beam.body.inertia == pytest.approx(2 * plain.body.inertia)  # that of its outline
    assert beam.scene.size == (8.0, 7.0)
    assert beam.task.position_tolerance == 0.2
    assert beam.task.clearance == plain.task.clearance
    assert choice("--randomise", "mass=[4, 9]").randomise.mass == (4.0, 9.0)
    assert choice("--randomise", "ground_friction=[0, 0.3]").randomise.ground_friction == (0, 0.3)
    upright = choice("--scene", "gravity=[0, -9.81]", "--randomise", "gravity=[1, 11]")
    assert upright.randomise.gravity == (1.0, 11.0)
    hands = choice("--action", "motion", "--hands", "stiffness=[80, 90]", "speed=0.5").hands
    assert (hands.stiffness, hands.speed, hands.damping) == ((80.0, 90.0), 0.5, 30.0)
    late = choice("--actuators", "delay=2", "rate-limit=[3, 4]")
    assert late.actuators == Actuators(delay=2, rate_limit=(3.0, 4.0))
    box = choice("--scene", "obstacles=[{center = [0, 1], size = [0.1, 0.1]}]").scene.obstacles[0]
    assert (box.center, box.size) == ((0.0, 1.0), (0.1, 0.1))


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--body", "mas=3"), "got 'mas'; did you mean 'mass'"),
        (("--body", "mass"), "body must be NAME=VALUE"),
        (("--body", "mass=heavy"), "body.mass must be a number"),
        (("--body", "mass=-1"), "body.mass must be positive"),
        (("--weights", "squeeze=1"), "reward term must be one of the known names"),
        (("--task", "clearence=1"), "did you mean 'clearance'"),
        (("--actuators", "delay=0.5"), "actuators.delay must be a whole number"),
        (("--actuators", "lag=1"), "name in actuators must be one of the known names"),
        (("--hands", "stiffness=80"), "hands must come with action='motion'"),
    ],
)
def test_a_wrong_number_is_named(options, says, capsys):
    assert cli.main(["evaluate", "random", *options]) == 1
    assert says in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--mass=4", "--body.mass=4"])
def test_a_number_of_the_body_as_an_option_of_its_own_is_told_its_place(option, capsys):
    with pytest.raises(SystemExit):
        cli.main(["train", option])
    assert "did you mean --body mass=...?" in capsys.readouterr().err


def test_what_a_file_changes_is_what_runs(file, tmp_path):
    table = tmp_path / "table.json"
    options = ("--episodes=2", "--config", str(file), f"--out={table}")
    assert cli.main(["evaluate", "scripted", *options]) == 0
    assert [row["episodes"] for row in json.loads(table.read_text())] == [2]


def test_the_file_on_the_page_of_commands_is_one(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "commands.md").read_text(encoding="utf-8")
    path = tmp_path / "run.toml"
    path.write_text(page.split("```toml\n")[1].split("```")[0])
    made = command("train", "--config", path)
    assert made.training.environment.config().body.mass == 12.0
    assert command("evaluate", "random", "--config", path).episodes == 200


@pytest.mark.parametrize("value", ["true", "0", "'no'", "1"])
def test_fresh_in_a_file_is_refused_since_it_would_remove_a_run_each_time(value, tmp_path, capsys):
    path = tmp_path / "run.toml"
    tiny = "steps = 64\nnum-worlds = 4\nrollout = 8\nepisodes = 1\ngif = false\n"
    path.write_text(f"{tiny}fresh = {value}")
    kept = tmp_path / "out" / "policy.zip"
    kept.parent.mkdir()
    kept.write_bytes(b"a finished run")
    assert cli.main(["train", "--config", str(path), f"--out={kept.parent}"]) == 1
    assert "fresh must be given on the command line" in capsys.readouterr().err
    assert kept.read_bytes() == b"a finished run"


def test_a_file_that_says_fresh_false_as_older_runs_wrote_it_removes_nothing_and_is_read(tmp_path):
    path = tmp_path / "config.json"
    path.write_text(json.dumps({**TrainConfig(steps=20_000).to_dict(), "fresh": False}))
    made = command("train", "--config", path)
    assert made.training.steps == 20_000
    assert not made.training.fresh
    assert command("train", "--config", path, "--fresh").training.fresh
    assert command("evaluate", "random", "--config", path).environment.env


def recorded(path: Path, given: TransportConfig | None = None, **options: Any) -> TrainConfig:
    """Write what a run leaves, without running it."""
    config = TrainConfig(out=path.parent, **options)
    record = Provenance.of(config, given or config.environment.config())
    config.save(path, notes=record.to_notes())
    return config


def test_fresh_of_a_run_does_not_come_back_with_its_config_json(tmp_path):
    path = tmp_path / "config.json"
    config = recorded(path, fresh=True, environment=EnvironmentChoice(also_observe=()))
    assert "fresh" not in json.loads(path.read_text())
    assert command("train", "--config", path).training == replace(config, fresh=False)
    before = json.loads(path.read_text()) | {"fresh": True}  # as it was written once
    path.write_text(json.dumps(before))
    assert not command("train", "--config", path).training.fresh
    assert not TrainConfig.load(path).fresh
    assert command("train", "--config", path, "--fresh").training.fresh


def test_a_config_json_that_does_not_name_its_environment_is_refused(tmp_path, capsys):
    path = tmp_path / "config.json"
    tiny = {"steps": 64, "num_worlds": 4, "rollout": 8}
    recorded(path, TransportConfig(horizon=40), **tiny)
    for line in (
        ["train", "--no-gif", "--episodes=1", f"--out={tmp_path / 'new'}"],
        ["evaluate", "random", "--episodes=1"],
    ):
        assert cli.main([*line, "--config", str(path)]) == 1
        said = capsys.readouterr().err
        assert "differ from its record in horizon" in said
        assert "TransportConfig.from_json" in said
        assert "without --config" in said
    assert not (tmp_path / "new").exists()
    options = json.loads(path.read_text())
    del options["provenance"]
    path.write_text(json.dumps(options))
    assert command("train", "--config", path).training.environment.config().horizon == 200


@pytest.mark.parametrize(
    "environment",
    [
        {"horizon": 40, "body": ("mass=4",), "weights": ("progress=2",)},
        {"env": "coopenv/BeamDoorway-v0", "partner": "population", "randomise": ("mass=[4, 9]",)},
        {"env": "coopenv/WalkerTurn-v0", "scene": ("size=[8, 7]",)},
    ],
)
@pytest.mark.parametrize("control", ["joint", "partner"])
def test_every_environment_that_options_name_comes_back_from_its_config_json(
    environment, control, tmp_path
):
    path = tmp_path / "config.json"
    chosen = EnvironmentChoice(**environment, also_observe=())
    config = recorded(path, environment=chosen, control=control)
    assert command("train", "--config", path).training == config
    made = command("evaluate", "random", "--config", path)
    assert made.environment.config() == config.environment.config()


def test_a_file_says_where_what_is_evaluated_goes(tmp_path):
    path = tmp_path / "look.toml"
    path.write_text('[evaluation]\nepisodes = 7\nout = "runs/look.csv"\n')
    made = command("evaluate", "random", "--config", path)
    assert made.episodes == 7
    assert made.out == Path("runs/look.csv")
