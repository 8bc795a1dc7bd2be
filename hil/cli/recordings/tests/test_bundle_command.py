"""A bundle gives the same bytes elsewhere, has nothing secret in it, and does no harm when opened."""

import gc
import io
import json
import re
import shutil
import stat
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from hil.cli.bench.new_board import files_of
from hil.cli.framework.command_group import app
from hil.compose.bundles import BundleError, trusts_all
from hil.compose.replay import read_log, replay
from hil.host.doctor import Diagnosis
from hil.recorded.bundling import BundleRefused, bundling
from hil.sim.input_log import InputLogWriter
from hil.sim.inputs import Bytes, Logged
from hil.sim.noted_events import NotedEvent
from hil.sim.reloads import Begun, Reloaded
from hil.testing import Bench, RecordedBench
from hil.vocab.time import SimTimeNs

FOUND = [
    Diagnosis("kernel", "note", "Linux 6.1", "late", "another"),
    Diagnosis("state directory", "ok", "/home/alice/.local/state/hil can be written"),
]
SECRETS = ("alice", "hunter2", "secret.example", "10.11.12.13", "/home", "/dev/", "/etc", "usb-ACME")
PLAIN = {"bench": "one", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}


def hil(*words: object) -> Result:
    return CliRunner().invoke(app, list(map(str, words)))


def recorded(config: Mapping[str, Any], file: Path, drive: Callable[[Bench], object]) -> Path:
    with Bench(config) as bench, file.open("w") as opened:
        drive(bench)
        bench.inputs.write_to(opened)
    return file


def typed(bench: Bench) -> None:
    bench.run(3500)
    for text in (b"y", b"?", b"x"):
        bench.port(next(iter(bench.config.devices))).write(text)
        bench.run(700)


def bundled(log: Path) -> Path:
    file = log.with_suffix(".hilz")
    with file.open("wb") as opened:
        bundling(log, FOUND).write(opened)
    return file


@pytest.fixture
def plain(tmp_path: Path) -> Path:
    return bundled(recorded(PLAIN, tmp_path / "plain.log", typed))


@pytest.fixture
def of_own_board(tmp_path: Path) -> Path:
    """Bundle of a run with a board from a folder that is gone, beside files that are no part of it."""
    board = tmp_path / "home" / "alice" / "boards" / "pinger"
    for name, text in files_of("pinger", "boards").items():
        (board / name).parent.mkdir(parents=True, exist_ok=True)
        (board / name).write_text(text)
    (board / ".env").write_text("PASSWORD=hunter2")
    (board / "server.key").write_text("hunter2")
    (board / "link.py").symlink_to("/etc/passwd")
    config = {"bench": "own", "profile_path": [str(board.parent)], "devices": {"a1": {"profile": "pinger"}}}
    made = bundled(recorded(config, tmp_path / "own.log", typed))
    shutil.rmtree(tmp_path / "home")
    return made


def names_in(bundle: Path) -> list[str]:
    with zipfile.ZipFile(bundle) as packed:
        return packed.namelist()


def text_of(bundle: Path) -> str:
    with zipfile.ZipFile(bundle) as packed:
        return "\n".join(packed.read(name).decode() for name in packed.namelist())


# ---- what it is for ----


def test_it_gives_the_same_bytes_where_the_board_is_not_there(of_own_board: Path) -> None:
    log = read_log(of_own_board, trusts=trusts_all)
    assert [each.data for each in log.sent if each.data != b"pinger\r\n"]
    assert replay(of_own_board, trusts=trusts_all).difference() is None
    assert hil("replay", of_own_board, "--trust").stdout.startswith("identical: ")
    (found,) = json.loads(hil("find", of_own_board, 'a1.received has "?"', "--trust", "--json").stdout)[
        "times"
    ]
    with RecordedBench(of_own_board, found["at_s"] * 1000, trust=True) as bench:
        bench.run(50)
        assert bench.port("a1").read() != b""


