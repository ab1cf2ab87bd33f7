"""docs/infos.md: its table has every key of every view, and no other."""

import re
from pathlib import Path

import gymnasium
import pytest

from coopenv import Ranges
from tests.helpers import IDS

PAGE = Path(__file__).parents[2] / "docs" / "infos.md"


@pytest.mark.parametrize("view", IDS)
def test_the_page_names_every_key_that_there_is(view):
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line[:2] == "| "]
    named = {name for line in lines[1:] for name in re.findall(r"`([^`]+)`", line.split("|")[1])}
    env = gymnasium.make(
        view,
        randomise=Ranges(friction=(0.1, 0.2)),
        partner="walking",
        cost="contact",
        bounded=True,
        action="motion",
    )
    _, info = env.reset(seed=0)
    grouped = {re.sub("^(reward|cost)/.*", r"\1/<term>", key) for key in info}
    assert {re.sub("^body/.*", "body/<number>", key) for key in grouped} == named
