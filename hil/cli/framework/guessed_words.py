"""Words that newcomers type, and the command that each means: an error names it."""

import re
from collections.abc import Collection, Sequence

GUESSES = {
    # Begin and end.
    **dict.fromkeys(("start", "up", "begin", "launch", "daemon", "boot"), "serve bench.yaml"),
    **dict.fromkeys(("simulate", "sim", "emulate", "twin"), "serve bench.yaml"),
    **dict.fromkeys(("kill", "quit", "exit", "down", "end", "close", "terminate"), "shutdown"),
    **dict.fromkeys(("rm", "remove", "delete", "detach"), "shutdown"),
    "restart": "shutdown` and `hil serve bench.yaml",
    **dict.fromkeys(("new", "create", "setup", "quickstart", "clone"), "init"),
    **dict.fromkeys(("validate", "lint", "verify"), "check bench.yaml"),
    **dict.fromkeys(("refresh", "apply"), "reload"),
    **dict.fromkeys(("freeze", "hold"), "pause"),
    **dict.fromkeys(("continue", "unpause"), "resume"),
    **dict.fromkeys(("reserve", "book", "lock"), "lease take"),
    # What there is, and how it does.
    **dict.fromkeys(("ps", "ls", "show", "bench", "ports", "port", "devices"), "list"),
    **dict.fromkeys(("nodes", "axes", "addresses"), "list"),
    **dict.fromkeys(("info", "health", "fields", "position", "get", "read", "print"), "status"),
    **dict.fromkeys(("inspect", "describe", "is-active", "whereis"), "status"),
    **dict.fromkeys(("boards", "profiles", "kinds"), "profile list"),
    "motors": "profile motors",
    **dict.fromkeys(("live", "dashboard", "htop", "watch", "follow"), "top"),
    **dict.fromkeys(("logs", "journal", "journalctl", "dmesg", "said"), "log"),
    "tail": "log --follow",
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
    **dict.fromkeys(
        ("terminal", "console", "connect", "serial", "screen", "picocom", "attach"), "monitor m1"
    ),
    **dict.fromkeys(("send", "write", "echo", "exec"), "type m1 'TEXT'"),
    **dict.fromkeys(("reboot", "power", "power-cycle"), "reset m1"),
    **dict.fromkeys(("upload", "flash"), "sketch load u1 FILE"),
    **dict.fromkeys(("compile", "build"), "sketch build FOLDER"),
    **dict.fromkeys(("gdb", "debug"), "sketch gdb u1"),
    "torque": "set m1 load_torque_Nm 0.05",
    # Lines and buses.
    **dict.fromkeys(("sniff", "tcpdump", "traffic", "dump", "spy", "wireshark"), "capture bus0"),
    **dict.fromkeys(("scan", "discover"), "line scan bus0.master"),
    **dict.fromkeys(("master", "bus", "rs485"), "line"),
    **dict.fromkeys(("pub", "publish", "sub", "subscribe", "mqtt", "topic"), "docs zenoh"),
    **dict.fromkeys(("port-forward", "forward", "expose", "socat"), "docs ports"),
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


_ALIKE = (
    {"inject", "add", "create", "new", "make", "take", "start", "begin", "build", "load"},
    {"clear", "remove", "delete", "rm", "del", "unset", "cancel", "stop", "end", "give", "break", "abort"},
    {"list", "ls", "show", "status", "get", "all", "info", "nodes", "kinds"},
    {"map", "read", "poll", "registers", "dump"},
    {"send", "write", "put", "text", "type", "command"},
    {"scan", "find", "search", "discover"},
    {"watch", "monitor", "follow", "listen"},
)
"""Verbs that people use for each other."""
_ENDINGS = {(".yaml", ".yml"): "serve", (".hil", ".hilz", ".gz"): "replay", (".ngc", ".gcode"): "gcode"}
_DEVICE = re.compile(r"[a-z]+[0-9]+(\.\w+)?")


def guessed(word: str) -> str:
    """Find the command line that a word means; empty if it is none that is guessed."""
    return GUESSES.get(word.lower().replace("_", "-"), "")


def guessed_line(words: Sequence[str], commands: Collection[str]) -> str:
    """Command line that somebody means who typed these words, of which the first is no command: by the word,
    a slip of one, a file's ending, or a device before its verb; empty: none."""
    word, rest = words[0], words[1:2]
    if line := guessed(word):
        return line
    for endings, command in _ENDINGS.items():
        if word.endswith(endings):
            return f"{command} {word}"
    if rest and rest[0] in commands and not rest[0].startswith("-"):
        return f"{rest[0]} {word}"
    if _DEVICE.fullmatch(word):
        return f"status {word}"
    if any(known.startswith(word) for known in commands):
        return ""
    near = min(GUESSES, key=lambda known: slips(word, known))
    least = min((slips(word, known) for known in commands), default=len(word))
    return GUESSES[near] if slips(word, near) < min(least, _most_slips(word) + 1) else ""


def alike(word: str, known: Collection[str]) -> list[str]:
    """Known verbs that people say such a verb for."""
    return [name for name in known for verbs in _ALIKE if {word, name} <= verbs]


def is_slip(word: str, known: str) -> bool:
    """True if a word is so near a known one, or its beginning, that it is likely a slip of it."""
    plain, other = (each.lower().replace("_", "-") for each in (word, known))
    return other.startswith(plain) or slips(plain, other) <= _most_slips(word)


def _most_slips(word: str) -> int:
    return max(1, len(word) // 3)


def slips(word: str, known: str) -> int:
    """Number of slips between two words: letters that were added, left out, mistaken or swapped."""
    before: list[int] = []
    row = list(range(len(known) + 1))
    for i, letter in enumerate(word):
        before, last, row = row, before, [i + 1]
        for j, other in enumerate(known):
            row.append(min(before[j + 1] + 1, row[j] + 1, before[j] + (letter != other)))
            if i and j and letter == known[j - 1] and word[i - 1] == other:
                row[-1] = min(row[-1], last[j - 1] + 1)
    return row[-1]
