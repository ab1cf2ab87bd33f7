"""The site: every page is in its navigation, and what the code writes is what the code says."""

import re
from importlib import import_module
from pathlib import Path

import pytest

from benchmarks.site import badges, environments, rewards
from tests.docs.links import broken
from tests.docs.snippets import ROOT
from tests.test_public_names import NAMES, VIEWS

DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
ON_TOP = [ROOT / f"{name}.md" for name in ("README", "CHANGELOG", "CODE_OF_CONDUCT")]
ON_TOP += [ROOT / f"{name}.md" for name in ("CONTRIBUTING", "SECURITY")]
TOCTREE = re.compile(r"^:::\{toctree\}\n(.*?)^:::$", re.DOTALL | re.MULTILINE)


def navigation() -> dict[Path, list[Path]]:
    """Page → the pages below it."""
    found: dict[Path, list[Path]] = {}
    for page in PAGES:
        for entries in TOCTREE.findall(page.read_text(encoding="utf-8")):
            names = [line for line in entries.splitlines() if line and not line.startswith(":")]
            paths = [(page.parent / f"{name}.md").resolve() for name in names]
            found.setdefault(page, []).extend(paths)
    return found


def test_every_page_is_in_the_navigation_once():
    below = [page for pages in navigation().values() for page in pages]
    assert sorted(below) == sorted({*PAGES, *ON_TOP} - {DOCS / "index.md"})


@pytest.mark.parametrize("page", [*PAGES, *ON_TOP], ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_and_picture_of_the_site_leads_somewhere(page):
    assert not broken(page)


def test_the_page_of_an_environment_is_what_the_code_says():
    assert not environments.stale(), "python -m benchmarks.site.environments --write"


def test_the_tables_of_rewards_are_what_the_code_says():
    assert rewards.PAGE.read_text(encoding="utf-8") == rewards.page()


def test_badges_say_what_the_project_says():
    assert not badges.stale(), "python -m benchmarks.site.badges --write"
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"docs/badges/(\w+)\.svg", readme))
    assert shown == set(badges.values())


def test_thirty_questions_are_answered_at_an_anchor_each():
    rows = re.findall(
        r"^\| \[(\d+)\]\((https://github\.com/\S+)\) \| .* \| \[\S+\]\((\S+)#(\S+)\) \|$",
        (DOCS / "questions.md").read_text(encoding="utf-8"),
        flags=re.MULTILINE,
    )
    assert [int(number) for number, *_ in rows] == list(range(1, 31))
    assert len({asked for _, asked, *_ in rows}) == 30


def test_every_public_module_has_its_place_in_the_reference():
    text = "".join(page.read_text(encoding="utf-8") for page in (DOCS / "reference").glob("*.md"))
    shown = set(re.findall(r"auto(?:module|function):: (coopenv[\w.]*)", text))
    objects = {
        id(getattr(import_module(module), name, None))
        for module in shown - {"coopenv.agents.train.train"}
        for name in dir(import_module(module))
    }
    missing = [
        f"{module}.{name}"
        for module in ("coopenv", "coopenv.wrench", "coopenv.rewards", "coopenv.logs")
        for name in NAMES[module]
        if name not in VIEWS and id(getattr(import_module(module), name)) not in objects
    ]
    assert not missing


def test_the_readme_says_what_it_is_before_anything_long():
    """Title, picture, commands and who needs which page come before the first second-level title."""
    first = (ROOT / "README.md").read_text(encoding="utf-8").split("\n## ")[0]
    assert first.count("![") == 5  # four badges, one picture
    assert first.count("```") == 2
    assert "| you want to | read |" in first
    assert len(first.splitlines()) <= 35
