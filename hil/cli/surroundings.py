"""Environment variables and files of the reference."""

ENVIRONMENT = {
    "HIL_BENCH": "the bench that commands ask, as with --bench, which goes before it.",
    "XDG_RUNTIME_DIR": "`hil` in it is where benches have ports and sockets, unless --runtime-dir or the"
    " configuration says another folder. Without it: `hil-UID` in `$TMPDIR` or /tmp.",
    "XDG_STATE_HOME": "`hil` in it is where boards' memories are kept, unless --state-dir or the"
    " configuration says another folder. Without it: `$HOME/.local/state/hil`.",
    "HOME": "where the state is kept without XDG_STATE_HOME.",
    "RUNTIME_DIRECTORY": "of a systemd service: where its bench has ports and socket; a command in the"
    " unit looks for benches there only.",
    "STATE_DIRECTORY": "of a service: where its boards' memories are kept.",
    "LOGS_DIRECTORY": "of a service: where a relative `--log` file stands.",
    "NOTIFY_SOCKET": "of a service: where it says that it is ready, and how it is.",
    "WATCHDOG_USEC": "of a service: how often systemd wants to hear of it.",
    "WATCHDOG_PID": "of a service: which process that is meant for.",
    "JOURNAL_STREAM": "of a service: whether its messages go to the journal, with priorities.",
    "NO_COLOR": "if it is set, no colours on terminals (https://no-color.org).",
    "TERM": "`dumb`: no colours either.",
    "ARDUINO_DIRECTORIES_USER": "the sketchbook for `hil arduino`, unless --sketchbook says another.",
}
FILES = {
    "$XDG_RUNTIME_DIR/hil/BENCH/DEVICE": "a device's pseudo-terminal, under a name that stays",
    "$XDG_RUNTIME_DIR/hil/BENCH/control.sock": "where commands ask a running bench",
    "$XDG_STATE_HOME/hil/BENCH/DEVICE.nvm": "what a board's flash or EEPROM has",
    "/etc/hil/bench.yaml": "the configuration of the service `hil.service`",
    "/etc/hil/NAME.yaml": "that of `hil@NAME.service`",
}
