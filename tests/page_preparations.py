"""Preparations of pages: benches, files and varying patterns that stand before commands below a heading."""

import os
import re
import shlex
import shutil

import can
import pytest
import yaml
from e2e_support import Client, free_port, until
from e2e_support import ended as run_ended
from markdown_blocks import ROOT, blocks
from page_sessions import Session, captured, interrupted
from page_tables import before, carries_out
from pymodbus.client import ModbusSerialClient

from device_profiles.sac.packet import encode
from hil.testing import Bench

M1 = "m1: {profile: mechaduino, flash: {table: identity}}"
NS = r"\d{7,}"
"""A time in nanoseconds."""
DEG = r"-?\d+\.\d+"
DEMO = f"bench: demo\ndevices:\n  {M1}\n  s1: {{profile: sac}}\n"


# ---- ten questions ----


@before("faq", "How real is real time?")
def _(session: Session) -> None:
    session.serve(f"bench: desk\ndevices:\n  {M1}\n", speed=1)
    session.varies = (r"\d+\.\d+", r"\d+")


@before("faq", "Can I trust a run twice?")
def _(session: Session) -> None:
    for letter in "py":
        session.run(f"hil type m1 {letter}")
    session.end_benches()


# ---- recordings ----


@before("recordings", "What there is")
def _(session: Session) -> None:
    base = session.folder / "home"
    base.mkdir()
    (base / "hil").symlink_to(session.place.state)
    session.environment["XDG_STATE_HOME"] = str(base)
    session.swaps["/home/ann/.local/state"] = str(base)
    session.serve(f"bench: lab\ndevices:\n  {M1}\n", speed=5)
    session.servers[-1].stop()
    session.varies = (r"20\d\d-\d\d-\d\dT[\d-]+Z", r"20[\d :-]+ [A-Z]+", r"[\d.:]+s?", " +")


@before("recordings", "Export")
def _(session: Session) -> None:
    m1 = {"profile": "mechaduino", "flash": {"table": "identity"}}
    config = {
        "bench": "lab",
        "devices": {"m1": m1, "s1": {"profile": "sac"}},
        "segments": {"bus0": {"modbus": {"units": {"m1": 1}}, "baud": 19200, "taps": {"master": {}}}},
        "wires": [{"from": "s1.clk", "to": "m1.step"}, {"from": "s1.dir", "to": "m1.dir"}],
    }
    with Bench(config) as bench, (session.folder / "run.log").open("w") as log:
        bench.start()
        for text in (b"y", b"x", b"r\r90\r"):
            bench.port("m1").write(text)
            bench.run(500)
        bench.port("s1").write(b"m100v60\r")
        bench.run(2000)
        bench.tap("bus0.master").write(bytes.fromhex("01040000000131ca"))
        bench.run(500)
        bench.port("m1").write(b"n")
        bench.run(500)
        bench.inputs.write_to(log)
    session.varies = ()


# ---- the monitor ----


@before("monitor", "Times, hex, and a file")
def _(session: Session) -> None:
    session.serve(f"bench: lab\ndevices:\n  {M1}\n", speed=5)
    session.servers[-1].ready()
    session.varies = (r" *\d+\.\d{6}",)


# ---- a race ----


@before("race", "The night")
def _(session: Session) -> None:
    shutil.copytree(ROOT / "examples/race", session.folder, dirs_exist_ok=True)
    session.varies = (r" in \d+\.\d+s", r"[\d,]+ bytes")
    assert (session.folder / "test_night.py").read_text() == session.text("test_night.py", "python")


@carries_out("race", "hil replay night.hil --until 1:05:47 --serve")
def _(session: Session, command: str) -> str:
    said = session.beside(command)
    until(lambda: "paused" in session.ended("hil status")[1], "the fork")
    return said


@carries_out("race", "hil capture bus0 -c 2 & sleep 1; hil resume")
def _(session: Session, command: str) -> str:
    return session.ended(command)[1]


# ---- arduino ----