def test_the_folder_it_is_unpacked_to_goes_with_it(
    of_own_board: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "unpacked"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    bench = RecordedBench(of_own_board, 100, trust=True)
    (unpacked,) = folder.iterdir()
    assert stat.S_IMODE(unpacked.stat().st_mode) == 0o700
    bench.run(5000)
    bench.close()
    del bench
    gc.collect()
    assert [*folder.iterdir()] == []
    with pytest.raises(BundleError):
        RecordedBench(of_own_board, 100)
    gc.collect()
    assert [*folder.iterdir()] == []


def test_a_bundle_of_a_board_of_hil_needs_no_trust(plain: Path) -> None:
    assert replay(plain).difference() is None
    done = hil("replay", plain)
    assert done.exit_code == 0
    with zipfile.ZipFile(plain) as packed:
        boards = json.loads(packed.read("manifest.json"))["boards"]
        versions = json.loads(packed.read("versions.json"))
    assert boards["mechaduino"]["origin"] == "hil"
    assert re.fullmatch("[0-9a-f]{64}", boards["mechaduino"]["sha256"])
    assert {"hil", "python", "machine", "libraries"} == versions.keys()
    assert "pydantic" in versions["libraries"]


def test_code_of_a_bundle_runs_only_if_somebody_says_so(of_own_board: Path) -> None:
    for words in (["replay"], ["find"]):
        done = hil(*words, of_own_board, *(["a1.sent has 'p'"] if words == ["find"] else []))
        assert done.exit_code == 2
        assert "it has boards of its own (pinger), whose code would run here" in done.stderr
        assert "give --trust" in done.stderr


def test_the_same_content_gives_the_same_bundle(tmp_path: Path) -> None:
    log = recorded(PLAIN, tmp_path / "plain.log", typed)
    one, other = io.BytesIO(), io.BytesIO()
    bundling(log, FOUND).write(one)
    bundling(log, FOUND).write(other)
    assert one.getvalue() == other.getvalue()


def test_what_changes_while_it_is_made_does_not_go_in(tmp_path: Path) -> None:
    log = recorded(PLAIN, tmp_path / "plain.log", typed)
    one, other = io.BytesIO(), io.BytesIO()
    for file, counted in ((one, "5 of 4096 in use"), (other, "6 of 4096 in use")):
        bundling(log, [Diagnosis("ptys", "ok", counted, "", "")]).write(file)
    assert one.getvalue() == other.getvalue()


def test_a_log_that_is_cut_or_damaged_is_bundled_as_far_as_it_is_whole(tmp_path: Path) -> None:
    whole = recorded(PLAIN, tmp_path / "whole.log", typed).read_bytes()
    cut = tmp_path / "cut.log"
    cut.write_bytes(whole[:-200])
    assert replay(bundled(cut)).difference() is None
    assert read_log(cut.with_suffix(".hilz")).cut
    lines = whole.splitlines(keepends=True)
    at = max(index for index, line in enumerate(lines) if b'"sent":"' in line)
    lines[at] = lines[at].replace(b'"sent":"', b'"sent":"00')
    damaged = tmp_path / "damaged.log"
    damaged.write_bytes(b"".join(lines))
    made = read_log(bundled(damaged), strict=False)
    assert made.cut
    assert (
        len(made.sent)
        == len(read_log(damaged, strict=False).sent)
        < len(read_log(tmp_path / "whole.log").sent)
    )


# ---- what goes in ----


def test_nothing_secret_goes_in(of_own_board: Path, tmp_path: Path) -> None:
    config = {
        **PLAIN,
        "bridges": {
            "zenoh": {"connect": ["tls/secret.example:7447"], "listen": [], "insecure": True},
            "modbus": {"listen": "10.11.12.13:1502", "insecure": True},
        },
        "runtime_dir": "/home/alice/run",
        "state_dir": "/home/alice/state",
        "cpu": 1,
    }
    config["devices"] = {
        **PLAIN["devices"],
        "real": {"profile": "sac", "at": "/dev/serial/by-id/usb-ACME_SECRET_1234"},
        "net": {"profile": "sac", "at": "socket://secret.example:4000"},
    }
    log = tmp_path / "secret.log"
    with log.open("w") as file:
        writer = InputLogWriter(file, "hil", config, {"m1": {}})
        writer.end()
    made = bundling(log, FOUND)
    assert {"the real board real", "`bridges` of the configuration"} <= {*made.left_out}
    assert replay(bundled(log)).difference() is None
    for bundle in (log.with_suffix(".hilz"), of_own_board):
        text = text_of(bundle)
        assert [secret for secret in SECRETS if secret in text or secret in str(names_in(bundle))] == []
    assert names_in(of_own_board) == [
        *("manifest.json", "boards/pinger/README.md", "boards/pinger/board.py", "boards/pinger/firmware.py"),
        *("boards/pinger/profile.yaml", "run.log", "versions.json", "doctor.json"),
    ]


def test_it_says_what_would_be_in_it_and_asks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = recorded(PLAIN, tmp_path / "bench.log", typed)
    monkeypatch.chdir(tmp_path)
    done = hil("bundle", log)
    assert done.exit_code == 2
    assert "run.log" in done.stderr
    assert "nothing was written: look at this, and give --yes" in done.stderr
    assert not (tmp_path / "bench.hilz").exists()
    done = hil("bundle", log, "--yes", "--json")
    answer = json.loads(done.stdout)
    assert answer["bundle"] == "bench.hilz"
    assert answer["bytes"] == (tmp_path / "bench.hilz").stat().st_size
    assert answer["files"].keys() == {"run.log", "versions.json", "doctor.json"}
    assert hil("bundle", log, "-o", tmp_path / "other.hilz", "-y").exit_code == 0
    assert (tmp_path / "other.hilz").read_bytes() == (tmp_path / "bench.hilz").read_bytes()
    done = hil("bundle", "bench.hilz", "-y")
    assert (done.exit_code, done.stderr) == (2, "hil: bench.hilz is a bundle already\n")
    done = hil("bundle", log, "-y", "-o", tmp_path / "no" / "where.hilz")
    assert done.exit_code == 2
    assert "there is no folder" in done.stderr


def test_a_file_of_a_board_with_a_name_that_no_bundle_has(tmp_path: Path) -> None:
    board = tmp_path / "boards" / "pinger"
    for name, text in files_of("pinger", "boards").items():
        (board / name).parent.mkdir(parents=True, exist_ok=True)
        (board / name).write_text(text)
    (board / "two words.txt").write_text("")
    config = {"bench": "own", "profile_path": [str(board.parent)], "devices": {"a1": {"profile": "pinger"}}}
    log = recorded(config, tmp_path / "own.log", typed)
    with pytest.raises(BundleRefused, match=r"two words\.txt: no file of a bundle has this name; rename it"):
        bundling(log, FOUND)


# ---- bundles that others have made ----


def forged(bundle: Path, change: Callable[[dict[str, bytes], Any], object], **attributes: int) -> Path:
    """Bundle with files changed, and perhaps attributes of one more, ``extra``."""
    with zipfile.ZipFile(bundle) as packed:
        files = {name: packed.read(name) for name in packed.namelist()}
    manifest = json.loads(files.pop("manifest.json"))
    change(files, manifest)
    made = bundle.with_name("forged.hilz")
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("manifest.json", json.dumps(manifest))
        for name, content in files.items():
            info = zipfile.ZipInfo(name)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = attributes.get("mode", 0o644 | stat.S_IFREG) << 16
            packed.writestr(info, content)
    return made


def put(name: str, content: bytes = b"x") -> Callable[[dict[str, bytes], Any], object]:
    """Put a file into a bundle, as its manifest says."""
    from hashlib import sha256

    def change(files: dict[str, bytes], manifest: Any) -> None:
        files[name] = content
        manifest["files"][name] = {"bytes": len(content), "sha256": sha256(content).hexdigest()}

    return change


@pytest.mark.parametrize(
    "name",
    [
        *(
            "../evil",
            "/tmp/evil",
            "boards/../../evil",
            "boards/./x",
            "C:\\evil",
            "..",
            "boards//x",
            "a\\..\\b",
        ),
        *(
            ".bashrc",
            "boards/.git/config",
            "a" * 200,
            "boards/x/",
            "bo\nards",
            "boards/é",
            "/".join("a" * 30),
        ),
    ],
)
def test_names_that_lead_out_of_its_folder(plain: Path, name: str, tmp_path: Path) -> None:
    with pytest.raises(BundleError, match=r"wants to write .*, which is no plain name within its folder"):
        read_log(forged(plain, put(name)))
    assert not (tmp_path.parent / "evil").exists()
    assert not Path("/tmp/evil").exists()


@pytest.mark.parametrize(
    "kind", [stat.S_IFLNK, stat.S_IFDIR, stat.S_IFCHR, stat.S_IFBLK, stat.S_IFIFO, stat.S_IFSOCK]
)
def test_links_and_devices(plain: Path, kind: int) -> None:
    with pytest.raises(BundleError, match="is a link, a folder or a device, and no file"):
        read_log(forged(plain, lambda files, manifest: None, mode=kind | 0o777))


def set_to(**values: Any) -> Callable[[dict[str, bytes], Any], object]:
    return lambda files, manifest: manifest.update(values)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (set_to(version=2), "it has version 2, of hil .*; this program reads 1"),
        (set_to(version="1"), "it has version '1', of"),
        (set_to(format="zip"), "this zip is no bundle of hil"),
        (set_to(files={}), "is not named by its manifest"),
        (set_to(files=[]), "its manifest: files: "),
        (set_to(more=1), "its manifest: more: "),
        (
            set_to(boards={"pinger": {"origin": "bundle", "sha256": "0" * 64}}),
            "the board 'pinger' is missing",
        ),
        (put("boards/pinger/board.py", b"raise SystemExit"), "it has boards that its manifest does not name"),
        (put("run.log/x"), "run.log is a file and a folder"),
        (lambda files, manifest: files.pop("run.log"), "run.log is missing"),
        (lambda files, manifest: files.update({"extra": b""}), "extra is not named by its manifest"),
        (lambda files, manifest: files.update({"run.log": b"{}\n"}), "run.log has another length"),
        (
            lambda files, manifest: files.update({"run.log": files["run.log"].replace(b"hil", b"lih", 1)}),
            "run.log is damaged: it is not what its manifest says",
        ),
        (lambda files, manifest: manifest["files"]["run.log"].update(bytes=1 << 40), "which is too much"),
        (
            lambda files, manifest: manifest["files"]["run.log"].update(bytes=-1),
            "its manifest: files.run.log.bytes",
        ),
        (put("zeros.bin", bytes(100 << 20)), "would be unpacked to .*, which is too much"),
    ],
)
def test_what_a_bundle_cannot_be(
    plain: Path, change: Callable[[dict[str, bytes], Any], object], said: str
) -> None:
    with pytest.raises(BundleError, match=said) as error:
        read_log(forged(plain, change))
    assert str(error.value).startswith(str(plain.with_name("forged.hilz")))


