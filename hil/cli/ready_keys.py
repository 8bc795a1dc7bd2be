"""Keys of the JSON object with which ``hil serve`` tells programs that the boards answer."""

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
