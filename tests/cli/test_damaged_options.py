"""Damaged copies of a run's config.json: refused in one sentence, or read as a whole."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("tyro")

from coopenv import cli
from coopenv.agents.provenance import Provenance
from coopenv.agents.settings import TrainConfig
from coopenv.cli.evaluate import Evaluate
from coopenv.cli.train import Train
from coopenv.errors import CoopenvError, InvalidInput
from tests.agents.learned import damage

SEED = 20261129  # of what is damaged, and how


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """The config.json that a run leaves."""
    path = tmp_path_factory.mktemp("run") / "config.json"
    config = TrainConfig()
    config.save(path, notes=Provenance.of(config, config.environment.config()).to_notes())
    return path


def damaged(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    change = [damage.cut, damage.flipped, damage.of_other_kind][int(rng.integers(3))]
    return change.__name__, change(content, rng)


def read(path: Path) -> None:
    """As both commands do, and as settings beside an older policy."""
    errors = []
    for command in (Train, Evaluate):
        try:
            command.configured(path)
        except CoopenvError as error:
            errors.append(error)
    TrainConfig.load(path).environment.config()
    if errors:
        raise errors[0]


def test_a_damaged_file_of_options_is_refused_or_read_as_a_whole(whole, tmp_path):
    counts = damage.refused_or_whole(
        damaged, whole, tmp_path / "config.json", read, times=200, seed=SEED
    )
    assert counts["refused"] > 100


def test_terms_of_a_reward_that_are_none_are_told(whole, tmp_path, capsys):
    path = tmp_path / "config.json"
    for terms in (3, [3], [{"name": {}, "term": 1}], [{"term": 1}], {}):
        content = json.loads(whole.read_text())
        content["provenance"]["environment"]["reward"]["terms"] = terms
        path.write_text(json.dumps(content))
        assert cli.main(["evaluate", "scripted", f"--config={path}"]) == 1
        said = " ".join(capsys.readouterr().err.split())
        assert f"{path}, whose provenance.environment cannot be read (reward" in said


@pytest.mark.parametrize("environment", [{}, {"horizon": "x"}, {"kind": "coopenv.Box"}])
def test_a_damaged_record_is_called_damaged_and_no_other_environment(environment, whole, tmp_path):
    path = tmp_path / "config.json"
    content = json.loads(whole.read_text())
    content["provenance"]["environment"] = environment
    path.write_text(json.dumps(content))
    with pytest.raises(InvalidInput, match=r"provenance\.environment cannot be read") as caught:
        Train.configured(path)
    assert str(path) in str(caught.value)
    assert "from Python" not in str(caught.value)


@pytest.mark.parametrize("record", [3, [], {"format": 2}])
def test_a_damaged_record_is_named_with_its_file(record, whole, tmp_path):
    path = tmp_path / "config.json"
    path.write_text(json.dumps({**json.loads(whole.read_text()), "provenance": record}))
    with pytest.raises(InvalidInput, match=rf"provenance must be of format 1.*{path}"):
        Train.configured(path)


def test_other_defaults_of_another_version_are_one_of_the_causes(whole, tmp_path):
    path = tmp_path / "config.json"
    content = json.loads(whole.read_text())
    content["provenance"]["environment"]["horizon"] = 150
    path.write_text(json.dumps(content))
    with pytest.raises(InvalidInput, match="in horizon") as caught:
        Train.configured(path)
    assert "other defaults" not in str(caught.value)
    content["provenance"]["versions"]["coopenv"] = "0.0.1"
    path.write_text(json.dumps(content))
    with pytest.raises(InvalidInput, match=r"coopenv 0\.0\.1, which wrote it, had other defaults"):
        Train.configured(path)
