"""The container's image, built and run without any rights: ``make test-container``. As root, with buildah and
podman; where a machine cannot, it is skipped.

The base image is made from a Debian tree, so that no registry is asked; HIL_BASE_IMAGE: another one. pip is
set up in the build as it is here.
"""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from configparser import ConfigParser
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import serial

ROOT = Path(__file__).parent.parent.parent
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / ".ci")]

from e2e_support import until  # noqa: E402
from main_job import work  # noqa: E402

pytestmark = pytest.mark.filterwarnings("ignore:set(Daemon|Name)")  # pyserial 3.5 of its threads
MINUTES = 60
IMAGE, NAME = "localhost/hil-under-test", "hil-under-test"
TCP, RFC2217 = 45101, 45102
BENCH = f"""\
bench: box
speed: 20
devices:
  m1: {{profile: mechaduino, port: {{kind: tcp, listen: 0.0.0.0:{TCP}}}}}
  m2: {{profile: mechaduino, port: {{kind: rfc2217, listen: 0.0.0.0:{RFC2217}}}}}
  m3: {{profile: mechaduino}}
"""
WITHOUT_RIGHTS = (
    *("--read-only", "--cap-drop", "all", "--security-opt", "no-new-privileges", "--tmpfs", "/tmp"),
    *("--network", "host", "--ulimit", "nofile=1024:1024", "--ulimit", "nproc=1000:1000"),
)
ENGINES = ((), ("--runtime", "runc", "--cgroup-manager", "cgroupfs"))
"""podman as it is set up, and as it runs beside control groups of both versions."""
CERTIFICATES = Path(os.environ.get("PIP_CERT") or "/etc/ssl/certs/ca-certificates.crt")
IN_BUILD = "/etc/ssl/of-the-host.crt"
PIP_ARGUMENTS = ("PIP_INDEX_URL", "PIP_EXTRA_INDEX_URL", "PIP_FIND_LINKS")


class Containers:
    """buildah and podman with a store of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.engine: tuple[str, ...] = ()
        config = folder / "storage.conf"
        config.write_text(
            f'[storage]\ndriver = "vfs"\ngraphroot = "{folder}/root"\nrunroot = "{folder}/run"\n'
        )
        self.env = os.environ | {"CONTAINERS_STORAGE_CONF": str(config)}

    def run(self, *command: str, check: bool = True) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            command, cwd=ROOT, env=self.env, capture_output=True, text=True, timeout=10 * MINUTES, check=False
        )
        assert not check or done.returncode == 0, f"{command}: {done.stderr[-3000:]}"
        return done

    def podman(self, *command: str, check: bool = True) -> subprocess.CompletedProcess[str]:
        return self.run("podman", *self.engine, *command, check=check)

    def inside(self, *command: str) -> str:
        """Run a command in the running container, and return its output."""
        return self.podman("exec", NAME, *command).stdout

    def status(self) -> dict[str, Any]:
        done = self.podman("exec", NAME, "hil", "status", "--json", check=False)
        return dict(json.loads(done.stdout)) if done.returncode == 0 else {}


@pytest.fixture(scope="module")
def image(base: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Containers]:
    """The image, built; podman runs containers of it."""
    if os.getuid() != 0:
        pytest.skip("only root has what a build needs here")
    for tool in ("buildah", "podman"):
        if not shutil.which(tool):
            pytest.skip(f"no {tool} here")
    made = Containers(tmp_path_factory.mktemp("containers"))
    base_image = os.environ.get("HIL_BASE_IMAGE", "")
    if not base_image:
        base_image = "localhost/hil-base"
        container = made.run("buildah", "from", "scratch").stdout.strip()
        made.run("buildah", "add", "-q", container, str(base), "/")
        made.run("buildah", "commit", "-q", container, base_image)
        made.run("buildah", "rm", container)
    options = [f"--volume={pip_settings(made.folder)}:/etc/pip.conf:ro"]
    options += [f"--volume={CERTIFICATES}:{IN_BUILD}:ro"] if CERTIFICATES.exists() else []
    options += [f"--build-arg={name}" for name in PIP_ARGUMENTS if name in os.environ]
    made.run(
        *("buildah", "bud", "--isolation", "chroot", "--layers=false", f"--build-arg=BASE={base_image}"),
        *(*options, "-f", "packaging/Containerfile", "-t", IMAGE, "."),
    )
    for made.engine in ENGINES:
        tried = made.podman("run", "--rm", *WITHOUT_RIGHTS, IMAGE, "--version", check=False)
        if tried.returncode == 0:
            break
    else:
        pytest.skip(f"built, but podman runs nothing here: {tried.stderr.strip()}")
    yield made
    shutil.rmtree(made.folder, ignore_errors=True)


def pip_settings(folder: Path) -> Path:
    """A file with pip's settings on this machine, but for the place of the certificates."""
    settings = ConfigParser(interpolation=None)
    home = Path.home()
    settings.read([Path("/etc/pip.conf"), home / ".pip" / "pip.conf", home / ".config" / "pip" / "pip.conf"])
    if CERTIFICATES.exists():
        settings.read_dict({"global": {"cert": IN_BUILD}})
    with (folder / "pip.conf").open("w") as file:
        settings.write(file)
    return folder / "pip.conf"


