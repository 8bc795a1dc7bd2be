"""Answers of a bench that runs: each fits the schema that the reference has of it."""

import base64
import json
from typing import Any

import jsonschema
from e2e_support import Place, config
from markdown_blocks import block

SCHEMAS = json.loads(block("docs/reference.md", "Answers"))
HEX = base64.b64encode(b":02000000FFCF30\n:00000001FF\n").decode()
"""Program of one instruction, which jumps to itself."""
RUN = "run: near\naxes: {m1: {}}\nsteps: [{wait: 0.01}]\n"
LONG = "run: far\naxes: {m1: {}}\nsteps: [{dwell_s: 0.01}]\n"
ASKED: tuple[tuple[str, dict[str, Any]], ...] = (
    ("list", {}),
    ("status", {}),
    ("health", {}),
    ("segments", {}),
    ("buses", {}),
    ("about", {}),
    ("benches", {}),
    ("verbs", {"device": "m1"}),
    ("state", {"device": "s1"}),
    ("registers", {"device": "m1"}),
    ("processor", {"device": "u1"}),
    ("eds", {"device": "m1"}),
    ("pin", {"device": "m1", "pin": "D2", "level": 0}),
    ("set", {"device": "m1", "field": "pKi", "value": 0.2}),
    ("zero", {"device": "s1"}),
    ("type", {"device": "m1", "text": "p"}),
    ("send", {"device": "m1", "data": "70"}),
    ("do", {"device": "m1", "name": "gains", "parameters": {}}),
    ("drive", {"device": "m1", "train": []}),
    ("play", {"tap": "bus0.master", "bursts": [[0, "00"]]}),
    ("attach", {"bus": "can0", "node": "tester"}),
    ("transmit", {"channel": "can0.tester", "frames": ["123#0011"]}),
    ("detach", {"channel": "can0.tester"}),
    ("watch", {"device": "m1", "signals": [], "interval_ns": 1_000_000}),
    ("samples", {"watch": 1}),
    ("unwatch", {"watch": 1}),
    ("inject", {"target": "m1", "fault": "byte_drop", "parameters": {"rate": 0.1}}),
    ("faults", {}),
    ("fault_places", {}),
    ("past", {}),
    ("past_state", {"at_s": 0.1}),
    ("past_samples", {"fields": ["m1.e"], "from_s": 0, "to_s": 0.1}),
    ("past_bytes", {"port": "s1", "at_s": 0.1}),
    ("past_packets", {"wire": "bus0", "at_s": 0.1}),
    ("past_find", {"condition": "m1.e > -1", "from_s": 0}),
    ("status", {}),
    ("clear", {"number": "all", "on": ""}),
    ("run", {"text": RUN, "file": "r.yaml", "check": True, "name": "", "fresh": True}),
    ("run", {"text": LONG, "check": True, "points": 100}),
    ("run", {"text": RUN, "file": "r.yaml", "check": False, "name": "", "fresh": True}),
    ("runs", {"name": ""}),
    ("drawing", {"text": "G1 X1 F1\n", "machine": "x: y\n"}),
    ("wait", {"device": "m1", "effective_at_ns": 0, "at_most_s": 0}),
    ("reset", {"device": "s1"}),
    ("count", {"device": "u1", "starts": [0], "lap_at": -1}),
    ("counted", {"device": "u1"}),
    ("count", {"device": "u1", "starts": []}),
    ("load_program", {"device": "u1", "program": HEX, "file": "still.hex"}),
    ("lease", {}),
    ("take_lease", {"why": "tests", "for_s": 60, "doors": ["ports"]}),
    ("status", {}),
    ("renew_lease", {"for_s": 120}),
    ("give_lease", {}),
    ("take_lease", {"why": "tests", "for_s": 60}),
    ("break_lease", {}),
    ("halt", {}),
    ("stop_site", {"within_s": 5.0}),
    ("events", {"after": 0}),
    ("pause", {}),
    ("resume", {}),
    ("reload", {}),
    ("stop", {}),
)
NOT_ASKED = {
    "read_text": "device_profiles/sac/tests have texts of a SAC",
    "capture": "the connection goes on as a capture",
    "debug": "the connection goes on with GDB's packets",
    "cancel_run": "its answer is a run, as of `runs`",
    "pace_run": "its answer is a run, as of `runs`",
}
"""Verbs without a case here, with the reason."""
CAN = {"can0": {"bit_rate": 500000, "nodes": {"m1": 5}}}
LINE = {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}}


def test_each_answer_fits_its_schema(place: Place) -> None:
    devices = {"m1": {}, "s1": {"profile": "sac", "flash": {}}, "u1": {"profile": "uno"}}
    server = place.serve(config(devices=devices, segments=LINE, can=CAN)).ready()
    for verb, given in ASKED:
        jsonschema.validate(server.ask(verb, timeout_s=60, **given), SCHEMAS[verb])
    assert {verb for verb, _ in ASKED} | NOT_ASKED.keys() == SCHEMAS.keys()
