"""The pages as a site, by Sphinx with MyST and Furo: `make docs` builds `out/site` and stops at the first dead link.

The source folder is the whole house, so that links between pages, README, CHANGELOG and the models in `data/` are the
same here and where the files are read as they are.
"""

from __future__ import annotations

from typing import Any

import spacar

project = "spacar"
author = copyright = "the authors of spacar"
version = release = spacar.__version__

extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
root_doc = "docs/index"
include_patterns = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/**", "benchmarks/**.md"]
exclude_patterns = [".*", "out", "build", "dist", "data", "tests", "docs/*.py", "docs/symbolic/*.py"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = f"spacar {release}"
html_static_path = ["site_static"]  # also its index.html, which leads from the top folder to docs/
html_extra_path = ["site_static/index.html"]
html_css_files = ["wide.css"]
html_copy_source = False
html_show_sphinx = False
pygments_style = "friendly"
highlight_language = "none"
smartquotes = False  # x' is an axis, not an apostrophe

# what the left column shows: title -> pages
CONTENTS = {
    "Learn": (
        "/README", "tutorial", "start-spacar", "start-flexure", "start-control", "start-python", "gallery",
        "symbolic/tutorial",
    ),
    "Do one thing": (
        "edit", "drawing", "flexures", "studies", "sensitivity", "simulation", "python", "matlab", "convergence",
    ),
    "Look up": (
        "keywords", "expressions", "reference/index", "reference/input-language", "reference/files",
        "reference/messages", "reference/blocks", "reference/sections", "reference/theory-system",
        "reference/theory-planar", "reference/theory-spatial", "reference/theory-warping",
        "reference/theory-beam-order4", "reference/symbolic", "reference/later-versions", "reference/bibliography",
        "limits",
    ),
    "Understand": ("accuracy", "theory", "symbolic/theory", "performance", "promises", "decisions"),
    "Change": (
        "developer", "engine", "/CONTRIBUTING", "/CHANGELOG", "/benchmarks/NOTES", "/benchmarks/peers/README",
    ),
}  # fmt: skip


def add_contents(app: Any, name: str, source: list[str]) -> None:
    """The first page lists all pages for readers; Sphinx wants the same as directives, which are not shown there."""
    if name == root_doc:
        for title, pages in CONTENTS.items():
            source[0] += f"\n\n```{{toctree}}\n:hidden:\n:caption: {title}\n\n" + "\n".join(pages) + "\n```\n"


def setup(app: Any) -> None:
    app.connect("source-read", add_contents)