@pytest.fixture(scope="module")
def container(image: Containers) -> Iterator[Containers]:
    """A bench that runs in a container of its own."""
    bench = image.folder / "bench.yaml"
    bench.write_text(BENCH)
    bench.chmod(0o644)
    image.podman(
        *(
            "run",
            "--detach",
            "--name",
            NAME,
            *WITHOUT_RIGHTS,
            f"--volume={bench}:/etc/hil/bench.yaml:ro",
            IMAGE,
        )
    )
    try:
        until(lambda: image.status().get("sim_ns", 0) > 5_000_000_000, "the bench in the container", 60)
        yield image
    finally:
        with suppress(subprocess.TimeoutExpired):
            image.podman("rm", "--force", "--time", "0", NAME, check=False)


@pytest.mark.parametrize("url", [f"socket://127.0.0.1:{TCP}", f"rfc2217://127.0.0.1:{RFC2217}"])
def test_a_client_outside_does_the_main_job(container: Containers, url: str) -> None:
    with serial.serial_for_url(url, 115200, timeout=0.1) as port:
        work(port)


def test_it_has_no_rights_and_a_root_that_cannot_be_written(container: Containers) -> None:
    status = dict(line.split(":\t", 1) for line in container.inside("cat", "/proc/1/status").splitlines())
    assert status["Uid"].split() == ["10001"] * 4
    assert {status[name] for name in ("CapPrm", "CapEff", "CapBnd", "CapAmb")} == {"0" * 16}
    assert status["NoNewPrivs"] == "1"
    refused = container.podman("exec", NAME, "touch", "/opt/hil/x", check=False)
    assert "Read-only file system" in refused.stderr


def test_a_pty_is_for_programs_in_the_container(container: Containers) -> None:
    address = next(row["address"] for row in container.status()["devices"] if row["device"] == "m3")
    client = f"import serial; s = serial.Serial('{address}', timeout=5); s.write(b'p'); print(s.read_until())"
    assert "stepNumber" in container.inside("/opt/hil/bin/python3", "-c", client)
    assert not Path(address).exists()


def test_memories_stay_in_their_volume(container: Containers) -> None:
    kept = container.inside("ls", "/var/lib/hil/box").split()
    assert [name for name in kept if name != "recordings"] == ["m1.nvm", "m2.nvm"]  # both were calibrated


def test_it_ends_when_it_is_told(container: Containers) -> None:
    container.podman("stop", "--time", "20", NAME)
    assert container.podman("inspect", "--format", "{{.State.ExitCode}}", NAME).stdout.strip() == "0"
