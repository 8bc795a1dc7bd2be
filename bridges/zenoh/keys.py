"""Keys in one table: the content of each, who may use it, an example. The reference is made from it."""

import re
from dataclasses import dataclass

from hil.vocab.verbs import Role

JSON_VERSION = 1
"""Version of all JSON here: it stands in ``v`` and in the encoding's schema."""
JSON, PACKED, BYTES = "JSON", "binary", "bytes"


@dataclass(frozen=True)
class Key:
    """Kind of key below ``hil/<bench>/``. ``way``: publish (the daemon tells), query (it answers), command (a
    put is carried out, a query too and is answered)."""

    pattern: str
    way: tuple[str, ...]
    payload: str
    schema: str
    role: Role
    about: str
    example: str


ABOUT = "about"
PUBLISH, QUERY, COMMAND, TOKEN = "publish", "query", "command", "liveliness"
KEYS = (
    Key("axis/<device>/state", (PUBLISH, QUERY), JSON, "hil.state.v1", Role.VIEWER,
        "an axis, `state_hz` times a simulated second while somebody subscribes",
        '{"v":1,"at_ns":7400000000,"wall_ns":1795254243120000000,"position_deg":89.96,"velocity_rpm":0.0}'),
    Key("axis/<device>/state/packed", (PUBLISH, QUERY), PACKED, "hil.snapshot.v1", Role.VIEWER,
        "all its fields in the binary layout of `layout`, `packed_hz` times a simulated second",
        "408 bytes, little-endian"),
    Key("axis/<device>/cmd/<verb>", (COMMAND,), JSON, "hil.ack.v1", Role.OPERATOR,
        "carry out a verb: its parameters as an object. `?applied=true`: a second reply with the "
        "state then, `?done=true`: one more when the motion has ended (both with consolidation none)",
        '{"position_deg":90} answers {"v":1,"effective_at_ns":7349071142,"set_point":90.0}'),
    Key("axis/<device>/param/<name>", (QUERY, COMMAND), JSON, "hil.param.v1", Role.OPERATOR,
        "a settable field: a query without payload reads it, a number sets it",
        '15.0 answers {"v":1,"effective_at_ns":7500000000,"pKp":15.0}'),
    Key("verbs/<device>", (QUERY,), JSON, "hil.verbs.v1", Role.VIEWER,
        "verbs of a device",
        '{"v":1,"device":"m1","profile":"mechaduino","verbs":[{"verb":"enable"}]}'),
    Key("layout", (QUERY,), JSON, "hil.layout.v1", Role.VIEWER,
        "the fields of the binary layout; new ones come at the end",
        '{"v":1,"fields":[{"name":"at_ns","type":"i64","offset":0,"unit":"ns"}]}'),
    Key("segment/<name>/packets", (PUBLISH,), JSON, "hil.packet.v1", Role.VIEWER,
        "each burst on a segment; what a disturbed line reads as has `is_damaged`",
        '{"v":1,"at_ns":1203004166,"data":"0204017631353003c000","about":"bus0.m","is_damaged":false}'),
    Key("segment/<name>/stats", (PUBLISH, QUERY), JSON, "hil.stats.v1", Role.VIEWER,
        "its counters, once a second", '{"v":1,"segment":"bus0","packets":120,"collisions":0}'),
    Key("segment/<name>/fault", (COMMAND,), JSON, "hil.fault.v1", Role.ADMIN,
        "begin a fault on it or one of its taps, or end it",
        '{"fault":"wire_noise","rate":0.01} answers {"v":1,"number":3}; {"clear":3} or {"clear":"all"}'),
    Key("axis/<device>/fault", (COMMAND,), JSON, "hil.fault.v1", Role.ADMIN,
        "the same on a device or one of its ports (`target`)",
        '{"fault":"shaft_jam","for_s":0.5} answers {"v":1,"number":4}'),
    Key("port/<name>/rx", (PUBLISH,), BYTES, "hil.port.v1", Role.VIEWER,
        "bytes that a board receives at a port; the attachment has the times", "r90\\r"),
    Key("port/<name>/tx", (PUBLISH,), BYTES, "hil.port.v1", Role.VIEWER,
        "bytes that it sends", "Enter setpoint:\\r\\n"),
    Key("sim/clock", (PUBLISH, QUERY), JSON, "hil.clock.v1", Role.VIEWER,
        "simulated and wall time, once a second",
        '{"v":1,"sim_ns":7400000000,"wall_ns":1795254243120000000}'),
    Key("sim/health", (PUBLISH, QUERY), JSON, "hil.health.v1", Role.VIEWER,
        "health and what is wrong, ticks, missed wakes, rejected commands, failed devices, once a second",
        '{"v":1,"state":"ok","late_ms":0.4,"problems":[],"rt":"ok","ticks":7400,"missed":0,"rejected":0,"failed":{}}'),
    Key(ABOUT, (PUBLISH, QUERY), JSON, "hil.about.v1", Role.VIEWER,
        "what the bench is and how it does: versions, host, labels, devices, health, runs, who commands; told"
        " again when it changes. A query on `hil/*/about` asks all",
        '{"v":1,"bench":"b","version":"0.3.0","protocol":1,"host":"lab1","labels":{"rig":"press"},'
        '"devices":{"m1":{"profile":"mechaduino","axes":["m1"],"is_real":false}},"lease":null}'),
    Key("sim/rejected", (PUBLISH,), JSON, "hil.error.v1", Role.VIEWER,
        "each command that was refused, for its sender or for others",
        '{"v":1,"key":"hil/b/axis/m1/cmd/jump","code":"no_verb","error":"m1, a mechaduino, has no '
        "'jump'\"}"),
    Key("sim/commands", (PUBLISH,), JSON, "hil.command.v1", Role.VIEWER,
        "each command with user, door and outcome, as `hil log commands` has it; streams, and what is more"
        " than 50 a second, are summed once a second",
        '{"v":1,"number":7,"sim_ns":7400000000,"wall_ns":1795254243120000000,"user":"ann","door":"zenoh",'
        '"role":"operator","operation":"move_abs","target":"m1","given":{"position_deg":90},"outcome":"done",'
        '"chain":"..."}'),
    Key("halt", (COMMAND,), JSON, "hil.ack.v1", Role.OPERATOR,
        "stop all axes that move and end all runs; it comes before all that waits: {\"how\":\"grace\"} is a"
        " controlled stop, {\"how\":\"prejudice\"} an immediate one. A query on `hil/*/halt` stops all"
        " benches, and each answers under its own key",
        '{} answers {"v":1,"stopped":["m1"],"runs":["square"],"refused":{}}'),
    Key("lease", (PUBLISH, QUERY), JSON, "hil.lease.v1", Role.VIEWER,
        "who has the bench, once a second: null is nobody",
        '{"v":1,"lease":{"user":"ann","until_wall_ns":1795257843120000000,"why":"press tests","doors":[]}}'),
    Key("lease/<do>", (COMMAND,), JSON, "hil.lease.v1", Role.OPERATOR,
        "take, renew, give or break a lease: parameters as of the operations `take_lease` to `break_lease`",
        'hil/b/lease/take {"why":"press tests","for_s":3600} answers {"v":1,"lease":{"user":"ann"}}'),
    Key("run/submit", (COMMAND,), "YAML or JSON", "hil.run.v1", Role.OPERATOR,
        "submit a multi-axis run; the same text again answers how it does, and does nothing twice; "
        "another text under its name is refused",
        '{"run":"r1","axes":{"m1":{}},"steps":[{"move":{"m1":90}}]} answers '
        '{"v":1,"run":"r1","state":"queued"}'),
    Key("run/<id>/state", (PUBLISH, QUERY), JSON, "hil.run.v1", Role.VIEWER,
        "how a run does: queued, running, done, failed or cancelled, its step, its axes' following errors",
        '{"v":1,"run":"r1","state":"running","step":1,"steps":2}'),
    Key("run/<id>/cancel", (COMMAND,), JSON, "hil.run.v1", Role.OPERATOR,
        'end a run: {"how":"grace"} is a controlled stop, {"how":"prejudice"} an immediate one', "{}"),
    Key("run/<id>/part", (COMMAND,), JSON, "hil.part.v1", Role.OPERATOR,
        "between benches: the one that leads a run asks the others to look, join, go, beat or stop;"
        " `protocol` is the version of what they say, in questions and answers",
        '{"do":"go","protocol":1,"token":"...","phrase":0,"start_wall_ns":1795254243120000000}'),
    Key("@live/daemon", (TOKEN,), "", "", Role.VIEWER, "the daemon runs", ""),
    Key("@live/axis/<device>", (TOKEN,), "", "", Role.VIEWER, "the device is there", ""),
    Key("@live/segment/<name>", (TOKEN,), "", "", Role.VIEWER, "the segment is there", ""),
    Key("@one/<number>", (TOKEN,), "", "", Role.VIEWER,
        "a daemon of this name, each with a number of its own: two of them are two benches of one name", ""),
)  # fmt: skip
SCHEMAS = {key.pattern: key.schema for key in KEYS}


def prefix(bench: str) -> str:
    """Prefix of all the keys of a bench."""
    return f"hil/{bench}"


def expression(bench: str, pattern: str) -> str:
    """Key expression of a row of the table on a bench."""
    return f"{prefix(bench)}/{re.sub('<[a-z]+>', '*', pattern)}"


def reference() -> str:
    """Part of the reference about keys, as Markdown."""
    lines = [
        "## Keys of the zenoh bridge\n",
        "Below `hil/<bench>/`. JSON carries its version in `v`, its schema in the encoding, and the times at"
        " which it was written: `sim_ns`, and `wall_ns` since 1970. A command is put, and then nothing comes"
        " back, or queried, and then answered; a refusal is an error reply with a `code` (see Verbs of"
        " devices). A role is the least that may use the key, where the bench has users.\n",
        "| key | way | payload | schema | role | what | example |",
        "|---|---|---|---|---|---|---|",
    ]
    for key in KEYS:
        example = f"`{key.example}`" if key.example else ""
        cells = (f"`{key.pattern}`", ", ".join(key.way), key.payload, key.schema, key.role.name.lower())
        lines.append("| " + " | ".join((*cells, key.about, example)) + " |")
    return "\n".join(lines) + "\n"
