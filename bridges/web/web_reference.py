"""The web bridge's part of the reference."""

from bridges.web.http_door import SUBPROTOCOL
from bridges.web.streams import MOST_ITEMS
from bridges.web.web_client import STALLED_S
from bridges.web.web_messages import SAMPLES, TERMINAL, TIMED
from bridges.web.web_terminals import TYPED_BYTES
from bridges.web.web_watches import KINDS, MOST_READINGS_HZ
from bridges.web.wire_streams import KEPT_EVENTS

HTTP = {
    "GET /": "the page; `/NAME` its other files",
    "GET /api/hello": "`version` of the page, `login` (none, token or password), `user` and `role`, null"
    " before logging in",
    "POST /api/login": 'JSON, `{"user": "...", "password": "..."}` or `{"token": "..."}`: 204 with a cookie;'
    " 401, or 429 after too many attempts",
    "POST /api/logout": "ends the session and its pages",
    "GET /ws": f"WebSocket, subprotocol `{SUBPROTOCOL}`",
}
REQUESTS = {
    "ask": ("operation, target, given", "an operation of the table, with the role of the user; its answer"),
    "watch": (
        "what, target, fields, rate_Hz, points",
        f"tells from now on: {', '.join(KINDS)}; `watch`, its number. `fields` are for samples, at `rate_Hz`"
        " in simulated time. With `points` above 1, two samples of each interval have the smallest and the"
        " largest value of each field of so many looks, in the order in which they came: what swings faster"
        " has its true size. `events` tells those that are kept, then each as it happens, and again when"
        " others have joined it (its `count`). `status` and `faults` are told up to"
        f" {MOST_READINGS_HZ:g} times a second, when"
        " they have changed, and `clock`, the door's own, always",
    ),
    "unwatch": ("watch", "ends a watch"),
    "open": (
        "port, details",
        "opens a terminal at a port; `terminal`, its number, and `clients`: other programs that have it open."
        " All pages at a port see the same. With `details` what it says comes with its time, and `taken` is"
        f" told. A port of which more than {TYPED_BYTES // 1024} KiB wait to be taken is closed",
    ),
    "close": ("terminal", "closes a terminal"),
    "send": ("segment, data_hex, tap", "sends bytes on a segment from a tap; without one from its first"),
    "fields": (
        "wire, packets",
        "`fields` of the last of the packets, with their bytes; those before it tell what it answers. Each"
        " is `AT_S HEX` on a segment, a frame as `585#4300` on a bus",
    ),
    "export": ("watch", f"`pcapng_base64`: the last {KEPT_EVENTS:,} events of a watch of packets or frames"),
}
PUSHES = {
    "hello": "the first message: the bench with its devices, verbs, fields, segments, buses, ports,"
    " operations and kinds of faults; `user`, `role`, `version`; `instance`, another one for each start;"
    " `message_bytes`, the limit of a page's messages",
    "changed": "the same, after a reload",
    "watch, items, lost": f"what came since the last time; of more than {MOST_ITEMS:,} that wait the oldest"
    " are lost, and counted",
    "watch, value": "answer of `status` or `faults`; of `clock` its time in ms",
    "taken": "of a terminal with `details`: how many `bytes` of what was typed at it the port has"
    " taken so far",
    "closed": "a terminal or a watch that has ended, and `why`",
}


def reference() -> str:
    """Part of the reference about what pages and programs are served."""
    rows = [f"| `{name}` | {about} |" for name, about in HTTP.items()]
    requests = [f"| `{do}` | `{given}` | {about} |" for do, (given, about) in REQUESTS.items()]
    pushes = [f"| `{name}` | {about} |" for name, about in PUSHES.items()]
    return "\n".join(
        [
            "## The web bridge",
            "",
            "| request | answer |",
            "|---|---|",
            *rows,
            "",
            "`Host` has to be a name of the bench, and `Origin`, where a browser sends it, its own page.",
            "",
            "A text message is a JSON object. A request has a number, and its answer repeats it:"
            ' `{"id": 1, "do": "ask", "operation": "faults"}` is answered with `{"id": 1, "answer": ...}` or'
            ' `{"id": 1, "error": {"code": "...", "message": "..."}}`. Codes are those of the control'
            " socket. Stops, the verb `stop` and `halt`, pass what waits, and what they pass moves nothing"
            " any more. A request with `until_ms`, a time of the watch `clock`, is refused with `not_now` if"
            " its turn comes later: nothing is done long after it was asked for.",
            "",
            "| `do` | given | what it does, and answers |",
            "|---|---|---|",
            *requests,
            "",
            "| message from the bench | what it has |",
            "|---|---|",
            *pushes,
            "",
            "Binary messages are little-endian. Samples are blocks one after the other:"
            f" u8 {SAMPLES}, u8 number of fields, u16 0, u32 watch, u32 lost, u32 rows, then for each row"
            " f64 `at_s` and an f64 for each field. Terminals, both ways:"
            f" u8 {TERMINAL}, u8 0, u16 0, u32 terminal, then bytes. With `details` what a port says is"
            f" u8 {TIMED}, u8 0, u16 0, u32 terminal, f64 `at_s`, the simulated time at which hil had it,"
            " then bytes.",
            "",
            "What a page does not read is dropped and counted. After"
            f" {STALLED_S:g} s without reading it loses the socket, and has to come back.",
        ]
    )