@before("arduino", "Arduino IDE and arduino-cli")
def _(session: Session) -> None:
    session.swaps["/home/ann"] = str(session.folder)


# ---- can ----


@before("can", "Status")
def _(session: Session) -> None:
    session.serve(session.text("Drives on a CAN bus: CANopen"))
    session.varies = (r"\d+\.\d%", r" +\d+", " +", "process \\d+")


@before("can-channels", "Captures")
def _(session: Session) -> None:
    number = free_port()
    group = f"channel: 239.74.{os.getpid() % 250}.{number % 250}, port: {number}"  # nobody else's
    session.serve(session.text("Channels").replace("udp_multicast}", f"udp_multicast, {group}}}"))
    session.varies = (r"\d\.\d{6}", " +")


@carries_out("can-channels", "hil capture can0 -w - | tshark")
def _(session: Session, command: str) -> str:
    return captured(session, command, lambda: ask_the_drive(session))


@carries_out("can-channels", "hil decode out.pcapng")
def _(session: Session, command: str) -> str:
    captured(session, "hil capture can0 -w out.pcapng", lambda: ask_the_drive(session), 4)
    return session.run(command)


def ask_the_drive(session: Session) -> None:
    """Reset node 5 by NMT, wait for its boot-up, and read its statusword."""
    channel = yaml.safe_load((session.folder / "cell.yaml").read_text())["bridges"]["can"]["channels"]["can0"]
    with can.Bus(**channel) as bus:

        def ask(node: int, data: bytes, answer: int) -> None:
            bus.send(can.Message(arbitration_id=node, data=data, is_extended_id=False))
            until(lambda: (heard := bus.recv(0.1)) and heard.arbitration_id == answer, f"{answer:X}h")

        ask(0, bytes.fromhex("8105"), 0x705)
        ask(0x605, bytes.fromhex("4041600000000000"), 0x585)


# ---- draw ----


@before("draw", "A step response")
def _(session: Session) -> None:
    session.serve(DEMO, speed=5)


@before("draw", "Step and direction")
def _(session: Session) -> None:
    session.run("hil axis m1 enable")
    session.write("train.csv", session.text("Step and direction", "text", 0))


# ---- modbus ----


@before("modbus", "Registers of a device")
def _(session: Session) -> None:
    session.swaps["1502"] = str(free_port())
    text = session.text("Axes for PLCs and SCADA: Modbus")
    session.serve(text.replace("modbus: {}", "modbus: {listen: 127.0.0.1:1502}"))


@before("modbus", "Captures and faults")
def _(session: Session) -> None:
    session.serve(session.text("Nodes on an RS485 line"))
    session.varies = (r"0\.00\d{4}",)


@carries_out("modbus", "hil capture bus0")
def _(session: Session, command: str) -> str:
    def talk() -> None:
        tap = str(session.place.runtime / "plant" / "bus0.master")
        with ModbusSerialClient(tap, baudrate=19200, timeout=5) as client:
            assert client.read_input_registers(0, count=1, device_id=1).registers == [1]

    return captured(session, command, talk, 2 if "-w" in command else 3)


@before("modbus", "A drive of your own")
def _(session: Session) -> None:
    heading = "A drive of your own"
    session.write("lathe.yaml", session.text(heading, index=1))
    session.serve(session.text(heading).replace("modbus: {}", "modbus: {listen: 127.0.0.1:1502}"))


# ---- move-axes ----


@before("move-axes", "From the shell")
def _(session: Session) -> None:
    session.serve(DEMO, speed=5)
    session.varies = (NS, DEG)


# ---- switches ----


@before("switches", "Choose a motor")
def _(session: Session) -> None:
    bench = next(block for block in blocks("docs/how-to/switches.md") if "friction_Nm" in block.text)
    session.write("slide.yaml", bench.text)


@before("switches", "Break a switch")
def _(session: Session) -> None:
    session.serve("bench: slide\ndevices: {s1: {profile: sac}}\nswitches: {home: {axis: s1, to_deg: -180}}\n")


