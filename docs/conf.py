"""The site: ``make docs`` builds it from these pages, the docstrings, and the tutorials, which it runs."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

import stickslip

project = "stickslip"
author = "The stickslip developers"
copyright = "The stickslip developers, MIT licence"
version = release = stickslip.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_copybutton",
    "mathml",
    "subscripts",
    "public_names",
    "command_help",
]
source_suffix = {".md": "myst-nb", ".py": "myst-nb"}
exclude_patterns = ["_build", "_extensions", "conf.py", "pictures.py", "environment_page.py"]

# Pages link to each other as on GitHub: by file, and to headings by GitHub's anchors.
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
nitpicky = True

# Tutorials are Python with cells marked by `# %%`; they are run whenever their page is built.
nb_custom_formats = {".py": ["jupytext.reads", {"fmt": "py:percent"}]}
nb_execution_mode = "force"
nb_execution_timeout = 1200
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True
nb_output_stderr = "remove"  # that kernels are compiled is of no page
nb_number_source_lines = False

# Types stand in the docstrings, with units and ranges; signatures keep names and defaults.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
autodoc_preserve_defaults = True
numpydoc_show_class_members = False
default_role = "py:obj"
add_module_names = False
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = f"stickslip {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
copybutton_exclude = ".linenos, .gp, .go"