def test_a_zip_that_is_damaged_anywhere_is_refused_or_gives_the_same_bytes(
    plain: Path, tmp_path: Path
) -> None:
    content, refused = plain.read_bytes(), 0
    then = [each.data for each in read_log(plain).sent]
    file = tmp_path / "damaged.hilz"
    for at in range(4, len(content), 97):
        for damaged in (content[:at], content[:at] + bytes((content[at] ^ 0x55,)) + content[at + 1 :]):
            file.write_bytes(damaged)
            try:
                assert [each.data for each in read_log(file).sent] == then  # a date, or another unused byte
            except BundleError:
                refused += 1
    assert refused > len(content) // 97
    file.write_bytes(b"PK\x03\x04")
    done = hil("replay", file)
    assert done.exit_code == 2
    assert "the bundle is damaged" in done.stderr


def test_a_forged_log_in_a_bundle_finds_no_boards_of_this_computer(
    of_own_board: Path, tmp_path: Path
) -> None:
    """The folder that a log names is not looked into."""
    with zipfile.ZipFile(of_own_board) as packed:
        header = packed.read("run.log").splitlines()[0]
    assert json.loads(header)["config"]["profile_path"] == ["boards"]
    log = read_log(of_own_board, trusts=trusts_all)
    (path,) = log.config["profile_path"]
    assert Path(path).is_dir()
    assert "hil-bundle-" in path