# ---- package ----


@before("package", "A container")
def _(session: Session) -> None:
    text = session.text("A container").replace("0.0.0.0", "127.0.0.1").replace("port: 45001", "port: 0")
    session.swaps["45002"] = str(free_port())
    session.serve(text)


# ---- ports ----


@before("ports", "Ports")
def _(session: Session) -> None:
    text = session.text("Ports").replace("baud: 38400", "baud: 384000000").replace("0.1:7001", "0.1:70010")
    session.write("lab.yaml", text)


# ---- parity ----


@before("parity", "Try it without a board")
def _(session: Session) -> None:
    session.serve(session.text("Try it without a board"), speed=1)
    session.varies = (r" +[+-]?\d+\.\d", " +")


# ---- real boards and drives ----


@before("real-boards", "Put a real board into a bench")
def _(session: Session) -> None:
    session.write("mixed.yaml", session.text("Put a real board into a bench"))
    through = "/dev/ttyUSB0{}, through"  # no board is there
    session.swaps[through.format("")] = through.format(" (away, tried again each second)")


@before("real-boards", "Disturb its line")
def _(session: Session) -> None:
    session.varies = (r"\d+ bytes",)


@before("real-boards", "Real Modbus drives")
def _(session: Session) -> None:
    number = free_port()
    session.write("lathe.yaml", (ROOT / "examples/modbus/lathe.yaml").read_text())
    far = "bench: far\ndevices: {d: {profile: modbus_drive, map: lathe.yaml}}\n"
    session.serve(far + f"bridges: {{modbus: {{listen: 127.0.0.1:{number}}}}}\n", speed=1, waits=False)
    bench = yaml.safe_load(session.text("Real Modbus drives"))
    bench["devices"] = {"x": bench["devices"]["x"] | {"at": f"modbus+tcp://127.0.0.1:{number}?unit=1"}}
    session.serve(yaml.safe_dump(bench, sort_keys=False), speed=1, beside=True, waits=False)
    until(lambda: session.servers[-1].status("x")["drive"]["state"] == "there", "the drive")
    session.environment["HIL_BENCH"] = "shop"
    session.varies = (NS, r"\d+(\.\d+)? ms", r"\d+ polls", r"\d exceptions")


@before("real-can-drives", "Use real CANopen drives as axes")
def _(session: Session) -> None:
    number = free_port()
    group = f"239.74.{os.getpid() % 250}.{number % 250}"  # nobody else's
    session.swaps |= {"udp_multicast}": f"udp_multicast, channel: {group}, port: {number}}}"}
    session.swaps |= {"239.74.163.2": f"{group}:{number}"}
    far, near = (session.text("Try it without a drive", index=index) for index in range(2))
    session.serve(far, speed=1, waits=False)
    session.serve(near, speed=1, beside=True, waits=False)
    until(lambda: session.servers[-1].status("x")["drive"]["state"] == "there", "the drive")
    session.environment["HIL_BENCH"] = "near"
    twin = (
        "simulated canopen_drive, vendor 00000000h, product CD32D0B4h, revision 00010000h, serial 10896CEEh"
    )
    session.swaps["CL57, vendor 000002E1h, product 00000007h"] = twin
    session.varies = (NS, r"\d+(\.\d+)? ms", r"\d+ polls", r"\d+ exceptions")


# ---- reload ----

RELOADED = "bench: lab\ndevices:\n  m1: {profile: mechaduino}\n"


@before("reload", "Change a bench while it runs")
def _(session: Session) -> None:
    session.serve(RELOADED + "  m2: {profile: mechaduino}\n  s1: {profile: sac}\n", speed=1, waits=False)
    session.write(
        "lab.yaml", RELOADED + "  m2: {profile: mechaduino, baud: 9600}\n  m3: {profile: mechaduino}\n"
    )
    for end in ":;":
        session.swaps[f"lab.yaml{end}"] = f"{session.folder}/lab.yaml{end}"  # as it was given to hil serve


