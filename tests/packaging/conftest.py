"""A Debian tree, made once (in HIL_TEST_TREE, else ~/.cache/hil-test-deb) from HIL_DEBIAN_MIRROR, or from
where this machine gets its packages."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

CACHE = Path(os.environ.get("HIL_TEST_TREE") or Path.home() / ".cache" / "hil-test-deb")
MINUTES = 60


def mirror() -> str:
    """Address of Debian's packages, as this machine knows it."""
    if os.environ.get("HIL_DEBIAN_MIRROR"):
        return os.environ["HIL_DEBIAN_MIRROR"]
    for path in (Path("/etc/apt/sources.list"), *sorted(Path("/etc/apt/sources.list.d").glob("debian*"))):
        text = path.read_text() if path.exists() else ""
        if found := re.search(r"^(?:deb(?: \[.*?\])?|URIs:)\s+(\S+?/debian)/?\s", text, re.M):
            return found.group(1)
    return "http://deb.debian.org/debian"


def release() -> str:
    return subprocess.run(
        ["sh", "-c", ". /etc/os-release; echo $VERSION_CODENAME"], capture_output=True, text=True, check=True
    ).stdout.strip()


@pytest.fixture(scope="module")
def base() -> Path:
    """A Debian with Python, from which copies are made."""
    tree = CACHE / release()
    if not (tree / "complete").exists():
        shutil.rmtree(tree, ignore_errors=True)
        tree.parent.mkdir(parents=True, exist_ok=True)
        include = "--include=python3,init-system-helpers,adduser"
        made = subprocess.run(
            ["debootstrap", "--variant=minbase", include, release(), tree, mirror()],
            capture_output=True, text=True, timeout=20 * MINUTES, check=False,
        )  # fmt: skip
        if made.returncode:
            pytest.skip(f"no Debian tree: {made.stdout.splitlines()[-1:]}")
        (tree / "complete").touch()
    return tree
