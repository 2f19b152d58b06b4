"""Sphinx builds the documentation with this: ``make docs``."""

from importlib.metadata import version as installed_version

from sphinx.application import Sphinx

project = "epibar"
author = "The epibar developers"
copyright = "The epibar developers"  # noqa: A001
version = release = installed_version("epibar")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx-mathjax-offline",
    "sphinx_argparse_cli",
]
exclude_patterns = ["_build"]

myst_enable_extensions = ["amsmath", "dollarmath"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 3

# Types stand in the docstrings, with shapes and units, which annotations cannot say.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"epibar {release}"
html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["wide.css"]


def link_to_sources(app: Sphinx, name: str, text: list[str]) -> None:
    """Send links that leave this folder, and work in a checkout, to the repository."""
    up = "../" * (name.count("/") + 1)
    text[0] = text[0].replace(f"]({up}", "](https://github.com/epibar/epibar/blob/main/")


def setup(app: Sphinx) -> None:
    """Connect what is done while building."""
    # The formulas as SVG: the default needs fonts, which not every browser loads from a file.
    app.config.mathjax_path = "mathjax/tex-svg.js"
    app.connect("source-read", link_to_sources)
