"""The site in a real browser, at desk and phone width: `make docs` builds it, chromium shows it."""

from pathlib import Path
from urllib.parse import unquote, urldefrag

import pytest

from tests.docs import browser
from tests.docs.snippets import ROOT

SITE = ROOT / "build" / "site"
DESK, PHONE = browser.Screen(1280, 800), browser.Screen(390, 844, is_mobile=True)
LINKS = "[...document.querySelectorAll('a[href]')].map(a => a.href)"
NAMES = "[...document.querySelectorAll('[id]')].map(each => each.id)"
BROKEN = "[...document.images].filter(i => !i.complete || !i.naturalWidth).map(i => i.src)"
SIDEWAYS = "document.documentElement.scrollWidth - window.innerWidth"
SMALL = """[...document.querySelectorAll('article p, article li, article td')]
    .filter(e => parseFloat(getComputedStyle(e).fontSize) < 11).map(e => e.innerText)"""
SEARCHED = """/found|did not match/.test(
    (document.querySelector('.search-summary') || {innerText: ''}).innerText)"""
HITS = "[...document.querySelectorAll('ul.search li > a')].map(a => a.innerText)"


def is_stale() -> bool:
    """Whether the site is not there, or older than what it is made of."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.*")]
    made = SITE / "searchindex.js"
    return not made.exists() or made.stat().st_mtime < max(p.stat().st_mtime for p in pages)


@pytest.fixture(scope="module")
def site():
    if is_stale():
        pytest.skip("the site is not built, or older than its pages: make docs")
    with browser.served(SITE) as address:
        yield address


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    path = browser.found()
    if path is None:
        pytest.skip(f"there is no browser: none of {', '.join(browser.NAMES)}")
    opened = browser.Browser(path, tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()


def pages() -> list[Path]:
    """Those that people read; `index.html` on top leads to the first of them."""
    found = (page.relative_to(SITE) for page in SITE.rglob("*.html"))
    return sorted(page for page in found if page != Path("index.html"))


def looked_at(chromium, url: str) -> tuple[set[str], list[str]]:
    """Names of places on a page, and where its links lead; raise where it looks wrong."""
    chromium.show(DESK)
    chromium.open(url)
    assert not chromium.value(BROKEN), url
    assert chromium.value(SIDEWAYS) <= 0, url
    chromium.show(PHONE)
    assert chromium.value(SIDEWAYS) <= 0, f"{url} is wider than a phone"
    assert not chromium.value(SMALL), url
    assert not chromium.console(), url
    return set(chromium.value(NAMES)), chromium.value(LINKS)


@pytest.mark.parametrize(
    "page", ["index", "tutorial", "questions", "environments/beam_lift", "reference/wrench"]
)
def test_a_page_opens_without_an_error_and_fits_desk_and_phone(page, chromium, site):
    names, _ = looked_at(chromium, f"{site}/docs/{page}.html")
    assert names


@pytest.mark.slow
def test_every_page_does_and_its_links_lead_to_places_that_are_there(chromium, site):
    assert len(pages()) > 50
    seen = {url: looked_at(chromium, url) for page in pages() for url in [f"{site}/{page}"]}
    inside = [urldefrag(link) for _, links in seen.values() for link in links if site in link]
    assert len(inside) > 1000
    lost = [
        f"{to}#{place}"
        for to, place in inside
        if place and to in seen and unquote(place) not in seen[to][0]
    ]
    assert not lost


@pytest.mark.parametrize(
    ("words", "title"),
    [("internal wrench", "load share and γ"), ("load_share", "wrench"), ("doorway", "BeamDoorway")],
)
def test_the_search_finds_a_page(words, title, chromium, site):
    chromium.show(PHONE)
    chromium.open(f"{site}/search.html?q={words.replace(' ', '+')}")
    chromium.wait_for(SEARCHED)
    found = chromium.value(HITS)
    assert any(title in hit for hit in found), found
    assert not chromium.console()


def test_the_top_of_the_site_leads_to_its_first_page(chromium, site):
    chromium.show(DESK)
    chromium.open(f"{site}/index.html")
    chromium.wait_for("location.pathname == '/docs/index.html'")
    chromium.wait_for("document.readyState == 'complete' && document.title.includes('coopenv')")


def test_on_a_phone_the_navigation_opens_by_its_button(chromium, site):
    chromium.show(PHONE)
    chromium.open(f"{site}/docs/tutorial.html")
    left = "document.querySelector('.sidebar-drawer').getBoundingClientRect().left"
    assert chromium.value(left) < 0
    chromium.value("document.querySelector('.mobile-header label[for=__navigation]').click()")
    chromium.wait_for(f"{left} == 0")
