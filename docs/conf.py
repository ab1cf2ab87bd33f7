"""Sphinx's configuration of the documentation site: ``make docs`` builds it from the repository.

The source folder is the repository's top, so that README, changelog and pages are read where they
are, and a link between them is the same on the site and in the repository.
"""

import re
import sys
from pathlib import Path
from typing import Any, TypeVar

import numpy.typing

sys.path.insert(0, str(Path(__file__).parents[1]))  # benchmarks, which write pages

numpy.typing.ArrayLike = TypeVar("ArrayLike")  # pyright: ignore  # by its name, not its ten parts

from coopenv import __version__  # noqa: E402 - after the name

project = "coopenv"
author = "The coopenv authors"
release = version = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
]
root_doc = "docs/index"
source_suffix = {".md": "markdown"}
include_patterns = ["*.md", "docs/*.md"]
include_patterns += [f"docs/{folder}/*.md" for folder in ("benchmark", "environments", "reference")]
include_patterns += ["docs/training/*.md"]
exclude_patterns = [".*", "**/.*", "agents", "benchmarks", "build", "coopenv", "dist", "examples"]
exclude_patterns += ["rewards", "runs", "tests", "*.egg-info", "docs/_static"]

myst_enable_extensions = ["colon_fence", "html_image"]
myst_heading_anchors = 4
default_role = "py:obj"  # of docstrings: a name in single backticks, with or without a place
suppress_warnings = ["myst.header"]  # a page may begin below its title

autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_custom_sections = ["Source"]

linkcheck_timeout = 20  # [s]
linkcheck_workers = 4
linkcheck_anchors_ignore_for_url = [r"https://github\.com/.*"]  # made by scripts after loading
linkcheck_allowed_redirects = {r"https://doi\.org/.*": r"https?://.*"}

html_theme = "furo"
html_title = f"coopenv {version}"
html_favicon = "_static/icon.svg"
html_static_path = ["_static"]
html_extra_path = ["_extra"]  # what lies on top of the site leads to its first page
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False


def write_pages(app: Any) -> None:
    """Write the pages that the code makes, so that the site never says what it is not."""
    from benchmarks.pages import fill
    from benchmarks.site import environments, results, rewards

    for page, text in environments.stale().items():
        page.write_text(text, encoding="utf-8")
    for made in (rewards, results):
        if made.page() != made.PAGE.read_text(encoding="utf-8"):
            fill(made.PAGE, made.tables())


def with_bars(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Keep |x| in docstrings from being read as the name of a substitution."""
    for k, line in enumerate(lines):
        code = re.split(r"(``.*?``)", line)
        code[::2] = [part.replace("|", r"\|") for part in code[::2]]
        lines[k] = "".join(code)


def setup(app: Any) -> None:
    """Sphinx calls it."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", with_bars, priority=400)
