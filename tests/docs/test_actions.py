"""Which action to choose: the same five lines on every page where one would look for them."""

from pathlib import Path

import pytest

from coopenv.config.environment import ACTIONS

ROOT = Path(__file__).parents[2]


def five_lines(page: str) -> list[str]:
    text = (ROOT / page).read_text(encoding="utf-8")
    first = text.index('- `"wrench"` where')
    return text[first:].split("\n\n")[0].splitlines()


@pytest.mark.parametrize("page", ["README.md", "docs/tasks.md", "docs/extending.md"])
def test_a_page_says_which_action_to_choose(page):
    lines = five_lines("docs/actions.md")
    assert five_lines(page) == lines
    assert [line.split("`")[1].strip('"') for line in lines] == list(ACTIONS)
