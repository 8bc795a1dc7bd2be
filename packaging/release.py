"""Makes what a release consists of, and the text of its page: release.py [FOLDER], by default dist/release

Of a checkout without changes: wheels of each CPython that is here, the source distribution, and on Debian
its package; ``SHA256SUMS`` of them; ``RELEASE.md``, which says how each was made and how to check it. The
clock of all that is built is the commit's.
"""

import gzip
import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
DEBIAN_PYTHON = "/usr/bin/python3"


@dataclass(frozen=True, slots=True)
class Source:
    """The commit that is released, and the packages that build it."""

    version: str
    commit: str
    epoch_s: int
    """Time of the commit, and of all that is in the files."""
    setuptools: str
    cython: str

    @property
    def date(self) -> str:
        return time.strftime("%Y-%m-%d", time.gmtime(self.epoch_s))


@dataclass(frozen=True, slots=True)
class Made:
    """One file of a release."""

    path: Path
    audience: str
    """Systems that it is for."""
    command: str
    with_what: str

    @property
    def digest(self) -> str:
        return hashlib.sha256(self.path.read_bytes()).hexdigest()


def pack_again(archive: Path, into: Path, epoch_s: int) -> None:
    """Write an archive whose bytes depend on its files alone: sorted, of nobody, with one time."""
    with (
        tarfile.open(archive) as old,
        into.open("wb") as file,
        gzip.GzipFile("", "wb", 9, file, mtime=epoch_s) as packed,
        tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as new,
    ):
        for member in sorted(old.getmembers(), key=lambda each: each.name):
            member.uid = member.gid = 0
            member.uname = member.gname = ""
            member.mtime, member.pax_headers = epoch_s, {}
            member.mode = 0o755 if member.isdir() or member.mode & 0o100 else 0o644
            new.addfile(member, old.extractfile(member) if member.isfile() else None)


def read_facts(lines: Iterable[str]) -> dict[str, str]:
    """Words about each wheel, by its name, of the lines that ``build-wheels`` writes."""
    split = (line.strip().split("|", 1) for line in lines if "|" in line)
    return {name: rest.replace("|", ", ") for name, rest in split}


def built_by(wheel: Path) -> tuple[str, str]:
    """Versions of setuptools and Cython, as a wheel has them in itself."""
    with zipfile.ZipFile(wheel) as files:
        about = next(name for name in files.namelist() if name.endswith(".dist-info/WHEEL"))
        setuptools = re.search(r"^Generator: .*?setuptools \((.*)\)", files.read(about).decode(), re.M)
        native = next(name for name in files.namelist() if name.startswith("hil/core/_native."))
        cython = re.search(rb"_cython_(\d+_\d+_\d+\w*)", files.read(native))
    return setuptools[1] if setuptools else "?", cython[1].decode().replace("_", ".") if cython else "?"


def audience_of(wheel: str) -> str:
    """Systems that a wheel of this name is for."""
    parts = re.search(r"-cp(\d)(\d+)-cp\d+-(?:manylinux_(\d+)_(\d+)|linux)_(\w+)\.whl$", wheel)
    if not parts:
        return "Linux"
    glibc = f", glibc {parts[3]}.{parts[4]} or newer" if parts[3] else ""
    return f"CPython {parts[1]}.{parts[2]}, Linux {parts[5]}{glibc}"


def page(source: Source, files: list[Made]) -> str:
    """Text of a release's page, in Markdown."""
    wheels = [each.path.name for each in files if each.path.suffix == ".whl"]
    debs = [each.path.name for each in files if each.path.suffix == ".deb"]
    rows = [f"| `{e.path.name}` | {e.audience} | {e.path.stat().st_size:,} | `{e.digest}` |" for e in files]
    how = [f"| `{e.path.name}` | `{e.command}` | {e.with_what} |" for e in files]
    install = [f"pip install './{wheels[0]}[plot]'", f"pipx install ./{wheels[0]}"] if wheels else []
    install += [f"uvx --from ./{wheels[0]} hil --version"] if wheels else []
    install += [f"sudo apt install ./{name}" for name in debs]
    return "\n".join(
        [
            f"# hil {source.version}",
            "",
            f"Of commit `{source.commit}`, {source.date}. CHANGELOG.md says what is new.",
            "",
            "| file | for | bytes | SHA-256 |",
            "|---|---|---|---|",
            *rows,
            "",
            "## Install",
            "",
            "A wheel and the Debian package need no compiler.",
            "Take the wheel of your Python (`python3 --version`).",
            "",
            "```console",
            *(f"$ {line}" for line in install),
            "```",
            "",
            "## Check what you have loaded",
            "",
            "```console",
            "$ sha256sum --check --ignore-missing SHA256SUMS",
            "```",
            "",
            "## How they were made",
            "",
            f"In a clone of that commit, with `SOURCE_DATE_EPOCH={source.epoch_s}`,"
            f" setuptools {source.setuptools} and Cython {source.cython}.",
            "Each wheel was installed in a venv without a compiler, and did the main job there: a board is",
            "calibrated and moved over its port.",
            "",
            "| file | command | with |",
            "|---|---|---|",
            *how,
            "",
            "Make them again with the same compiler and packages, and compare:",
            "",
            "```console",
            f"$ git checkout {source.commit}",
            f"$ printf 'setuptools=={source.setuptools}\\nCython=={source.cython}\\n' > /tmp/made-with.txt",
            "$ PIP_CONSTRAINT=/tmp/made-with.txt PIP_BUILD_CONSTRAINT=/tmp/made-with.txt make release",
            "$ cat dist/release/SHA256SUMS",
            "```",
            "",
        ]
    )


def output(*command: str, cwd: Path = ROOT) -> str:
    return subprocess.run(command, cwd=cwd, check=True, capture_output=True, text=True).stdout.strip()


