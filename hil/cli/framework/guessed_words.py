"""Words that newcomers type, and the command that each means: an error names it."""

GUESSES = {
    # Begin and end.
    **dict.fromkeys(("start", "up", "begin", "launch", "daemon", "boot"), "serve bench.yaml"),
    **dict.fromkeys(("simulate", "sim", "emulate", "twin"), "serve bench.yaml"),
    **dict.fromkeys(("kill", "quit", "exit", "down", "end", "close", "terminate"), "shutdown"),
    "restart": "shutdown` and `hil serve bench.yaml",
    **dict.fromkeys(("new", "create", "setup", "quickstart"), "init"),
    **dict.fromkeys(("validate", "lint", "verify"), "check bench.yaml"),
    **dict.fromkeys(("refresh", "apply"), "reload"),
    **dict.fromkeys(("freeze", "hold"), "pause"),
    **dict.fromkeys(("continue", "unpause"), "resume"),
    **dict.fromkeys(("reserve", "book", "lock"), "lease take"),
    # What there is, and how it does.
    **dict.fromkeys(("ps", "ls", "show", "bench", "ports", "port", "devices"), "list"),
    **dict.fromkeys(("nodes", "axes", "addresses"), "list"),
    **dict.fromkeys(("info", "health", "fields", "position", "get", "read"), "status"),
    **dict.fromkeys(("boards", "profiles", "kinds"), "profile list"),
    "motors": "profile motors",
    **dict.fromkeys(("live", "dashboard", "htop"), "top"),
    **dict.fromkeys(("logs", "journal", "said"), "log"),
    **dict.fromkeys(("history", "who"), "log commands"),
    **dict.fromkeys(("man", "manual", "pages", "tutorial", "faq"), "docs"),
    # Motion.
    **dict.fromkeys(("move", "move-abs", "goto", "go", "turn", "rotate", "jog"), "axis m1 move-abs 90"),
    "move-rel": "axis m1 move-rel 90",
    **dict.fromkeys(("enable", "disable", "home", "velocity"), "axis m1"),
    **dict.fromkeys(("abort", "estop", "brake", "e-stop", "emergency"), "stop"),
    **dict.fromkeys(("cancel",), "run cancel NAME"),
    "steps": "pulses m1 --steps 3200",
    **dict.fromkeys(("cnc", "g-code", "nc"), "gcode FILE --machine FILE"),
    **dict.fromkeys(("graph", "draw", "scope", "oscilloscope"), "plot m1"),
    # Boards.
    **dict.fromkeys(("terminal", "console", "connect", "serial", "screen", "picocom"), "monitor m1"),
    **dict.fromkeys(("send", "write", "echo"), "type m1 'TEXT'"),
    **dict.fromkeys(("reboot", "power", "power-cycle"), "reset m1"),
    **dict.fromkeys(("upload", "flash"), "sketch load u1 FILE"),
    **dict.fromkeys(("compile", "build"), "sketch build FOLDER"),
    **dict.fromkeys(("gdb", "debug"), "sketch gdb u1"),
    "torque": "set m1 load_torque_Nm 0.05",
    # Lines and buses.
    **dict.fromkeys(("sniff", "tcpdump", "traffic", "dump", "spy", "wireshark"), "capture bus0"),
    "watch": "capture bus0",
    **dict.fromkeys(("scan", "discover"), "line scan bus0.master"),
    **dict.fromkeys(("master", "bus", "rs485"), "line"),
    # Faults, recordings.
    **dict.fromkeys(("faults", "errors"), "fault list"),
    **dict.fromkeys(("inject", "break", "fail"), "fault inject KIND TARGET"),
    "clear": "fault clear",
    **dict.fromkeys(("record", "recording"), "recordings"),
    **dict.fromkeys(("rewind", "playback"), "replay RECORDING"),
    **dict.fromkeys(("csv", "convert"), "export RECORDING"),
    **dict.fromkeys(("search", "grep"), "find RECORDING CONDITION"),
    **dict.fromkeys(("compare",), "diff RECORDING OTHER"),
    **dict.fromkeys(("zip", "pack", "report"), "bundle RECORDING"),
    # This program.
    **dict.fromkeys(("test", "pytest"), "docs ci"),
    **dict.fromkeys(("diagnose", "self-test"), "doctor"),
}
"""Command lines by the word, without ``hil``; names and words in capitals stand for one's own."""


def guessed(word: str) -> str:
    """Find the command line that a word means; empty if it is none that is guessed."""
    return GUESSES.get(word.lower().replace("_", "-"), "")
