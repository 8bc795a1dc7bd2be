"""``hil plot``, ``step`` and ``drive`` against a running daemon."""

import csv
import itertools
import json
import re
import sys
from pathlib import Path

import pytest
from e2e_support import Place, config, until
from typer.testing import CliRunner

from hil.cli.framework.command_group import app

HOLDING = {"m1": {}}


def numbers(path: Path) -> list[dict[str, float]]:
    with path.open() as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def test_step_plot_and_drive(place: Place, tmp_path: Path) -> None:
    server = place.serve(config(speed=2)).ready()
    text = place.hil("step", "m1", "90")
    figures = re.search(
        r"step of (\S+) deg: rise (\S+) ms .* overshoot (\S+) %, settled after (\S+) ms", text
    )
    assert figures
    amplitude, rise_ms, overshoot_pct, settling_ms = map(float, figures.groups())
    assert abs(amplitude - 90) < 0.2
    assert 15 < rise_ms < 30
    assert 3 < overshoot_pct < 8
    assert 40 < settling_ms < 80
    assert "u [count]" in text

    place.hil("step", "m1", "-45.5", "-o", str(tmp_path / "step.csv"))
    rows = numbers(tmp_path / "step.csv")
    assert abs(rows[-1]["r"] - rows[0]["r"] + 45.5) < 0.02
    assert {round(b["at_ns"] - a["at_ns"]) for a, b in itertools.pairwise(rows)} == {250_000}

    text = place.hil(
        *("pulses", "m1", "--steps", "-3200", "--rate", "200000", "-o", str(tmp_path / "drive.csv"))
    )
    assert "3,200 steps in 0.016 s" in text
    rows = numbers(tmp_path / "drive.csv")
    assert abs(rows[-1]["r"] - rows[0]["r"] + 180) < 0.01
    assert abs(rows[-1]["e"]) < 1

    train = tmp_path / "train.csv"
    train.write_text("at_s,steps,duration_s\n0,32,0.01\n0.02,-32,0.01\n")
    assert "64 steps in 0.03 s" in place.hil("pulses", "m1", "--file", str(train))
    assert "no train" in place.hil("pulses", "m1", "--stop")
    for name in ("p.png", "p.svg"):
        place.hil("plot", "m1", "--signals", "e,current_a_A", "--seconds", "0.1", "-o", str(tmp_path / name))
        assert (tmp_path / name).stat().st_size > 5000
    until(lambda: server.ask("status")["devices"][0]["failed"] is None, "the device")


def test_what_swings_is_drawn_as_it_is(place: Place, tmp_path: Path) -> None:
    """A coil current of 50 Hz, whose size samples of a millisecond miss, too."""
    place.serve(config(speed=2)).ready()
    place.hil("axis", "m1", "enable")
    place.hil("axis", "m1", "velocity", "60")
    place.hil("axis", "m1", "velocity", "60")  # it turns
    file = tmp_path / "swings.csv"
    text = place.hil("plot", "m1", "--signals", "current_a_A", "--seconds", "2", "-o", str(file))
    assert text.splitlines()[-1] == "min/max of each 1 ms"
    head, *lines = file.read_text().splitlines()
    assert head == "at_ns,current_a_A,sampling"
    assert {line.rpartition(",")[2] for line in lines} == {"min/max of each 1 ms"}
    rows = [(float(at_ns), float(value)) for at_ns, value, _ in (line.split(",") for line in lines)]
    last_s = [at_ns / 1e9 for at_ns, _ in rows if at_ns >= rows[-1][0] - 1e9]
    assert len(last_s) == pytest.approx(2000, abs=4)
    ups = [later[0] for row, later in itertools.pairwise(rows[-2000:]) if row[1] < 0 <= later[1]]
    assert (len(ups) - 1) / (ups[-1] - ups[0]) * 1e9 == pytest.approx(50, rel=0.03)

    said = place.cli("plot", "m1", "--signals", "e", "--seconds", "0.05", "--interval", "5", "--json")
    answer = json.loads(said[said.index("{") :])
    assert (answer["interval_ns"], answer["points"]) == (5_000_000, 1)
    assert {round(after[0] - row[0]) for row, after in itertools.pairwise(answer["rows"])} == {5_000_000}


