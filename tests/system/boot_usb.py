"""Boards on the USB in a virtual machine, with Debian's stock kernel and with its real-time kernel: the
service, programs for serial ports, figures, and what no program should do.

``HIL_USB_LONG=1``: with the counts of a long run, and the programs of a desktop; ``HIL_USB_SCREENS``: a
folder for pictures of them.
"""

import base64
import json
import os
import re
import shlex
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from debian import HIL_PYTHON, ROOT, CannotError, need, tree_with_hil, tree_with_usb
from guest import REAL_TIME, STOCK, Guest, root_image

LONG = bool(os.environ.get("HIL_USB_LONG"))
SCREENS = os.environ.get("HIL_USB_SCREENS")
OPENS, PLUGS, FUZZ_S, ROUND_TRIPS = (200, 1000, 300, 2000) if LONG else (4, 25, 20, 200)
EXCHANGED_BYTES = 10_000_000 if LONG else 300_000
COMMAND_S = 3600.0 if LONG else 300.0
BENCH = """\
bench: usb
speed: 0.5 # an emulated CPU is slow
devices:
  m1: {profile: mechaduino, flash: {table: identity}, port: usb}
  s1: {profile: sac, port: usb}
"""
UNIT = "hil@usb"
M1 = "/dev/serial/by-id/usb-Arduino_LLC_Arduino_Zero__virtual__usb.m1-if00"
S1 = "/dev/serial/by-id/usb-hil_Serial_adapter__virtual__usb.s1-if00"
ARDUINO_ZERO = {
    "ID_BUS": "usb",
    "ID_VENDOR_ID": "2341",
    "ID_MODEL_ID": "804d",
    "ID_VENDOR": "Arduino_LLC",
    "ID_REVISION": "0100",
    "ID_TYPE": "generic",
    "ID_USB_INTERFACES": ":020200:0a0000:",
    "ID_USB_INTERFACE_NUM": "00",
    "ID_USB_DRIVER": "cdc_acm",
    "SUBSYSTEM": "tty",
}
"""Properties that udev gives a real board with its native port, by the descriptors in USBCore.cpp of the
Arduino SAMD core."""
SWITCH = "/sys/devices/platform/vhci_hcd.0"


class UsbGuest:
    """A guest with a bench of USB boards, that was made as docs/how-to/service.md says."""

    def __init__(self, guest: Guest) -> None:
        self.guest = guest

    def run(self, command: str, user: str = "", check: bool = True, timeout_s: float = COMMAND_S) -> str:
        if user:
            command = f"runuser -u {user} -- sh -c {shlex.quote(command)}"
        return self.guest.run(command, check=check, timeout_s=timeout_s)

    def inside(self, test: str, *arguments: object, python: str = "/usr/bin/python3", user: str = "") -> str:
        words = shlex.join(map(str, (python, "/usr/local/lib/usb_inside.py", test, *arguments)))
        return self.run(f"{words} 2>&1", user)

    def wait_for(self, condition: str) -> None:
        self.run(f"for i in $(seq 240); do {condition} && exit; sleep 0.5; done; {condition}")

    def tty(self, name: str = M1) -> str:
        return self.run(f"readlink -f {name}").strip()

    def show(self, name: str) -> None:
        """Take a picture of the desktop, for those who want to see it."""
        if SCREENS:
            said = self.run("DISPLAY=:1 import -window root png:- | base64 -w0")
            (Path(SCREENS) / f"{name}.png").write_bytes(base64.b64decode(said))


def links() -> list[str]:
    """Commands of docs/how-to/service.md that switch it on at boot."""
    page = (ROOT / "docs/how-to/service.md").read_text()
    section = page.partition("## Virtual USB devices")[2].partition("\n## ")[0]
    commands: list[str] = re.findall(r"^# ((?:cd|ln) .+)$", section, re.M)
    assert len(commands) == 4, commands
    return commands


