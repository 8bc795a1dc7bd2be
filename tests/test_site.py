"""``write_site.py``: where links of pages lead in the site, and what its check of the HTML finds."""

from pathlib import Path

import pytest

import write_site
from write_site import Broken, Copies, broken_links, copy_pages, page_of


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Project of a few pages."""
    monkeypatch.setattr(write_site, "ROOT", tmp_path)
    monkeypatch.setattr(write_site, "PAGES", tmp_path / "build/pages")
    monkeypatch.setattr(write_site, "NAVIGATION", {"Start": ["docs/tour.md"], "All": ["docs/decisions"]})
    monkeypatch.setattr(write_site, "FOLDERS", {"docs/decisions"})
    for name, text in {
        "README.md": "# hil\n[tour](docs/tour.md#see) [all](docs/decisions/)\n```text\n[no](link)\n```\n",
        "docs/tour.md": "# Tour\n## See\n[home](../README.md), [x](../examples/x.yaml) [web](https://a.example/b)\n",
        "docs/decisions/0001-one.md": "# 1. One <that> holds\n![p](../p.svg) [tour](../tour.md)\n",
        "docs/p.svg": "<svg/>",
        "examples/x.yaml": "text: '```'\n",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_every_page_of_the_project_is_in_the_navigation() -> None:
    groups = write_site.pages()
    assert "docs/how-to/ports.md" in groups["Use: programs and tests"]
    names = [name for group in groups.values() for name in group]
    assert len(names) == len(set(names))


def test_links_lead_to_pages_of_the_site(project: Path) -> None:
    assert copy_pages() == 6
    made = project / "build/pages"
    home = (made / "index.md").read_text()
    assert "[tour](docs/tour.md#see) [all](docs/decisions/index.md)" in home
    assert "[no](link)" in home
    assert ":caption: 'Start'\n\ndocs/tour.md" in home
    tour = (made / "docs/tour.md").read_text()
    assert "[home](../index.md), [x](../examples/x.yaml.md) [web](https://a.example/b)" in tour
    assert "[0001: One <that> holds](0001-one.md)" in (made / "docs/decisions/index.md").read_text()
    assert (made / "docs/p.svg").exists()


def test_a_file_that_is_no_page_is_shown_as_it_is(project: Path) -> None:
    Copies().add("examples/x.yaml")
    shown = (project / "build/pages" / page_of("examples/x.yaml")).read_text()
    assert shown.startswith("---\norphan: true\n")
    assert "\n````yaml\ntext: '```'\n````\n" in shown


def test_a_page_in_no_group_is_refused(project: Path) -> None:
    (project / "docs/new.md").write_text("# New\n")
    with pytest.raises(Broken, match=r"docs/new.md: in no group"):
        copy_pages()


@pytest.mark.parametrize(
    ("html", "found"),
    [
        ("<a href='b.html#there'>b</a> <a href='https://other.example'>o</a>", []),
        ("<a id='x' href='#x'>x</a> <img src='data:image/png;base64,'>", []),
        ("<a href='c.html'>c</a>", ["a.html:1: c.html is not there"]),
        ("<a href='b.html#gone'>b</a>", ["a.html:1: b.html#gone: the page has no such place"]),
        ("\n<img src='p%20q.png'>", ["a.html:2: p%20q.png is not there"]),
        ("<script src='//cdn.example/x.js'>", ["a.html:1: script from another host: //cdn.example/x.js"]),
        ("<link href='https://f.example'>", ["a.html:1: link from another host: https://f.example"]),
    ],
)
def test_broken_links_are_found(tmp_path: Path, html: str, found: list[str]) -> None:
    (tmp_path / "a.html").write_text(html)
    (tmp_path / "b.html").write_text("<h1 id='there'>b</h1>")
    assert [*broken_links(tmp_path)] == found
