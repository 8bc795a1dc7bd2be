"""Settings of Sphinx, which ``write_site.py`` runs for the site. Nothing is loaded from elsewhere."""

from functools import cache
from html import escape
from pathlib import Path

from sphinx.addnodes import toctree

project = "hil"
html_title = "hil"
extensions = ["myst_parser"]
root_doc = "index"
source_suffix = {".md": "markdown"}
html_theme = "furo"
html_theme_options = {"top_of_page_buttons": []}
html_search_scorer = str(Path(__file__).with_name("search_order.js"))
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_use_index = False
html_domain_indices = False
pygments_style = "default"
pygments_dark_style = "monokai"
myst_heading_anchors = 4
"""Depth of headings that get an anchor as code hosts make it."""
suppress_warnings = ["misc.highlighting_failure"]
"""Blocks of a page are cut where only a part is of interest: no lexer reads all of them."""


def setup(app):
    """Give each page its navigation: Sphinx makes it of all headings, in half of the time of the build."""

    @cache
    def groups():
        listed = app.env.get_doctree(root_doc).findall(toctree)
        return [(each["caption"], each["includefiles"]) for each in listed]

    def put_navigation(_app, page, _template, context, _doctree):
        def entry(name):
            here = " current" if name == page else ""
            title = escape(app.env.titles[name].astext())
            link = f'<a class="reference internal{here}" href="{context["pathto"](name)}">{title}</a>'
            return f'<li class="toctree-l1{here}">{link}</li>'

        def navigation(**_options):
            return "".join(
                f'<p class="caption" role="heading"><span class="caption-text">{escape(caption)}</span></p>'
                f"<ul>{''.join(map(entry, names))}</ul>"
                for caption, names in groups()
            )

        context["toctree"] = navigation

    app.connect("html-page-context", put_navigation, priority=100)  # before the theme asks for it
