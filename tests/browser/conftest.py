"""Tests of the page in a browser. Their helpers are in ``browser_pages.py``."""

import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out
sys.path.insert(0, str(Path(__file__).parents[1]))

from browser_pages import PATIENCE_MS
from playwright.sync_api import Browser, expect, sync_playwright


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    """One Chromium for all tests of a worker; each page of theirs has a profile of its own."""
    if (executable := shutil.which("chromium")) is None:
        pytest.skip("chromium is missing: sudo apt install chromium")
    expect.set_options(timeout=PATIENCE_MS)
    # Names of *.test lead to this computer, as those of a site do that rebinds its name.
    arguments = [
        "--host-resolver-rules=MAP *.test 127.0.0.1",
        *(["--no-sandbox"] if os.getuid() == 0 else []),
    ]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=arguments)
        yield browser
        browser.close()
