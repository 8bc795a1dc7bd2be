"""Zenoh bridge over a reload: what is there, what it tells, and streams of what went on."""

import json
from itertools import pairwise
from typing import Any

import zenoh
from e2e_support import Place, Server, config, free_port, until
from plain_zenoh import Plain

SAC: dict[str, Any] = {"profile": "sac", "flash": {}}


def present(plain: Plain) -> set[str]:
    replies = plain.session.liveliness().get("hil/t/@live/axis/*")
    return {str(reply.ok.key_expr).rpartition("/")[2] for reply in replies if reply.ok}


def reload(place: Place, server: Server, port: int, devices: dict[str, Any]) -> dict[str, Any]:
    place.write(text(port, devices), "t.yaml")
    done: dict[str, Any] = server.ask("reload")
    assert "problems" not in done, done
    return done


def text(port: int, devices: dict[str, Any]) -> str:
    options = {"listen": [f"tcp/127.0.0.1:{port}"], "state_hz": 50}
    return config(speed=1, devices=devices, bridges={"zenoh": options})


def test_the_bridge_knows_who_is_there(place: Place) -> None:
    port = free_port()
    server = place.serve(text(port, {"m1": {}, "m2": {}, "s1": SAC}))
    plain = Plain(port)
    try:
        assert present(plain) == {"m1", "m2", "s1"}
        heard: dict[str, list[zenoh.Sample]] = {}
        for name in ("m1", "s1", "s2"):
            heard[name], _ = plain.listen(f"axis/{name}/state")
        until(lambda: heard["m1"] and heard["s1"], "states")
        lives: list[tuple[str, zenoh.SampleKind]] = []
        plain.session.liveliness().declare_subscriber(
            "hil/t/@live/axis/*", lambda s: lives.append((str(s.key_expr).rpartition("/")[2], s.kind))
        )
        new = {"m1": {}, "s1": SAC | {"axis": {"start_deg": 7.2}}, "s2": SAC}
        done = reload(place, server, port, new)
        assert (done["kept"], done["restarted"], done["added"], done["removed"]) == (
            ["m1"],
            ["s1"],
            ["s2"],
            ["m2"],
        )
        until(lambda: present(plain) == {"m1", "s1", "s2"}, "the tokens")
        until(lambda: len(lives) >= 4, "the changes")
        assert "m1" not in {name for name, _ in lives}
        counts = {name: len(samples) for name, samples in heard.items()}
        until(lambda: all(len(samples) > counts[n] + 5 for n, samples in heard.items()), "more states")
        times = [json.loads(sample.payload.to_string())["at_ns"] for sample in heard["m1"]]
        gaps = {later - earlier for earlier, later in pairwise(times)}
        assert (min(gaps), max(gaps) < 10 * 20_000_000) == (
            20_000_000,
            True,
        )  # zenoh may drop some under load
        assert plain.one("axis/s2/cmd/reset")["effective_at_ns"] > 0
        assert plain.one("axis/m2/cmd/reset")["code"] == "no_device"
        assert plain.one("verbs/s2")["verbs"]
        assert plain.get("axis/m2/state") == []
    finally:
        plain.session.close()  # type: ignore[no-untyped-call]
    assert "Traceback" not in server.stop()
