"""The site of ``make site`` from the disk, without a network: it is found in, is as wide as a telephone, and
asks nobody."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

SITE = Path(__file__).parents[2] / "build" / "site"

pytestmark = pytest.mark.skipif(not (SITE / "index.html").exists(), reason="`make site` has not been run")


@pytest.fixture
def page(chromium: Browser) -> Iterator[Page]:
    """A page whose requests to other hosts fail the test."""
    context = chromium.new_context(viewport={"width": 390, "height": 800})
    opened, elsewhere = context.new_page(), list[str]()
    opened.on("request", lambda request: elsewhere.append(request.url))
    yield opened
    context.close()
    assert [url for url in elsewhere if not url.startswith(("file:", "data:"))] == []


def test_a_how_to_is_found_before_decisions(page: Page) -> None:
    page.goto(f"{SITE.as_uri()}/search.html?q=replay")
    found = page.locator("#search-results li > a")
    expect(found.filter(has_text="See afterwards what happened")).to_have_count(1)
    names = found.all_inner_texts()
    decisions = [name for name in names if name[:2].isdigit()]
    assert names.index("See afterwards what happened") < min(map(names.index, decisions))


@pytest.mark.parametrize("name", ["index", "docs/faq", "docs/how-to/runs", "docs/reference"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_fit_a_telephone(page: Page, name: str, scheme: str) -> None:
    page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    page.goto(f"{SITE.as_uri()}/{name}.html")
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    broken = "[...document.images].filter(each => !each.naturalWidth).map(each => each.src)"
    assert page.evaluate(broken) == []