def test_a_step_into_a_pulse_train_is_no_success(place: Place) -> None:
    place.serve(config(speed=2)).ready()
    place.hil("axis", "m1", "enable")
    place.hil("pulses", "m1", "--steps", "100000", "--rate", "100")
    text = place.hil("step", "m1", "45", code=1)
    assert (
        f"another motion is under way; end it (`hil --runtime-dir {place.runtime} pulses m1 --stop`" in text
    )
    assert "settled" not in text


def test_what_cannot_be_drawn_says_why(place: Place, tmp_path: Path) -> None:
    others = {"s1": {"profile": "sac", "flash": {}}, "d1": {"profile": "modbus_drive", "port": None}}
    place.serve(config(speed=4, devices={"m1": {"flash": {"table": "empty"}}, **others})).ready()
    assert "step` is for boards with a servo loop" in place.hil("step", "s1", "9", code=1)
    assert "d1 has no terminal, at which " in place.hil("step", "d1", "9", code=1)
    said = place.hil("plot", "m1", "--signals", "yv", code=2)
    assert re.search(
        r'no signal .yv.; did you mean "\w+"\? there are position_deg, .*, yw, .*, following, .*\bdir\b', said
    )
    assert "no device 'm2'" in place.hil("plot", "m2", code=2)
    assert "write a name that ends in" in place.hil("plot", "m1", "-o", "x.gif", code=2)
    assert "there is no folder" in place.hil("plot", "m1", "-o", str(tmp_path / "no" / "x.csv"), code=2)
    assert "write 50us or more" in place.hil("plot", "m1", "--interval", "0.001", code=2)
    assert "give one of" in place.hil("pulses", "m1", code=2)
    assert "a rate of 1000000 Hz" in place.hil("pulses", "m1", "--steps", "1", "--rate", "1e6", code=2)
    train = tmp_path / "train.csv"
    train.write_text("at_s,steps,duration_s\n1,1,1\n1.5,1,1\n2,0.5,1\n")
    text = place.hil("pulses", "m1", "--file", str(train), code=2)
    places = [word for word in text.split() if word.startswith(f"{train}:")]
    assert [place[len(str(train)) :].split(":")[1] for place in places] == ["3", "4"]
    said = place.hil("step", "m1", "90", code=1)  # and no drawing
    assert said.startswith("hil: m1: the look-up table is empty; calibrate it first: `hil ")
    assert said.endswith("axis m1 calibrate`\n")


@pytest.mark.parametrize("words", [["plot", "m1"], ["step", "m1", "9"], ["pulses", "m1", "--stop"]])
def test_a_picture_that_cannot_be_drawn_is_refused_before_anything_moves(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No bench runs here: the refusal comes before one is looked for."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    done = CliRunner().invoke(app, [*words, "--runtime-dir", str(tmp_path), "-o", str(tmp_path / "x.png")])
    assert done.exit_code == 2
    assert "pip install 'hil-motion[plot]', or name a file .csv" in done.output


def test_the_control_socket_refuses_bad_trains_and_watches(place: Place) -> None:
    server = place.serve(config()).ready()
    control = server.control
    import socket

    def ask(**request: object) -> dict[str, object]:
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(10)
            client.connect(str(control))
            client.sendall(json.dumps(request).encode() + b"\n")
            answer: dict[str, object] = json.loads(client.makefile("rb").readline())
            return answer

    for train in (
        [[0, "D9", 0, 0, 0]],
        [[0, "step", 2, 0, 0]],
        [[0, "step", 0, 5, 9]],
        [[5, "dir", 0, 0, 0], [4, "dir", 1, 0, 0]],
        [[-1, "dir", 0, 0, 0]],
        [[0]],
        "x",
        [[0, "step", 0, -1, 0]],
        [[1 << 70, "step", 0, 0, 0]],
    ):
        assert ask(verb="drive", device="m1", train=train)["ok"] is False
    assert ask(verb="samples", watch=77)["ok"] is False
    assert ask(verb="watch", device="m1", signals=["nothing"], interval_ns=10**6)["ok"] is False
    assert ask(verb="watch", device="m1", signals=["r"], interval_ns=0)["ok"] is False
    assert ask(verb="send", device="m1", data="zz")["ok"] is False
    assert ask(verb="status")["ok"] is True
