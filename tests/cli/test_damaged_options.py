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
from coopenv.errors import CoopenvError
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
        assert "differ from its record in reward" in " ".join(capsys.readouterr().err.split())
