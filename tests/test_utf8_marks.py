"""Files that a Windows editor saved, with the mark of UTF-8 at the beginning: every reader takes them."""

from pathlib import Path

from bridges.zenoh.users import read_users as read_zenoh_users
from device_profiles.sac.companion_files import read_one_shot
from hil.cli.bench.serve_command import read_config
from hil.cli.boards.draw_commands import _train
from hil.compose import read_text

MARK = "\ufeff"


def marked(folder: Path, text: str, name: str = "file") -> Path:
    path = folder / name
    path.write_text(MARK + text, encoding="utf-8")
    path.chmod(0o600)
    return path


def test_texts_and_configurations(tmp_path: Path) -> None:
    path = marked(tmp_path, "bench: t\ndevices: {m1: {profile: mechaduino}}\n", "b.yaml")
    assert read_text(path).startswith("bench")
    assert read_config(path).bench == "t"


def test_a_pulse_train(tmp_path: Path) -> None:
    assert len(_train(marked(tmp_path, "at_s,steps,duration_s\r\n0,10,0.1\r\n"), None, 1.0, None)) > 0


def test_users_of_doors(tmp_path: Path) -> None:
    (user,) = read_zenoh_users(marked(tmp_path, "anna:operator:" + "x1" * 16 + "\n"))
    assert user.name == "anna"


def test_a_file_of_the_companion() -> None:
    assert read_one_shot((MARK + "m100\r\n").encode(), "x", 1) == "m100"
