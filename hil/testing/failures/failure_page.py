"""Page of a test that failed, with all that is known of it: one file, and nothing from elsewhere."""

from base64 import b64encode
from collections.abc import Iterable
from html import escape
from pathlib import Path
from typing import NamedTuple

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 70em; padding: 0 1em; }
pre { background: #f4f4f4; overflow-x: auto; padding: 0.8em; }
img { max-width: 100%; }
"""


class KeptFile(NamedTuple):
    """File beside the page, and what it is."""

    path: Path
    about: str


def failure_page(
    title: str, failure: str, sections: Iterable[tuple[str, str]], files: Iterable[KeptFile]
) -> str:
    """Write the page: what pytest says, the sections of the report, pictures, and links to files."""
    files = [*files]
    parts = [f"<h1>{escape(title)}</h1>", _text(failure)]
    parts += [f"<h2>{escape(name)}</h2>\n{_text(text)}" for name, text in sections]
    parts += [_picture(each) for each in files if each.path.suffix == ".svg"]
    links = "".join(
        f'<li><a href="{escape(each.path.name)}">{escape(each.path.name)}</a>: {escape(each.about)}</li>\n'
        for each in files
    )
    parts.append(f"<h2>Files</h2>\n<ul>\n{links}</ul>")
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    return (
        f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n'
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def _text(text: str) -> str:
    return f"<pre>{escape(text)}</pre>"


def _picture(file: KeptFile) -> str:
    data = b64encode(file.path.read_bytes()).decode()
    return f'<p><img alt="{escape(file.about)}" src="data:image/svg+xml;base64,{data}"></p>'
