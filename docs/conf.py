"""Sphinx settings of the site: `make docs` builds it, warnings are errors, read offline."""

import sys
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.config import Config

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tools"))

import make_site_pages  # noqa: E402

from rtkit import __version__  # noqa: E402

project = "rtkit"
copyright = "the rtkit authors, Apache-2.0"
release = version = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["generated/data_types.md"]
html_theme = "furo"
html_title = f"rtkit {__version__}"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
myst_heading_anchors = 3
myst_enable_extensions = ["deflist"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_numpy_docstring = False
napoleon_use_ivar = True
pygments_style = "friendly"
pygments_dark_style = "monokai"


def _write_pages(app: Sphinx, config: Config) -> None:
    make_site_pages.write(HERE.parent, HERE / "generated")


def setup(app: Sphinx) -> None:
    """Have pages that come from other files written before the rest is read."""
    app.connect("config-inited", _write_pages)
