"""Environment variables and files of the reference, and keys of the JSON object with which ``hil serve``
tells programs that the boards answer."""

ENVIRONMENT = {
    "HIL_BENCH": "the bench that commands ask, as with --bench; --bench takes precedence.",
    "HIL_LAB_CONFIG": "the user's zenoh.json that says where the lab is, for the fixture `lab_bench` without"
    " --lab-config and for labgrid's driver.",
    "HIL_LANES": "how axes move together in the core: none, any, avx2, avx512; without it the widest that the"
    " processor has. The results are the same bits.",
    "XDG_RUNTIME_DIR": "`hil` in it is where benches have ports and sockets, unless --runtime-dir or the"
    " configuration says another folder. Without it: `hil-UID` in `$TMPDIR` or /tmp.",
    "XDG_STATE_HOME": "`hil` in it is where boards' memories are kept, unless --state-dir or the"
    " configuration says another folder. Without it: `$HOME/.local/state/hil`.",
    "XDG_CACHE_HOME": "`hil/sketch` in it is where `hil sketch build` keeps what it compiled of the Arduino"
    " core and of libraries. Without it: `$HOME/.cache/hil/sketch`.",
    "HOME": "place of the state without XDG_STATE_HOME, and of the cache without XDG_CACHE_HOME.",
    "RUNTIME_DIRECTORY": "of a systemd service: where its bench has ports and socket; a command in the"
    " unit looks for benches there only.",
    "STATE_DIRECTORY": "of a service: folder of its boards' memories.",
    "LOGS_DIRECTORY": "of a service: folder of a relative `--log` file.",
    "NOTIFY_SOCKET": "of a service: where it reports that it is ready, and its status.",
    "WATCHDOG_USEC": "of a service: the watchdog's time.",
    "WATCHDOG_PID": "of a service: the process that the watchdog is for.",
    "JOURNAL_STREAM": "of a service: whether its messages go to the journal, with priorities.",
    "PYTHONPATH": "of `hil virtual`: child processes of its program have it too, behind a folder of hil's.",
    "NO_COLOR": "if it is set, no colours on terminals (https://no-color.org).",
    "TERM": "`dumb`: no colours either.",
    "PAGER": "pager of `hil docs`. Without it: less.",
    "ARDUINO_DIRECTORIES_USER": "the sketchbook of the IDE 2 and of arduino-cli for `hil arduino`, unless"
    " --sketchbook names another.",
    "PATH": "where `hil with-lines` finds the program, `hil sketch build` the compiler, and `hil arduino` a"
    " portable IDE.",
    "LD_PRELOAD": "`hil with-lines` adds its library to it, for the program that it starts.",
}
FILES = {
    "$XDG_RUNTIME_DIR/hil/BENCH/DEVICE": "a device's pseudo-terminal; the name stays from start to start",
    "$XDG_RUNTIME_DIR/hil/BENCH/control.sock": "the socket at which commands ask a running bench",
    "$XDG_STATE_HOME/hil/BENCH/DEVICE.nvm": "contents of a board's flash or EEPROM",
    "$XDG_STATE_HOME/hil/BENCH/recordings/DATE.hil.gz": "the recording of a run, for `hil recordings`",
    "/etc/hil/bench.yaml": "the configuration of the service `hil.service`",
    "/etc/hil/NAME.yaml": "that of `hil@NAME.service`",
}


READY: dict[str, str] = {
    "bench": "the bench's name",
    "pid": "process of `hil serve`",
    "version": "version of hil",
    "control": "path of the control socket",
    "speed": "simulated seconds in a second",
    "sim_ns": "simulated time when the boards answered",
    "ports": "by address (`m1`, `s1.network`, `bus0.master`): path or URL, for pyserial's `serial_for_url`",
    "bauds": "by address: speed of the port; null: any",
    "bridges": "by kind: the list of addresses at which it listens",
    "failed": "devices that have stopped, each with the reason",
}
"""Keys of the object, with their meanings."""
