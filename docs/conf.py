"""How Sphinx makes the site; `scripts/docs` runs it on a copy of these pages."""

from bilayer.runtime.version import __version__

project = "bilayer-shells"
author = "The bilayer-shells developers"
version = release = __version__
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["**sg_execution_times.rst"]
smartquotes = False  # they would make one dash of the two of an option

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 4
highlight_language = "none"  # blocks that are only indented: commands, formulas, output
copybutton_exclude = ".linenos, .gp, .go"
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

# no network: formulas by Debian's MathJax 2, which scripts/docs lays beside the pages
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_CHTML"
mathjax2_config = {
    "tex2jax": {"inlineMath": [["\\(", "\\)"]], "processClass": "math"},
    "displayAlign": "left",
    "displayIndent": "2em",
}

autodoc_typehints = "none"  # numpydoc's sections say the types in words
autodoc_member_order = "bysource"
autosummary_generate = True
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
templates_path = ["templates"]

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "min_reported_time": 1,
    "image_scrapers": ("documentation.figures.scrape",),
    "copyfile_regex": r".*\.(csv|svg|toml|frd|sta|cvg)$",
    "doc_module": ("bilayer",),
    "backreferences_dir": "reference/used-in",
    "within_subsection_order": "FileNameSortKey",
    "nested_sections": True,
}

html_theme = "pydata_sphinx_theme"
html_title = "bilayer-shells"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navbar_end": ["theme-switcher"],
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_prev_next": True,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 6,
}
html_context = {"default_mode": "light"}
