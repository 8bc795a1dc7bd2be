"""Commands that a bench prints for a port."""

from hil.cli.bench.started import client_lines


def test_a_board_without_a_greeting_is_only_listened_to() -> None:
    for greeting, typed in (("?\n", "s.write(b'?\\n'); "), ("", "")):
        *_, line = client_lines("hil monitor m1", "/run/m1", 9600, greeting)
        assert line.endswith(
            f"""s = serial.serial_for_url('/run/m1', 9600, timeout=1); {typed}print(s.read(99))\""""
        )
