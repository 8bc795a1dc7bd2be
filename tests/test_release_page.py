"""The page of a release: what is in it, how it was made, and how to check it; sources packed again."""

import hashlib
import importlib.util
import io
import subprocess
import sys
import tarfile
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def release() -> ModuleType:
    spec = importlib.util.spec_from_file_location("release", ROOT / "packaging/release.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules["release"] = module  # its dataclasses look there
    spec.loader.exec_module(module)
    return module


def test_each_file_is_listed_with_its_checksum_and_how_it_was_made(
    release: ModuleType, tmp_path: Path
) -> None:
    wheel = tmp_path / "hil_motion-0.2.0-cp311-cp311-manylinux_2_34_x86_64.whl"
    wheel.write_bytes(b"wheel")
    deb = tmp_path / "hil_0.2.0-1_amd64.deb"
    deb.write_bytes(b"deb")
    facts = release.read_facts([f"{wheel.name}|Python 3.11.2|gcc 12.2.0|auditwheel 6.8\n"])
    files = [
        release.Made(wheel, release.audience_of(wheel.name), "packaging/build-wheels", facts[wheel.name]),
        release.Made(deb, "Debian 12", "packaging/deb/build", "that wheel"),
    ]
    text = release.page(release.Source("0.2.0", "c0ffee", 1_700_000_000, "84.0", "3.1.2"), files)
    for each in (wheel, deb):
        assert f"`{hashlib.sha256(each.read_bytes()).hexdigest()}`" in text
    assert "CPython 3.11, Linux x86_64, glibc 2.34 or newer" in text
    assert "Python 3.11.2, gcc 12.2.0, auditwheel 6.8" in text
    assert "of commit `c0ffee`, 2023-11-14" in text.lower()
    assert f"$ pip install './{wheel.name}[plot]'" in text
    assert f"$ sudo apt install ./{deb.name}" in text
    assert "setuptools==84.0\\nCython==3.1.2\\n" in text


@pytest.mark.parametrize("seed", [1, 2])
def test_sources_are_packed_to_the_same_bytes(release: ModuleType, tmp_path: Path, seed: int) -> None:
    def packed(times: int, order: int) -> bytes:
        archive = tmp_path / "made.tar.gz"
        with tarfile.open(archive, "w:gz") as tar:
            for name in ("hil/a.py", "hil/b.sh")[::order]:
                member = tarfile.TarInfo(name)
                member.size, member.mtime, member.uid, member.uname = 3, times, times, str(times)
                member.mode = 0o700 if name.endswith("sh") else 0o600
                tar.addfile(member, io.BytesIO(b"abc"))
        release.pack_again(archive, tmp_path / "again.tar.gz", 1_700_000_000)
        return (tmp_path / "again.tar.gz").read_bytes()

    once = packed(1_600_000_000 + seed, 1)
    assert packed(1_650_000_000 + seed, -1) == once
    with tarfile.open(tmp_path / "again.tar.gz") as tar:
        assert [(each.name, each.mode, each.mtime) for each in tar] == [
            ("hil/a.py", 0o644, 1_700_000_000),
            ("hil/b.sh", 0o755, 1_700_000_000),
        ]


def test_a_release_is_refused_where_something_is_changed(release: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "packaging").mkdir()
    (tmp_path / "packaging/release.py").write_bytes((ROOT / "packaging/release.py").read_bytes())
    subprocess.run(["git", "init", "-q"], cwd=tmp_path, check=True)
    done = subprocess.run(
        [sys.executable, "packaging/release.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "this checkout has changes; commit them:\n?? packaging/" in done.stderr


def test_a_release_leaves_a_folder_of_others_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    done = subprocess.run(
        [sys.executable, ROOT / "packaging/release.py", tmp_path], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr == (
        f"hil: no release was made: {tmp_path} has other files in it; name an empty or a new folder\n"
    )
    assert (tmp_path / "thesis.txt").exists()


def test_a_wheel_says_for_which_systems_it_is(release: ModuleType) -> None:
    assert (
        release.audience_of("hil_motion-1.0-cp314-cp314-linux_aarch64.whl") == "CPython 3.14, Linux aarch64"
    )
