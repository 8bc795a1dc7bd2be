"""Tasks of users, each with the command line for it: what the page of commands begins with, and what
`hil help WORD` searches."""

from typing import NamedTuple


class Task(NamedTuple):
    """Aim of a user, without a full stop, and the line that he types."""

    want: str
    line: str


TASKS = (
    Task("write a first configuration", "hil init bench.yaml"),
    Task("check a configuration, and start nothing", "hil check bench.yaml"),
    Task("start a bench", "hil serve bench.yaml"),
    Task("start a bench in the background", "hil serve bench.yaml --detach"),
    Task("end the bench", "hil shutdown"),
    Task("install a bench as a service that starts at boot", "hil docs service"),
    Task("connect a real board", "hil docs real-boards"),
    Task("see whether this computer is fit for real time", "hil doctor"),
    Task(
        "run a program on virtual time, as fast as it goes",
        "hil virtual bench.yaml --map /dev/ttyUSB0=m1 home.py /dev/ttyUSB0",
    ),
    Task("let a served bench go faster than real time: its `speed:`, up to 1000", "hil docs real-time"),
    Task("which boards are there, at which ports; which address has s2", "hil list"),
    Task("which benches run on this computer", "hil list"),
    Task("which benches run in the lab, behind a router", "hil list --connect tcp/127.0.0.1:7447"),
    Task("which programs can use which port", "hil list --programs"),
    Task("how the bench does, and what is wrong with it", "hil status"),
    Task("where m1 stands, with all its fields", "hil status m1"),
    Task("the position of m1 as JSON, for a script", "hil status m1 --json"),
    Task("the position of m1 live, with a plot", "hil top m1.position_deg"),
    Task("what m1 said since the start, all of it", "hil log m1 --lines 0"),
    Task("what the daemon complained of", "hil log --level warning"),
    Task("who commanded the bench", "hil log commands --since 2h"),
    Task("take a bench for yourself for an hour, and say why", 'hil lease take --for 1h --why "press tests"'),
    Task("give it back", "hil lease give"),
    Task("talk to m1 in this terminal", "hil monitor m1"),
    Task("type p at m1, and see the answer", "hil type m1 p"),
    Task("press the reset button of m1: off and on, its flash stays", "hil reset m1"),
    Task("put a level on an input pin", "hil pin m1 D2 0"),
    Task("set a gain of m1", "hil set m1 pKp 12"),
    Task("put a load on the shaft of m1", "hil set m1 load_torque_Nm 0.05"),
    Task("which motions m1 knows", "hil axis m1"),
    Task("calibrate m1, and wait", "hil axis m1 calibrate --wait"),
    Task("switch the control loop of m1 on", "hil axis m1 enable"),
    Task("turn m1 to 90 degrees, and wait", "hil axis m1 move-abs 90 --wait"),
    Task("wait until m1 stands still", "hil wait m1 'abs(velocity_rpm) < 0.1'"),
    Task("stop everything that moves", "hil stop"),
    Task("stop m1 and s1 alone", "hil stop m1 s1"),
    Task("start a run, and go on here", "hil run square.yaml --detach"),
    Task("see the state of a run", "hil run show square"),
    Task("make a run twice as slow", "hil run pace square 0.5"),
    Task("cancel a run", "hil run cancel square"),
    Task(
        "play a G-code file: on the line that the machine's file names",
        "hil gcode drawing.ngc --machine mill.yaml",
    ),
    Task("load a sketch", "hil sketch load u1 sketches/blink/build/blink.elf"),
    Task("compare a real board with its twin", "hil parity sac/identify --at /dev/ttyUSB0"),
    Task("what passes on bus0, live", "hil capture bus0"),
    Task("record what passes on bus0 in a file for Wireshark", "hil capture bus0 -w bus0.pcapng"),
    Task("scan a line for nodes", "hil line scan bus0.master"),
    Task("send a command to the node with address 85", "hil line send bus0.master 85 v150"),
    Task("send a text to the node with address 85", "hil line text bus0.master 85 good morning"),
    Task("which faults fit the SACs of the bench", "hil fault kinds sac"),
    Task("jam the shaft of m1 for 2 s", "hil fault inject shaft_jam m1 --for 2s"),
    Task("end all faults", "hil fault clear"),
    Task("read the manual of faults in the terminal", "hil docs reference#faults"),
    Task("which recordings there are", "hil recordings"),
    Task("replay last night's run, and compare each byte", "hil replay last"),
    Task(
        "replay it with another fault",
        "hil replay last --fault 'shaft_jam m1 at=12.5s for=1s'",
    ),
    Task("what differs between the last two recordings", "hil diff last-1 last"),
    Task("when the error of m1 was over 5 degrees", "hil find last 'abs(m1.e) >= 5'"),
    Task("the position of m1 as CSV, every 10 ms", "hil export last m1.position_deg -o m1.csv --every 10ms"),
    Task(
        "a test's failing second as a file, from its run.hil.gz",
        "hil export run.hil.gz -o second.csv --from 12s --to 13s",
    ),
    Task("all of a recording in one file, for a colleague", "hil bundle last -o bug.hilz --yes"),
    Task("read a page of the manual in the terminal, or search", "hil docs runs"),
    Task("complete commands and names in a shell", "hil completion bash"),
    Task("the version", "hil version"),
)
"""Tasks in the order in which a bench is made, watched, moved, broken and looked back at."""


def tasks_about(word: str) -> list[Task]:
    """Find the tasks that have a word, or its beginning, among those of what is wanted."""
    wanted = word.lower().strip()
    return [task for task in TASKS if any(each.startswith(wanted) for each in _words(task.want))]


def _words(want: str) -> list[str]:
    return "".join(each if each.isalnum() else " " for each in want.lower()).split()
