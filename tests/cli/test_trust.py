"""Files that come from elsewhere run nothing, unless the command line itself says so."""

import json
import shutil
import sys
from hashlib import sha256
from pathlib import Path

import gymnasium
import numpy as np
import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv import TransportConfig, cli
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.train import train
from coopenv.errors import CoopenvError, InvalidInput
from tests.agents.learned import hostile
from tests.agents.training.cases import SHORT, tiny

EVIL = """
from pathlib import Path
import coopenv

Path({marker!r}).touch()
coopenv.register("evil/Mine-v0", horizon=3)

class Mine:
    pass
"""


@pytest.fixture
def marker(tmp_path) -> Path:
    """What hostile files leave behind if they run."""
    return tmp_path / "marker"


@pytest.fixture
def evil(tmp_path, marker, monkeypatch):
    """The name of a module that leaves the marker where it is imported."""
    (tmp_path / "evil.py").write_text(EVIL.format(marker=str(marker)))
    monkeypatch.syspath_prepend(tmp_path)
    yield "evil"
    sys.modules.pop("evil", None)
    gymnasium.registry.pop("evil/Mine-v0", None)


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    """The folder of a run that is finished."""
    out = tmp_path_factory.mktemp("run")
    train(tiny(out), environment=SHORT)
    return out


def test_evaluating_a_file_runs_nothing_in_it_unless_it_is_trusted(run, marker, tmp_path, capsys):
    path = hostile.in_data(run / "policy.zip", tmp_path / "policy.zip", marker)
    assert cli.main(["evaluate", str(path), "--episodes=1"]) == 0
    assert not marker.exists()
    assert cli.main(["evaluate", str(path), "--episodes=1", "--trust=some_module"]) == 0
    assert not marker.exists()  # a module is trusted, the pickles are not
    assert cli.main(["evaluate", str(path), "--episodes=1", "--trust"]) == 0
    assert marker.exists()
    assert not capsys.readouterr().err


def test_weights_that_run_code_are_refused_in_one_line(run, marker, tmp_path, capsys):
    path = hostile.in_weights(run / "policy.zip", tmp_path / "policy.zip", marker)
    for trust in ([], ["--trust"]):
        assert cli.main(["evaluate", str(path), "--episodes=1", *trust]) == 1
        assert "Traceback" not in capsys.readouterr().err
    assert not marker.exists()


@pytest.mark.parametrize("name", ["policy.zip", "checkpoint.zip"])
def test_going_on_in_a_folder_runs_nothing_in_its_files(name, run, marker, tmp_path):
    path = hostile.in_data(run / "policy.zip", tmp_path / name, marker)
    if name == "checkpoint.zip":  # as it was written before files had a blueprint
        hostile.with_members(path, path, {"coopenv_model.json": None})
    said: list[str] = []
    again = train(tiny(tmp_path, steps=256), environment=SHORT, tell=said.append)
    assert "going on" in said[0]
    assert again.model.num_timesteps == 256
    assert not marker.exists()


@pytest.mark.parametrize("member", ["policy.pth", "policy.optimizer.pth", "pytorch_variables.pth"])
def test_going_on_from_weights_that_run_code_is_refused(member, run, marker, tmp_path):
    hostile.in_weights(run / "policy.zip", tmp_path / "checkpoint.zip", marker, member)
    with pytest.raises(InvalidInput, match=r"numbers alone.*--fresh"):
        train(tiny(tmp_path, steps=256), environment=SHORT)
    assert not marker.exists()


def options(path: Path, **changes) -> Path:
    """A file of options for a training of seconds that names the environment of a module."""
    given = {"steps": 64, "num_worlds": 4, "rollout": 8, "hidden": [4], "episodes": 1, "gif": False}
    text = json.dumps({**given, "environment": {"env": "evil:evil/Mine-v0"}, **changes})
    path.write_text(text)
    return path


@pytest.mark.parametrize("allowed", ["--env=evil:evil/Mine-v0", "--trust"])
@pytest.mark.parametrize("command", ["train", "evaluate"])
def test_the_module_of_an_id_in_a_file_is_imported_only_if_the_command_names_it(
    command, allowed, evil, marker, tmp_path, capsys
):
    file = options(tmp_path / "config.json")
    arguments = [command, f"--config={file}"]
    arguments += [f"--out={tmp_path / 'out'}"] if command == "train" else ["scripted"]
    assert cli.main(arguments) == 1
    assert f"which would import and run {evil!r}" in capsys.readouterr().err
    assert not marker.exists()
    assert cli.main([*arguments, "--episodes=1", allowed]) == 0
    assert marker.exists()