# ---- reloads ----


def reloaded(file: Path, more: Mapping[str, Any]) -> Path:
    """Log of a bench that was reloaded after a second, from then on with further keys."""
    with Bench(PLAIN) as bench, file.open("w") as opened:
        config = {**bench.inputs.log().config}
        writer = InputLogWriter(opened, "hil", config, bench.inputs.log().memories)
        begun = Begun("m1", 0, 1_000_000_000, {})
        writer.add(Reloaded(1_000_000_000, {**config, **more}, ("m1",), (begun,)))
        at_ns = 2_400_000_000
        writer.add(NotedEvent(1, "refusals", at_ns, at_ns, "", "alice", "run: /home/alice/secret.example", 1))
        writer.add(Logged(SimTimeNs(2_500_000_000), "m1", Bytes(b"x")))
        writer.end()
    return file


def test_configurations_of_reloads_are_shared_as_the_first(tmp_path: Path) -> None:
    doors = {"zenoh": {"connect": ["tls/secret.example:7447"], "listen": [], "insecure": True}}
    log = reloaded(tmp_path / "reloaded.log", {"bridges": doors, "state_dir": "/home/alice/state"})
    assert "secret.example" in log.read_text()
    text = text_of(bundled(log))
    assert [secret for secret in SECRETS if secret in text] == []
    read = read_log(log.with_suffix(".hilz"))
    assert [place.reload.at_ns for place in read.reloads] == [1_000_000_000]
    assert len(read.inputs) == 1
    assert [(event.kind, event.who, event.text) for event in read.events] == [("refusals", "", "refusals")]
    assert hil("replay", log).stdout == hil("replay", log.with_suffix(".hilz")).stdout


def test_a_test_begins_before_a_reload(tmp_path: Path) -> None:
    with RecordedBench(reloaded(tmp_path / "reloaded.log", {})) as bench:
        assert bench.end_ms == pytest.approx(1000)
        with pytest.raises(ValueError, match="where the recording ends"):
            bench.follow(2000)
