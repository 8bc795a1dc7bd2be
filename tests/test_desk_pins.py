"""The desk of a bench with an Arduino, which has pins and no motor, and a driver that they step."""

from pathlib import Path

from desk_support import Asking, desk_in, refusal

from hil.net.answers import misfit

ROOT = Path(__file__).parents[1]
CONFIG = (ROOT / "examples/easydriver.yaml").read_text()


def test_pins_and_drivers_are_at_the_desk(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        for verb in ("status", "list"):
            answer = await ask(verb)
            assert misfit(verb, answer) == ""
        rows = {row["device"]: row for row in (await ask("status"))["devices"]}
        assert rows["u1"]["snapshot"] is None
        assert rows["d1"]["snapshot"]["microsteps"] == 8
        assert (await ask("state", "u1")).keys() == {
            "at_ns",
            "pulses_sent",
            "pulses_left",
            "pin_levels",
            "pins_driven",
            *("cycles", "vcc_V", "a0_V", "a1_V", "a2_V", "a3_V", "a4_V", "a5_V", "a6_V", "a7_V"),
            *("d3_V", "d5_V", "d6_V", "d9_V", "d10_V", "d11_V"),
        }
        assert await refusal(ask("zero", "u1")) == (
            "not_now",
            "u1, a uno, has no motor; `hil list` shows the others",
        )
        rows_of_a_source = [[0, "D3", 1, 0, 0]]
        code, why = await refusal(ask("drive", "d1", train=rows_of_a_source))
        assert (code, "no input D3; it has dir, step" in why) == ("cannot", True)
        assert (await refusal(ask("drive", "u1", train=[])))[1] == "u1 has no step input; there are d1"
        await ask("drive", "d1", train=[[0, "MS1", 0, 0, 0], [1000, "step", 1, 0, 0]])

    desk_in(tmp_path, CONFIG)(use)
