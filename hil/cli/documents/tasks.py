"""Tasks of users, each with the command line for it: what the page of commands begins with, and what
`hil help WORD` searches."""

from typing import NamedTuple


class TaskRow(NamedTuple):
    """Aim of a user, without a full stop, and the line that he types."""

    want: str
    line: str


TASKS = (
    TaskRow("write a first configuration", "hil init bench.yaml"),
    TaskRow("check a configuration, and start nothing", "hil check bench.yaml"),
    TaskRow("start a bench", "hil serve bench.yaml"),
    TaskRow("start a bench in the background", "hil serve bench.yaml --detach"),
    TaskRow("end the bench", "hil shutdown"),
    TaskRow("install a bench as a service that starts at boot", "hil docs service"),
    TaskRow("connect a real board", "hil docs real-boards"),
    TaskRow("see whether this computer is fit for real time", "hil doctor"),
    TaskRow(
        "run a program on virtual time, as fast as it goes",
        "hil virtual bench.yaml --map /dev/ttyUSB0=m1 home.py /dev/ttyUSB0",
    ),
    TaskRow("let a served bench go faster than real time: its `speed:`, up to 1000", "hil docs real-time"),
    TaskRow("which boards are there, at which ports; which address has s2", "hil list"),
    TaskRow("which benches run on this computer", "hil list"),
    TaskRow("which benches run in the lab, behind a router", "hil list --connect tcp/127.0.0.1:7447"),
    TaskRow("which programs can use which port", "hil list --programs"),
    TaskRow("how the bench does, and what is wrong with it", "hil status"),
    TaskRow("where m1 stands, with all its fields", "hil status m1"),
    TaskRow("the position of m1 as JSON, for a script", "hil status m1 --json"),
    TaskRow("the position of m1 live, with a plot", "hil top m1.position_deg"),
    TaskRow("what m1 said since the start, all of it", "hil log m1 --lines 0"),
    TaskRow("what the daemon complained of", "hil log --level warning"),
    TaskRow("who commanded the bench", "hil log commands --since 2h"),
    TaskRow(
        "take a bench for yourself for an hour, and say why", 'hil lease take --for 1h --why "press tests"'
    ),
    TaskRow("give it back", "hil lease give"),
    TaskRow("talk to m1 in this terminal", "hil monitor m1"),
    TaskRow("type p at m1, and see the answer", "hil type m1 p"),
    TaskRow("press the reset button of m1: off and on, its flash stays", "hil reset m1"),
    TaskRow("put a level on an input pin", "hil pin m1 D2 0"),
    TaskRow("set a gain of m1", "hil set m1 pKp 12"),
    TaskRow("put a load on the shaft of m1", "hil set m1 load_torque_Nm 0.05"),
    TaskRow("which motions m1 knows", "hil axis m1"),
    TaskRow("calibrate m1, and wait", "hil axis m1 calibrate --wait"),
    TaskRow("switch the control loop of m1 on", "hil axis m1 enable"),
    TaskRow("turn m1 to 90 degrees, and wait", "hil axis m1 move-abs 90 --wait"),
    TaskRow("wait until m1 stands still", "hil wait m1 'abs(velocity_rpm) < 0.1'"),
    TaskRow("stop everything that moves", "hil stop"),
    TaskRow("stop m1 and s1 alone", "hil stop m1 s1"),
    TaskRow("start a run, and go on here", "hil run square.yaml --detach"),
    TaskRow("see the state of a run", "hil run show square"),
    TaskRow("make a run twice as slow", "hil run pace square 0.5"),
    TaskRow("cancel a run", "hil run cancel square"),
    TaskRow(
        "play a G-code file: on the line that the machine's file names",
        "hil gcode drawing.ngc --machine mill.yaml",
    ),
    TaskRow("load a sketch", "hil sketch load u1 sketches/blink/build/blink.elf"),
    TaskRow("compare a real board with its twin", "hil parity sac/identify --at /dev/ttyUSB0"),
    TaskRow("what passes on bus0, live", "hil capture bus0"),
    TaskRow("record what passes on bus0 in a file for Wireshark", "hil capture bus0 -w bus0.pcapng"),
    TaskRow("scan a line for nodes", "hil line scan bus0.master"),
    TaskRow("send a command to the node with address 85", "hil line send bus0.master 85 v150"),
    TaskRow("send a text to the node with address 85", "hil line text bus0.master 85 good morning"),
    TaskRow("which faults fit the SACs of the bench", "hil fault kinds sac"),
    TaskRow("jam the shaft of m1 for 2 s", "hil fault inject shaft_jam m1 --for 2s"),
    TaskRow("end all faults", "hil fault clear"),
    TaskRow("read the manual of faults in the terminal", "hil docs reference#faults"),
    TaskRow("which recordings there are", "hil recordings"),
    TaskRow("replay last night's run, and compare each byte", "hil replay last"),
    TaskRow(
        "replay it with another fault",
        "hil replay last --fault 'shaft_jam m1 at=12.5s for=1s'",
    ),
    TaskRow("what differs between the last two recordings", "hil diff last-1 last"),
    TaskRow("when the error of m1 was over 5 degrees", "hil find last 'abs(m1.e) >= 5'"),
    TaskRow(
        "the position of m1 as CSV, every 10 ms", "hil export last m1.position_deg -o m1.csv --every 10ms"
    ),
    TaskRow(
        "a test's failing second as a file, from its run.hil.gz",
        "hil export run.hil.gz -o second.csv --from 12s --to 13s",
    ),
    TaskRow("all of a recording in one file, for a colleague", "hil bundle last -o bug.hilz --yes"),
    TaskRow("read a page of the manual in the terminal, or search", "hil docs runs"),
    TaskRow("complete commands and names in a shell", "hil completion bash"),
    TaskRow("the version", "hil version"),
)
"""Tasks in the order in which a bench is made, watched, moved, broken and looked back at."""


def tasks_about(word: str) -> list[TaskRow]:
    """Find the tasks that have a word, or its beginning, among those of what is wanted."""
    wanted = word.lower().strip()
    return [task for task in TASKS if any(each.startswith(wanted) for each in _words(task.want))]


def _words(want: str) -> list[str]:
    return "".join(each if each.isalnum() else " " for each in want.lower()).split()
