"""Wheels and source distributions, made of what git tracks."""

import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STRANGE = (
    *("hil/scratch.py", "device_profiles/sac/notes.md", "systemd/hil.service.orig"),
    *("docs/how-to/notes.md", "wireshark/own.lua"),
)


def run(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """The project as git has it, in a repository of its own."""
    if int(version("setuptools").partition(".")[0]) < 77:
        pytest.skip("this setuptools is older than the build's")
    if not (ROOT / ".git").exists() or not shutil.which("git"):
        pytest.skip("this is no checkout")
    listed = run(ROOT, "git", "-c", "safe.directory=*", "ls-files", "-z").stdout
    folder = tmp_path / "checkout"
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).exists():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    run(folder, "git", "init", "-q")
    run(folder, "git", "add", "-A", "-f")
    return folder


def setup(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return run(folder, sys.executable, "setup.py", "-q", *command)


@pytest.mark.thorough
def test_a_file_that_git_does_not_track_is_in_no_wheel(checkout: Path) -> None:
    old = checkout / "out/hil/of_an_earlier_build.py"
    old.parent.mkdir(parents=True)
    old.touch()
    built = setup(checkout, "build_py", "-d", "out")
    assert built.returncode == 0, built.stderr
    assert (checkout / "out/hil/sim/bench.py").exists()
    assert not old.exists()
    for name in STRANGE:
        (checkout / name).write_text("")
    refused = setup(checkout, "build_py", "-d", "out")
    assert refused.returncode == 1
    assert f"git does not track {', '.join(sorted(STRANGE))}: `git add` them" in refused.stderr
    assert not (checkout / "out/hil/scratch.py").exists()


@pytest.mark.thorough
def test_a_source_distribution_is_what_git_tracks(checkout: Path) -> None:
    for name in STRANGE:
        (checkout / name).write_text("")
    made = setup(checkout, "sdist")
    assert made.returncode == 0, made.stderr
    (archive,) = (checkout / "dist").glob("*.tar.gz")
    with tarfile.open(archive) as tar:
        names = {member.name.partition("/")[2] for member in tar if member.isfile()}
    assert {"wireshark/sac_packets.lua", "hil/core/native/hil_core.h", "docs/how-to/package.md"} <= names
    assert not names & set(STRANGE)
    listed = set(filter(None, run(checkout, "git", "ls-files", "-z").stdout.split("\0")))
    assert all(name in listed or ".egg-info/" in name for name in names - {"PKG-INFO", "setup.cfg"})


@pytest.mark.thorough
@pytest.mark.skipif(not shutil.which("dpkg-deb"), reason="needs dpkg-deb")
def test_a_file_that_git_does_not_track_is_in_no_debian_package(checkout: Path) -> None:
    for name in (*STRANGE, "docs/ignored.so"):  # what git ignores is not copied
        (checkout / name).write_text("")
    built = run(checkout, "packaging/deb/build")
    assert built.returncode == 2
    said, *listed = built.stderr.splitlines()
    assert said == "hil: no package was built, git does not track these: `git add` them, or move them away:"
    assert listed == ["docs/how-to/notes.md", "systemd/hil.service.orig", "wireshark/own.lua"]


def data_files() -> dict[str, list[str]]:
    """Files that a wheel has beside its modules, by the folders into which they go."""
    configured = tomllib.loads((ROOT / "pyproject.toml").read_text())
    return dict(configured["tool"]["setuptools"]["data-files"])


def test_an_image_is_built_with_all_that_a_wheel_has() -> None:
    kept = [line[1:] for line in (ROOT / ".dockerignore").read_text().splitlines() if line.startswith("!")]
    for pattern in (each for globs in data_files().values() for each in globs):
        assert pattern in kept or str(Path(pattern).parent) in kept, pattern


def test_what_others_than_python_look_for_is_in_the_wheel() -> None:
    configured = data_files()
    into = {
        f"{folder}/{path.name}"
        for folder, globs in configured.items()
        for g in globs
        for path in ROOT.glob(g)
    }
    shared = re.search(r"^SHARED := (.*)$", (ROOT / "Makefile").read_text(), re.M)
    assert shared
    assert {f"share/{file}" for file in shared[1].split()} <= into
    assert "share/hil/wireshark/sac_packets.lua" in into
    pages = {path.name for path in (ROOT / "docs" / "how-to").glob("*.md")}
    assert {f"share/hil/docs/how-to/{name}" for name in pages} <= into
