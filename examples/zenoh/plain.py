"""Moves two axes like ``two_axes.py``, but with zenoh alone, as it is done in any language that has it:
plain.py [BENCH [ENDPOINT]]."""

import json
import sys

import zenoh

bench, endpoint = (*sys.argv[1:], *["zen", "tcp/127.0.0.1:7447"][len(sys.argv) - 1 :])
config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([endpoint]))
with zenoh.open(config) as session:
    for key, payload in (
        ("axis/m1/cmd/enable", {}),
        ("axis/m1/cmd/move_abs", {"position_deg": 90}),
        ("axis/m1/cmd/jump", {}),
    ):
        for reply in session.get(f"hil/{bench}/{key}", payload=json.dumps(payload), timeout=5):
            answer = json.loads((reply.ok or reply.err).payload.to_string())
            print(key, answer.get("set_point") if reply.ok else answer["code"])