@before("reload", "What it refuses")
def _(session: Session) -> None:
    wrong = "  m3:\n    profile: mechadunio\n  m4: {profile: sac, boud: 9600}\n"
    session.write("lab.yaml", RELOADED + "  m2: {profile: mechaduino, baud: 9600}\n" + wrong)


@carries_out("reload", "hil reload")
def _(session: Session, command: str) -> str:
    said = session.run(command)
    if "mechadunio" in said:  # the next try is with another text
        session.write("lab.yaml", RELOADED + "speed: 2\n")
    return said


# ---- robot ----


@before("robot", "Test with Robot Framework")
def _(session: Session) -> None:
    pytest.importorskip("robot", reason="Robot Framework is not installed")
    write_suites(session, "Test with Robot Framework")


@before("robot", "With other libraries for serial ports")
def _(session: Session) -> None:
    pytest.importorskip("SerialLibrary", reason="robotframework-seriallibrary is not installed")
    write_suites(session, "With other libraries for serial ports")


@before("robot", "In real time")
def _(session: Session) -> None:
    write_suites(session, "In real time")


def write_suites(session: Session, heading: str) -> None:
    """Write the files below a heading whose names are in their first lines."""
    for each in blocks(session.page):
        if each.heading == heading and (named := re.match(r"# (\w+\.\w+)\n", each.text)):
            (session.folder / named[1]).write_text(each.text)


# ---- runs ----


@before("runs", "Carry it out")
def _(session: Session) -> None:
    session.varies = (DEG,)
    session.write(
        "bad.yaml",
        "run: bad\naxes:\n  m1: {max_deg: 50}\n  s1: {}\n"
        "steps:\n  - move: {m1: 90}\n  - {line: {m1: 9, s1: 9}}\n",
    )


@before("runs", "See and cancel runs")
def _(session: Session) -> None:
    session.serve(DEMO, speed=5)
    session.run("hil axis m1 enable")
    session.write("far.yaml", '{"run": "far", "axes": {"m1": {}}, "steps": [{"move": {"m1": 72000.0}}]}')
    session.varies = (DEG, r"\d+ s left")


@carries_out("runs", "hil run --detach")
def _(session: Session, command: str) -> str:
    said = session.run(command)
    until(lambda: session.servers[-1].ask("runs", name="far")[0]["step"], "its first step")
    return said


@carries_out("runs", "hil run cancel --at-once")
def _(session: Session, command: str) -> str:
    said = session.run(command)
    run_ended(session.servers[-1], "far")
    return said


@carries_out("runs", "hil run examples/runs/mixed.run.yaml")
def _(session: Session, _: str) -> str:
    """What ``mixed.py`` prints, which types these commands (``test_examples.py``)."""
    return (ROOT / "examples/runs/mixed.txt").read_text().rpartition("the last")[0]


# ---- SACs and segments ----


def serve_line(session: Session) -> None:
    """Serve the page's line, with an address for each node."""
    server = session.serve(session.text("Be the master of a line"), speed=1)
    with server.client("s2") as terminal:
        terminal.ask(b"$CM86\r", b"SAC>")
        terminal.ask(b"$R\r", b"SAC>")


@before("gcode", "Carry it out by runs")
def _(session: Session) -> None:
    session.varies = (DEG,)


@before("line", "Commands")
def _(session: Session) -> None:
    serve_line(session)
    session.varies = (r"\d+\.\d+ m?s", " +")
    row = " {} , 100 , 1 , 1 , 69 , 4321 , 1 , 10.47 , .5 , 3 , 1 , 2400000 \r\n"
    session.write("queue.txt", "".join(row.format(position) for position in range(1, 31)))


@before("sac-network", "Files of the companion program")
def _(session: Session) -> None:
    session.serve(DEMO)
    row = " {} , 100 , 1 , 1 , 69 , 4321 , 1 , 10.47 , .5 , 3 , 1 , 2400000 \r\n"
    session.write("queue.txt", "".join(row.format(position) for position in range(1, 31)))
    session.write("oneShot.txt", "xm1200v160ad\r\n" + "\r\n" * 99)