def prepared(folder: Path) -> tuple[Path, Path]:
    """The tree of the kernels, and an image with the bench and all that switches it on."""
    kernels = tree_with_usb()
    tree = tree_with_hil(folder, kernels)
    (tree / "etc/hil").mkdir(exist_ok=True)
    (tree / "etc/hil/usb.yaml").write_text(BENCH)
    (tree / "usr/local/lib/usb_inside.py").write_text(Path(__file__).with_name("usb_inside.py").read_text())
    slow = tree / "etc/systemd/system/hil@.service.d/slow.conf"
    slow.parent.mkdir(parents=True)
    slow.write_text("[Service]\nWatchdogSec=60\nTimeoutStartSec=300\n")
    for path in ("etc/modules-load.d", "etc/udev/rules.d"):
        (tree / path).mkdir(parents=True, exist_ok=True)
    in_tree = " && ".join(["systemd-sysusers", *links(), f"systemctl enable --quiet {UNIT}"])
    users = "useradd -mG dialout,hil-usb tester && useradd -m stranger"
    done = subprocess.run(["chroot", tree, "sh", "-ec", f"{in_tree} && {users}"], capture_output=True)
    assert done.returncode == 0, done.stderr
    return kernels, root_image(tree, folder / "root.img", "6G")


@pytest.fixture(scope="module")
def image() -> Iterator[tuple[Path, Path]]:
    try:
        need({"qemu-system-x86_64": "qemu-system-x86", "mke2fs": "e2fsprogs"})
        with tempfile.TemporaryDirectory(prefix="hil-usb-") as folder:
            yield prepared(Path(folder))
    except CannotError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def machine(request: pytest.FixtureRequest, image: tuple[Path, Path]) -> Iterator[UsbGuest]:
    try:
        with Guest(*image, request.param, memory_MB=3072 if LONG else 1024) as guest:
            made = UsbGuest(guest)
            made.wait_for(f"systemctl is-active -q {UNIT}")
            made.wait_for(f"test -e {M1} -a -e {S1}")
            yield made
    except CannotError as error:
        pytest.skip(str(error))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Boot the stock kernel for all tests but the last: one guest at a time."""
    if "machine" in metafunc.fixturenames:
        kernel = REAL_TIME if "real_time" in metafunc.function.__name__ else STOCK
        metafunc.parametrize("machine", [kernel], ids=["kernel"], indirect=True, scope="module")


@pytest.fixture
def usb(machine: UsbGuest) -> UsbGuest:
    machine.wait_for(f"test -e {M1} -a -e {S1}")
    return machine


def test_the_hardened_service_has_its_boards_after_the_boot(usb: UsbGuest) -> None:
    said = usb.run(f"systemctl show -p User -p DynamicUser -p ProtectKernelTunables {UNIT}")
    assert "DynamicUser=yes" in said
    assert "ProtectKernelTunables=yes" in said
    assert usb.run(f"stat -c '%A %U %G' {SWITCH}/attach").split() == ["--w--w----", "root", "hil-usb"]
    addresses = {row["address"] for row in devices(usb)}
    assert addresses == {usb.tty(M1), usb.tty(S1)}
    assert "dialout" in usb.run(f"stat -c %G {usb.tty()}")


def devices(usb: UsbGuest) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = json.loads(usb.run("hil status --bench usb --json"))["devices"]
    return rows


@pytest.mark.parametrize("user", ["tester", "stranger"])
def test_the_doctor_knows_who_may_plug_in(usb: UsbGuest, user: str) -> None:
    said = usb.run("hil usb doctor --json; true", user)
    problems = {each["name"]: each["remedy"] for each in json.loads(said) if each["verdict"] == "problem"}
    if user == "tester":
        assert problems == {}
    else:
        assert list(problems) == ["right to plug in"]
        assert "usermod -aG hil-usb USER" in problems["right to plug in"]


def test_a_bench_of_a_user_in_the_group_and_of_one_outside(usb: UsbGuest) -> None:
    usb.run("sed 's/bench: usb/bench: own/' /etc/hil/usb.yaml > /tmp/own.yaml; chmod a+r /tmp/own.yaml")
    said = usb.run("hil serve /tmp/own.yaml 2>&1; echo exit $?", "stranger")
    assert "exit 2" in said, said
    assert "usermod -aG hil-usb USER" in said
    serve = "cd /tmp; hil serve --ready-file /tmp/own.json /tmp/own.yaml > /tmp/own.log 2>&1"
    usb.run(f"(setsid runuser -u tester -- sh -c '{serve}' > /tmp/own.out 2>&1 &)")
    usb.wait_for("test -s /tmp/own.json")
    assert "usb-Arduino_LLC_Arduino_Zero__virtual__own.m1-if00" in usb.run("ls /dev/serial/by-id")
    usb.run("kill $(pgrep -u tester -f 'hil serve.*own.yaml')")
    usb.wait_for("! ls /dev/serial/by-id | grep -q own.m1")


def test_udev_takes_it_for_an_arduino_zero(usb: UsbGuest) -> None:
    said = usb.run(f"udevadm info --query=property {M1}")
    found = dict(line.split("=", 1) for line in said.splitlines() if "=" in line)
    assert {name: found.get(name) for name in ARDUINO_ZERO} == ARDUINO_ZERO
    assert (found["ID_MODEL"], found["ID_SERIAL_SHORT"]) == ("Arduino_Zero__virtual_", "usb.m1")


def test_pyserial_lists_it(usb: UsbGuest) -> None:
    usb.inside("listed", usb.tty(M1), "2341", "804d", "usb.m1")
    usb.inside("listed", usb.tty(S1), "0525", "a4a7", "usb.s1")


@pytest.mark.parametrize(
    "program",
    [
        "picocom -q -b 115200 PORT",
        "tio -b 115200 PORT",
        "minicom -b 115200 -D PORT",
        "screen -S hil PORT 115200",
        "plink -serial PORT -sercfg 115200,8,n,1,N",
    ],
)
def test_a_terminal_program(usb: UsbGuest, program: str) -> None:
    usb.inside("terminal", *program.replace("PORT", M1).split(), user="tester")


def test_modem_lines_break_and_exclusive_use(usb: UsbGuest) -> None:
    usb.inside("lines", M1, user="tester")


def test_formats_of_characters(usb: UsbGuest) -> None:
    print(usb.inside("formats", M1, S1, OPENS, user="tester"))


def test_no_byte_is_lost(usb: UsbGuest) -> None:
    """The times are those of an emulated CPU: a pty beside it tells what they are worth."""
    print(usb.inside("figures", "pty,usb", EXCHANGED_BYTES, ROUND_TRIPS, python=HIL_PYTHON))


def test_plugging_in_and_out(usb: UsbGuest) -> None:
    print(usb.inside("plugging", PLUGS, python=HIL_PYTHON))


def test_requests_that_no_driver_makes(usb: UsbGuest) -> None:
    print(usb.inside("fuzz", "2341", FUZZ_S, 1))
    usb.wait_for(f"test -e {M1}")
    usb.inside("lines", M1)
    assert not re.search(r"BUG|Oops|Call Trace", usb.run("dmesg"))


def test_a_touch_at_1200_baud_resets_the_board(usb: UsbGuest) -> None:
    number = usb.run(f"cat /sys/class/tty/{Path(usb.tty()).name}/device/../devnum")
    usb.run(f"stty -F {M1} 1200")
    usb.wait_for(
        f'test -e {M1} && test "$(cat /sys/class/tty/$(basename $(readlink -f {M1}))/device/../devnum)" '
        f"-gt {int(number)}"
    )
    usb.inside("lines", M1)


def test_killed_it_takes_its_boards_along_and_brings_them_back(usb: UsbGuest) -> None:
    pid = usb.run(f"systemctl show --value -p MainPID {UNIT}")
    hear = f"(stty raw -echo min 1; cat) < {M1} > /tmp/heard"  # pyserial leaves `min 0`, an end of file
    usb.run(f"({hear}; echo ended > /tmp/ended) > /tmp/out 2>&1 &")
    usb.wait_for(f"fuser -s {usb.tty()}")
    usb.run(f"systemctl kill -s KILL {UNIT}")
    usb.wait_for("test -e /tmp/ended")
    usb.wait_for(f"test $(systemctl show --value -p MainPID {UNIT}) -gt {int(pid)}")
    usb.wait_for(f"test -e {M1} -a -e {S1}")
    usb.inside("lines", M1)
    assert usb.run(f"grep -c ' 006 ' {SWITCH}/status").strip() == "2"


class Desktop:
    """Programs with windows. What they do is seen at the board: it counts bytes."""

    def __init__(self, usb: UsbGuest) -> None:
        self.usb = usb

    def start(self, command: str) -> None:
        self.usb.run(f"export DISPLAY=:1 HOME=/root; cd; (setsid {command} > /tmp/program.log 2>&1 &)")

    def do(self, *steps: str) -> None:
        self.usb.run("export DISPLAY=:1; " + "; ".join(f"xdotool {step}; sleep 2" for step in steps))

    def wait_for_window(self, name: str) -> None:
        self.usb.wait_for(f"DISPLAY=:1 xdotool search --onlyvisible --name '{name}' > /tmp/window")
        self.usb.run("sleep 20")  # its content comes later, and nothing tells when

    def heard_bytes(self) -> int:
        (row,) = (row for row in devices(self.usb) if row["device"] == "m1")
        count = row["rx_bytes"]
        assert isinstance(count, int)
        return count


@pytest.fixture
def desktop(usb: UsbGuest) -> Iterator[Desktop]:
    if not LONG:
        pytest.skip("a long run has programs with windows: HIL_USB_LONG=1")
    made = Desktop(usb)
    made.start("Xvfb :1 -screen 0 1280x900x24")
    usb.wait_for("DISPLAY=:1 xdpyinfo > /tmp/display 2>&1")
    made.start("openbox")
    yield made
    usb.run("killall -q java cutecom gtkterm openbox Xvfb; sleep 2", check=False)


def test_the_arduino_ide_lists_it_and_its_monitor_and_plotter_work(desktop: Desktop) -> None:
    """The monitor opens a port that the IDE lists, and no other."""
    usb, tty = desktop.usb, desktop.usb.tty()
    usb.run(
        f"mkdir -p /root/.arduino15; printf 'serial.port={tty}\\nserial.port.file={Path(tty).name}\\n' "
        "> /root/.arduino15/preferences.txt"
    )
    desktop.start("arduino")
    desktop.wait_for_window("sketch_.*Arduino 1.8")
    before = desktop.heard_bytes()
    desktop.do("key ctrl+shift+m")
    desktop.wait_for_window(tty)
    desktop.do("type m", "key Return")
    usb.show("ide-monitor")
    assert desktop.heard_bytes() == before + 2, "m, and the line's end"
    desktop.do("key alt+F4", "key ctrl+shift+l")
    desktop.wait_for_window(tty)
    for key in "xyj":
        desktop.do("mousemove 320 308 click 1", f"type {key}", "key Return")
    usb.run("sleep 20")
    usb.show("ide-plotter")
    assert desktop.heard_bytes() == before + 8


def test_gtkterm(desktop: Desktop) -> None:
    desktop.start(f"gtkterm -p {desktop.usb.tty()} -s 115200")
    desktop.wait_for_window("GTKTerm")
    desktop.do("key Return", "mousemove 640 400 click 1")  # the first is for its note on a new configuration
    before = desktop.heard_bytes()
    desktop.do("type p")
    desktop.usb.show("gtkterm")
    assert desktop.heard_bytes() == before + 1


def test_cutecom(desktop: Desktop) -> None:
    desktop.start("cutecom")
    desktop.wait_for_window("CuteCom")
    before = desktop.heard_bytes()
    # Its list shows a port, and takes it only when another was chosen in between; then Open, and DTR.
    desktop.do(
        "mousemove 510 158 click 5", "click 4", "mousemove 351 158 click 1", "mousemove 639 158 click 1"
    )
    desktop.do("mousemove 430 359 click 1", "type p", "key Return")
    desktop.usb.show("cutecom")
    assert desktop.heard_bytes() == before + 2


def test_the_real_time_kernel_has_it_too(usb: UsbGuest) -> None:
    assert "PREEMPT_RT" in usb.run("uname -v")
    usb.inside("lines", M1, user="tester")
    print(usb.inside("figures", "pty,usb", EXCHANGED_BYTES // 10, ROUND_TRIPS, python=HIL_PYTHON))
