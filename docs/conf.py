"""Sphinx's configuration of the documentation site: ``make docs`` builds it from the repository.

The source folder is the repository's top, so that README, changelog and pages are read where they
are, and a link between them is the same on the site and in the repository.
"""

from coopenv import __version__

project = "coopenv"
author = "The coopenv authors"
release = version = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
]
root_doc = "docs/index"
source_suffix = {".md": "markdown"}
include_patterns = ["*.md", "docs/*.md", "docs/environments/*.md", "docs/reference/*.md"]
exclude_patterns = [".*", "**/.*", "agents", "benchmarks", "build", "coopenv", "dist", "examples"]
exclude_patterns += ["rewards", "runs", "tests", "*.egg-info", "docs/_static"]

myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
default_role = "py:obj"  # of docstrings: a name in single backticks, with or without a place
suppress_warnings = ["myst.header"]  # a page may begin below its title

autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_custom_sections = ["Source"]

html_theme = "furo"
html_title = f"coopenv {version}"
html_static_path = ["_static"]
html_extra_path = ["_extra"]  # what lies on top of the site leads to its first page
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
