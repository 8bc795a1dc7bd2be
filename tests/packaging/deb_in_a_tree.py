"""The Debian package in a tree of its own: ``make test-deb``. As root; where a machine cannot, it is skipped.

The package is installed, used and removed in a copy of the tree, without a network. HIL_DEB: a package that
is built already.
"""

import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent
MINUTES = 60
MAIN_JOB = ROOT / ".ci" / "main_job.py"
USER = ("setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups", "--inh-caps=-all")
ENTER = """
set -e
mount -t proc proc "$1/proc"
mount -t tmpfs tmpfs "$1/dev"
mkdir "$1/dev/pts" "$1/dev/shm"
mount -t devpts -o newinstance,ptmxmode=0666,mode=0620,gid=5 devpts "$1/dev/pts"
ln -s pts/ptmx "$1/dev/ptmx"
for node in null zero urandom random tty; do
    touch "$1/dev/$node"
    mount --bind "/dev/$node" "$1/dev/$node"
done
mount -t tmpfs -o mode=1777 tmpfs "$1/tmp"
ip link set lo up 2>/dev/null || true
tree=$1
shift
exec chroot "$tree" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp LC_ALL=C.UTF-8 \\
    DEBIAN_FRONTEND=noninteractive "$@"
"""


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two versions of the package, the older one first."""
    if os.getuid() != 0:
        pytest.skip("only root can enter a tree")
    for tool in ("debootstrap", "dpkg-deb", "unshare"):
        if not shutil.which(tool):
            pytest.skip(f"no {tool} here")
    folder = tmp_path_factory.mktemp("packages")
    if not os.environ.get("HIL_DEB"):
        subprocess.run([ROOT / "packaging/deb/build"], cwd=ROOT, timeout=10 * MINUTES, check=True)
    newest = max((ROOT / "dist").glob("hil_*.deb"), key=lambda path: path.stat().st_mtime, default=ROOT)
    first = Path(os.environ.get("HIL_DEB") or newest)
    opened = folder / "opened"
    subprocess.run(["dpkg-deb", "-R", first, opened], check=True)
    control = opened / "DEBIAN" / "control"
    control.write_text(re.sub(r"^(Version: .*)$", r"\1+next", control.read_text(), flags=re.M))
    example = opened / "etc/hil/example.yaml"
    example.write_text(example.read_text() + "# of the next version\n")
    second = folder / "next.deb"
    subprocess.run(["dpkg-deb", "--root-owner-group", "-Zgzip", "-b", opened, second], check=True)
    return [first, second]


class Tree:
    """A copy of the tree in which commands run without a network."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def run(self, *command: str, user: bool = False, code: int = 0) -> str:
        """Run a command as root or as nobody, and return its output."""
        within = ["unshare", "--mount", "--net", "--ipc", "--propagation", "private"]
        done = subprocess.run(
            [*within, "sh", "-c", ENTER, "sh", str(self.folder), *(USER if user else ()), *command],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            timeout=5 * MINUTES, check=False,
        )  # fmt: skip
        assert done.returncode == code, f"{command}: exit code {done.returncode}: {done.stdout[-3000:]}"
        return done.stdout

    def files(self) -> set[str]:
        """Files in the tree, but for what dpkg writes down for itself, and caches."""
        own = ("var/lib/dpkg/", "var/cache/", "var/log/", "tmp/", "proc/", "dev/")
        paths = (str(path.relative_to(self.folder)) for path in self.folder.rglob("*"))
        return {path for path in paths if not path.startswith(own) and path not in ("proc", "dev", "tmp")}

    def install(self, package: Path) -> str:
        shutil.copy(package, self.folder / "opt" / "hil.deb")
        try:
            return self.run("dpkg", "--force-confold", "-i", "/opt/hil.deb")
        finally:
            (self.folder / "opt" / "hil.deb").unlink()


@pytest.fixture(scope="module")
def tree(base: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tree]:
    copy = tmp_path_factory.mktemp("tree") / "debian"
    subprocess.run(["cp", "-a", base, copy], check=True)
    yield Tree(copy)
    shutil.rmtree(copy)


def test_installed_without_a_network_it_does_the_main_job_for_a_user_without_rights(
    tree: Tree, packages: list[Path]
) -> None:
    before = tree.files()
    tree.install(packages[0])
    installed = tree.files() - before
    assert "usr/bin/hil" in installed
    assert "usr/share/man/man1/hil.1.gz" in installed
    assert {
        "usr/share/bash-completion/completions/hil",
        "usr/share/zsh/vendor-completions/_hil",
        "usr/share/fish/vendor_completions.d/hil.fish",
        "usr/share/hil/wireshark/sac_packets.lua",
    } <= installed
    for into, folder in (("hil/", "docs/how-to"), ("hil/", "docs/decisions"), ("doc/hil/", "examples")):
        documents = {f"usr/share/{into}{folder}/{path.name}" for path in (ROOT / folder).glob("*.*")}
        assert documents
        assert documents <= installed
    assert (tree.folder / "usr/share/doc/hil/docs").resolve() == tree.folder / "usr/share/hil/docs"
    assert any("/__pycache__/entry.cpython" in path for path in installed)
    assert tree.run("hil", "--version", user=True).startswith("hil ")
    assert "no problems" in tree.run("hil", "check", "/etc/hil/example.yaml", user=True)

    shutil.copy(MAIN_JOB, tree.folder / "opt" / "main_job.py")
    said = tree.run("/usr/lib/hil/bin/python3", "/opt/main_job.py", "/usr/bin/hil", user=True)
    assert said.splitlines()[-1] == "main job from the wheel: ok"
    (tree.folder / "opt" / "main_job.py").unlink()

    assert tree.run("dpkg", "--audit") == ""
    assert tree.run("dpkg", "--verify", "hil") == ""


def test_an_upgrade_keeps_what_was_changed(tree: Tree, packages: list[Path]) -> None:
    example = tree.folder / "etc/hil/example.yaml"
    mine = tree.folder / "etc/hil/bench.yaml"
    changed = example.read_text() + "# mine\n"
    example.write_text(changed)
    mine.write_text(changed)
    tree.install(packages[1])
    assert tree.run("dpkg-query", "-Wf", "${Version}", "hil").endswith("+next")
    assert example.read_text() == changed
    assert (example.with_name("example.yaml.dpkg-dist")).read_text().endswith("# of the next version\n")
    assert tree.run("hil", "--version", user=True).startswith("hil ")


def test_removed_it_leaves_configuration_and_memories_and_purged_only_what_others_wrote(tree: Tree) -> None:
    memory = tree.folder / "var/lib/private/hil/bench/bench/m1.nvm"
    memory.parent.mkdir(parents=True)
    memory.write_bytes(b"memory")
    tree.run("dpkg", "-r", "hil")
    assert not (tree.folder / "usr/lib/hil").exists()
    assert not (tree.folder / "usr/bin/hil").is_symlink()
    assert memory.exists()
    assert {path.name for path in (tree.folder / "etc/hil").iterdir()} >= {"example.yaml", "bench.yaml"}

    tree.run("dpkg", "-P", "hil")
    assert not memory.exists()
    assert [path.name for path in (tree.folder / "etc/hil").iterdir()] == ["bench.yaml"]
    assert tree.run("dpkg-query", "-W", "hil", code=1).startswith("dpkg-query: no packages found")
