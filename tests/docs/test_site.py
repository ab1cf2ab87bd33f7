"""The site: every page is in its navigation, and what the code writes is what the code says."""

import inspect
import re
from importlib import import_module
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from benchmarks.site import badges, environments, results, rewards
from tests.docs.links import broken
from tests.docs.snippets import ROOT

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
            lines = [line for line in entries.splitlines() if line and not line.startswith(":")]
            names = [re.sub(r"^.* <(.*)>$", r"\1", line) for line in lines]
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


def test_the_page_of_results_is_what_the_other_pages_say():
    assert results.PAGE.read_text(encoding="utf-8") == results.page(), (
        "python -m benchmarks.site.results --write"
    )


def test_links_out_of_the_site_are_whole_and_safe():
    """Whether they lead somewhere is for `make links`, which needs the net."""
    found = [
        (str(page.relative_to(ROOT)), link)
        for page in [*PAGES, *ON_TOP]
        for link in re.findall(r"\]\((\w+:[^)\s]+)\)|<(https?:[^>\s]+)>", page.read_text("utf-8"))
        for link in filter(None, link)
    ]
    assert len(found) > 30
    wrong = [
        (page, link)
        for page, link in found
        if urlsplit(link).scheme not in ("https", "mailto")
        or (link.startswith("https") and "." not in urlsplit(link).netloc)
    ]
    assert not wrong


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


@pytest.mark.parametrize("module", ["coopenv", "coopenv.wrench", "coopenv.rewards", "coopenv.logs"])
def test_every_public_name_is_in_the_reference(module):
    """Classes and functions that have a docstring are; the others are named on its first page."""
    page = (DOCS / "reference" / f"{module.rpartition('.')[2]}.md").read_text(encoding="utf-8")
    assert f"automodule:: {module}\n   :members:\n   :imported-members:" in page
    named = re.findall(r"[\w.]+", (DOCS / "reference.md").read_text(encoding="utf-8"))
    names = {name.rpartition(".")[2] for name in named}
    face = import_module(module)
    found = {name: getattr(face, name) for name in face.__all__}
    told = {name for name, what in found.items() if callable(what) and inspect.getdoc(what)}
    assert set(found) - told - {"rewards", "wrench"} <= names


def test_the_readme_says_what_it_is_before_anything_long():
    """Title, picture, commands and who needs which page come before the first other title."""
    first = (ROOT / "README.md").read_text(encoding="utf-8").split("\n## ")[0]
    assert re.findall(r'<img src="(\S+)"', first) == ["docs/episode.gif"]
    assert first.count("```") == 2
    assert "| you want to | read |" in first
    assert len(first.splitlines()) <= 35