def say(number: int, text: str) -> None:
    print(f"[{number}/4] {text}", flush=True)


def make_wheels(clone: Path, into: Path) -> list[Made]:
    facts = into / "facts"
    facts.touch()
    subprocess.run(
        [clone / "packaging/build-wheels", into], check=True, env=os.environ | {"HIL_WHEEL_FACTS": str(facts)}
    )
    known = read_facts(facts.read_text().splitlines())
    facts.unlink()
    return [
        Made(path, audience_of(path.name), "packaging/build-wheels", known.get(path.name, "?"))
        for path in sorted(into.glob("*.whl"))
    ]


def make_sdist(clone: Path, into: Path, source: Source, venv: Path) -> Made:
    """Build a source distribution with the setuptools of the wheels."""
    subprocess.run([sys.executable, "-m", "venv", venv], check=True)
    python = venv / "bin" / "python"
    wanted = [f"setuptools=={source.setuptools}", f"Cython=={source.cython}"]
    subprocess.run([python, "-m", "pip", "install", "-q", "--disable-pip-version-check", *wanted], check=True)
    call = "import sys; from setuptools import build_meta; build_meta.build_sdist(sys.argv[1])"
    subprocess.run([python, "-c", call, venv], cwd=clone, check=True, capture_output=True)
    (archive,) = venv.glob("*.tar.gz")
    pack_again(archive, into / archive.name, source.epoch_s)
    text = "packed again with one time and no owner"
    return Made(into / archive.name, "all; needs gcc and the headers of Python", "packaging/release.py", text)


def make_deb(clone: Path, into: Path, wheels: list[Made]) -> Made | None:
    """Build the package for this Debian; None where it cannot be."""
    if not (shutil.which("dpkg-shlibdeps") and Path(DEBIAN_PYTHON).exists()):
        return None
    tag = output(DEBIAN_PYTHON, "-c", "import sys; print('-cp%d%d-' % sys.version_info[:2])")
    wheel = next((each for each in wheels if tag in each.path.name), None)
    if wheel is None:
        return None
    subprocess.run([clone / "packaging/deb/build", wheel.path], check=True)
    (made,) = (clone / "dist").glob("*.deb")
    shutil.move(made, into / made.name)
    release = output("sh", "-c", '. /etc/os-release; echo "$PRETTY_NAME"')
    return Made(into / made.name, release, f"packaging/deb/build {wheel.path.name}", "that wheel, dpkg-dev")


def prepare(into: Path) -> tuple[str, int]:
    """Refuse what cannot become a release; returns the commit and its time, in s since 1970."""
    if into.exists() and any(into.iterdir()) and not (into / "RELEASE.md").exists():
        sys.exit(f"hil: no release was made: {into} has other files in it; name an empty or a new folder")
    into.parent.mkdir(parents=True, exist_ok=True)
    if not os.access(into.parent, os.W_OK):
        sys.exit(f"hil: no release was made: {into.parent} cannot be written; name another folder")
    try:
        changed = output("git", "status", "--porcelain")
    except FileNotFoundError:
        sys.exit("hil: no release was made: git is missing: sudo apt install git")
    if changed:
        sys.exit(f"hil: a release is of a commit, and this checkout has changes; commit them:\n{changed}")
    return output("git", "rev-parse", "HEAD"), int(output("git", "log", "-1", "--format=%ct"))


def make(commit: str, epoch_s: int, work: Path) -> Path:
    """Make all files in a folder to work in; returns where they are."""
    clone, into = work / "clone", work / "release"
    into.mkdir()
    output("git", "-c", "safe.directory=*", "clone", "-q", "--no-local", str(ROOT), str(clone))
    output("git", "checkout", "-q", commit, cwd=clone)
    say(1, "wheels, each tried without a compiler: a minute each on idle cores")
    wheels = make_wheels(clone, into)
    version = wheels[0].path.name.split("-")[1]
    source = Source(version, commit, epoch_s, *built_by(wheels[0].path))
    say(2, "the source distribution")
    sdist = make_sdist(clone, into, source, work / "venv")
    say(3, "the Debian package")
    deb = make_deb(clone, into, wheels)
    if deb is None:
        print("left out: this needs Debian, dpkg-dev, and a wheel of its python3")
    say(4, "RELEASE.md and SHA256SUMS")
    files = [*wheels, sdist, *([deb] if deb else [])]
    (into / "SHA256SUMS").write_text("".join(f"{each.digest}  {each.path.name}\n" for each in files))
    (into / "RELEASE.md").write_text(page(source, files))
    return into


def main() -> None:
    into = Path(sys.argv[1] if sys.argv[1:] else ROOT / "dist" / "release").resolve()
    commit, epoch_s = prepare(into)
    os.environ |= {"SOURCE_DATE_EPOCH": str(epoch_s), "PYTHONHASHSEED": "0"}
    os.umask(0o022)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.default_int_handler)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        os.environ["TMPDIR"] = folder  # what is interrupted leaves nothing
        made = make(commit, epoch_s, Path(folder))
        # A release that was there stays until there is a whole one.
        shutil.rmtree(into, ignore_errors=True)
        shutil.copytree(made, into)
    print(into / "RELEASE.md")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("\nhil: no release was made: interrupted; nothing was changed")
    except OSError as error:
        sys.exit(f"hil: no release was made: {error.filename or 'a file'}: {error.strerror}; see to that")
    except subprocess.CalledProcessError as error:
        said = (error.stderr or b"").strip()
        what = " ".join(map(str, error.cmd))
        text = said if isinstance(said, str) else said.decode(errors="replace")
        sys.exit(f"hil: no release was made, this failed: {what}\n{text}".rstrip())
