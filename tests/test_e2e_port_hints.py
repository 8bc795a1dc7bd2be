"""What a bench says of its ports: commands that reach them, and programs that can use them."""

import json
import os
import tty

from e2e_support import Place, config, until


def test_commands_name_the_end_that_a_client_can_open(place: Place) -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    cable = os.ttyname(slave)
    os.close(slave)
    devices = {
        "m1": {},
        "m2": {"port": "rfc2217"},
        "m3": {"port": {"kind": "serial", "url": cable}},
    }
    server = place.serve(config(devices=devices)).started()
    until(lambda: "Ctrl-C ends the bench." in server.output, "all that is said at the start")
    rows = {row["device"]: row for row in server.ask("list")["devices"]}
    parts = {part.partition(":")[0]: part for part in server.output.split("\n\n")}
    path, url = rows["m1"]["address"], rows["m2"]["address"]
    assert f"\n  picocom -b 115200 {path}\n" in parts["m1"]
    assert f"\n  telnet 127.0.0.1 {url.rpartition(':')[2]}\n" in parts["m2"]
    assert "picocom" not in parts["m2"]
    assert parts["m3"].startswith(f"m3: mechaduino at the other end of {cable}, answers 4 s after power-up")
    assert parts["m3"].count("\n") == 0
    assert "IDE 1.8" not in server.output
    assert (
        "\nWhich programs can use which port, and what helps the others: hil list --programs\n"
        in server.output
    )

    refused = place.cli("monitor", "m3", code=1)
    assert f"m3 is at the other end of {cable}: hil itself has this end open" in refused
    (told,) = json.loads(place.cli("list", "--programs", "--json"))
    assert told["programs"]["m2"]["IDE 1.8"]["verdict"] == "no"
    assert "\npty (m1)\n" in place.cli("list", "--programs")
    os.close(master)