def test_no_file_of_options_trusts_itself(evil, marker, tmp_path, capsys):
    for place in ({"trust": True}, {"evaluation": {"trust": ["evil"]}}):
        file = options(tmp_path / "config.json", **place)
        assert cli.main(["evaluate", "scripted", f"--config={file}"]) == 1
        assert "must be one of the known names, got 'trust'" in capsys.readouterr().err
    assert not marker.exists()


def test_settings_beside_an_older_policy_import_nothing_unless_they_are_trusted(
    run, evil, marker, tmp_path, capsys
):
    names = ("coopenv.json", "coopenv_model.json", "coopenv_progress.json")
    old = hostile.with_members(run / "policy.zip", tmp_path / "old.zip", dict.fromkeys(names))
    settings = TrainConfig(environment=EnvironmentChoice(env="evil:evil/Mine-v0")).to_dict()
    (tmp_path / "config.json").write_text(json.dumps(settings))
    assert cli.main(["evaluate", str(old), "--episodes=1"]) == 1
    assert not marker.exists()
    assert cli.main(["evaluate", str(old), "--episodes=1", "--trust=evil"]) == 1
    assert marker.exists()  # its environment; its pickles are not trusted by that
    assert "load it with trust=True (--trust)" in capsys.readouterr().err


def test_reading_the_settings_of_a_run_imports_nothing(evil, marker):
    settings = TrainConfig(environment=EnvironmentChoice(env="evil:evil/Mine-v0")).to_dict()
    assert TrainConfig.from_dict(settings).environment.env == "evil:evil/Mine-v0"
    with pytest.raises(InvalidInput, match="which would import and run"):
        TrainConfig.from_dict({**settings, "control": "partner"})
    assert not marker.exists()


def test_a_record_in_a_policy_imports_no_module_for_its_title(run, evil, marker, tmp_path):
    with hostile.zipfile.ZipFile(run / "policy.zip") as archive:
        notes = json.loads(archive.read("coopenv.json"))
    notes["provenance"]["training"]["environment"]["env"] = "evil:evil/Mine-v0"
    members: dict[str, bytes | None] = {"coopenv.json": json.dumps(notes).encode()}
    path = hostile.with_members(run / "policy.zip", tmp_path / "policy.zip", members)
    assert cli.main(["evaluate", str(path), "--episodes=1"]) == 0
    assert not marker.exists()
    assert cli.main(["evaluate", str(path), "--episodes=1", "--trust=evil"]) == 0
    assert marker.exists()


@pytest.mark.parametrize("field", ["task", "reward", "partner", "observe", "randomise"])
def test_the_text_of_a_configuration_imports_nothing(field, evil, marker, tmp_path):
    digest = sha256((tmp_path / "evil.py").read_bytes()).hexdigest()
    mine = {"kind": "evil:Mine", "sha256": digest, "fields": {}}
    values = json.loads(TransportConfig().to_json())
    values[field] = [mine] if field == "observe" else mine
    with pytest.raises(InvalidInput, match="unless you trust the text"):
        TransportConfig.from_json(json.dumps(values))
    with pytest.raises(CoopenvError):  # as a keyword, which gymnasium's own JSON brings back
        TransportConfig.parse({field: values[field]})
    assert not marker.exists()
    with pytest.raises(InvalidInput):  # it is no frozen dataclass
        TransportConfig.from_json(json.dumps(values), trust=True)
    assert marker.exists()


@pytest.mark.parametrize("name", ["time", "force", "grips"])
def test_a_recording_with_pickles_in_it_runs_nothing(name, marker, tmp_path, capsys):
    pytest.importorskip("pyarrow")
    arrays: dict[str, np.ndarray] = {
        "time": np.arange(3.0),
        "force": np.ones((3, 2, 2)),
        "grips": np.array([[-0.9, 0.0], [0.9, 0.0]]),
    }
    held = np.empty(arrays[name].shape, dtype=object)
    held.fill(hostile.Touch(marker))
    np.savez(tmp_path / "trial.npz", **{**arrays, name: held})
    assert cli.main(["decompose", str(tmp_path / "trial.npz"), "--forces-only"]) == 1
    assert "of Python objects" in capsys.readouterr().err
    assert not marker.exists()


def test_trust_before_the_policies_is_told_where_it_belongs(run, tmp_path, capsys):
    shutil.copy(run / "policy.zip", tmp_path / "policy.zip")
    assert cli.main(["evaluate", "scripted", "--trust", str(tmp_path / "policy.zip")]) == 1
    assert "put --trust behind the policies" in capsys.readouterr().err