@before("sac-network", "A file longer than the queue")
def _(session: Session) -> None:
    session.serve(DEMO)
    row = " {} , 1 , 0 , 1 , 300 , 1000 , 0 , 999 , 999 , 0 , 0 , 0 \r\n"
    session.write("long.txt", "".join(row.format(position) for position in range(1, 41)))
    session.varies = (r"\d[\d,]*",)


@before("segments", "Watch it")
def _(session: Session) -> None:
    text = session.text("An RS485 line with many nodes")
    server = session.serve(re.sub(r"^ +line: .*\n", "", text, flags=re.M))
    with server.client("s2") as terminal:  # its address: both have 85 from the factory
        terminal.ask(b"$CM86\r", b"SAC>")
        terminal.ask(b"$R\r", b"SAC>")
    session.varies = (r"\d\.\d{6}",)


@carries_out("segments", "hil capture bus0")
def _(session: Session, command: str) -> str:
    """The view has a packet with a wrong CRC too, the file has not."""
    is_view = "-w" not in command

    def talk() -> None:
        with Client(str(session.place.runtime / "line" / "bus0.master")) as master:
            master.write(encode(85, 1, b"m3000"))
            master.read_until(b"\x06")
            if is_view:
                master.write(encode(85, 1, b"m9", crc=False)[:-1] + b"\x41\0")
                master.read_until(b"\x15")

    return captured(session, command, talk, 5 if is_view else 2)


# ---- scada ----


@before("scada", "mbpoll")
def _(session: Session) -> None:
    session.swaps["1502"] = str(free_port())
    text = (ROOT / "examples/modbus/poll16.yaml").read_text()
    session.serve(text.replace("modbus: {}", "modbus: {listen: 127.0.0.1:1502}"), speed=1, waits=False)
    session.run(f"python examples/modbus/poll16.py {session.swaps['1502']}")


# ---- web ----


@carries_out("web", "hil web user")
def _(session: Session, command: str) -> str:
    return session.run(f"echo a long password | {command}")


# ---- tests and zenoh ----


@before("write-a-test", "A program of your own")
def _(session: Session) -> None:
    session.write("bench.yaml", "bench: t\ndevices: {s1: {profile: sac}}\n")


@before("zenoh", "From Python")
def _(session: Session) -> None:
    door = f"127.0.0.1:{free_port()}"
    text = (ROOT / "examples/zenoh/bench.yaml").read_text()
    session.write("bench.yaml", text.replace("zenoh: {}", f"zenoh: {{listen: [tcp/{door}]}}"))
    session.swaps |= {"examples/zenoh/bench.yaml": "bench.yaml"}
    session.swaps |= {program: f"{program} zen tcp/{door}" for program in ("two_axes.py", "plain.py")}
    session.swaps |= {
        'connect_sync("zen")': f'connect_sync("zen", "tcp/{door}")',
        "tcp/127.0.0.1:7447": f"tcp/{door}",
    }
    session.varies = (DEG,)


@carries_out("zenoh", "python examples/zenoh/plain.py")
def _(session: Session, command: str) -> str:
    """Carry it out, and then the page's own programs; one goes on printing states."""
    said = session.run(command)
    going_on = f"python -uc {shlex.quote(session.text('From Python', 'python'))}"
    states = interrupted(session, going_on, lambda said: said.count("\n") > 2).splitlines()
    assert [len(re.findall(r"-?\d+(?:\.\d+)?", line)) for line in states[1:3]] == [2, 2], states
    assert session.program("What is there") == session.text("What is there", "text")
    return said


@before("dialogue", "A board by a table")
def _(session: Session) -> None:
    for each in blocks(session.page):
        if named := re.match(r"# (\S+\.yaml)\n", each.text):
            file = session.folder / named[1]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(each.text)
