"""Quiet end of a bench with the zenoh bridge, whatever still comes in."""

import json
import socket
import threading
import time
from contextlib import suppress

import pytest
from e2e_support import Place, config

zenoh = pytest.importorskip("zenoh")


def test_commands_that_are_refused_while_it_ends() -> None:
    with socket.socket() as free, Place() as place:
        free.bind(("127.0.0.1", 0))
        address = f"tcp/127.0.0.1:{free.getsockname()[1]}"
        free.close()
        server = place.serve(config(bridges={"zenoh": {"listen": [address]}}))
        chosen = zenoh.Config()
        chosen.insert_json5("mode", '"client"')
        chosen.insert_json5("connect/endpoints", json.dumps([address]))
        session, over = zenoh.open(chosen), threading.Event()

        def flood() -> None:
            with suppress(zenoh.ZError):
                while not over.wait(0.0003):
                    session.put("hil/t/axis/m1/cmd/velocity", b'{"velocity_rpm": "x"}')

        sender = threading.Thread(target=flood)
        sender.start()
        time.sleep(1)
        try:
            server.stop()
        finally:
            over.set()
            sender.join()
            with suppress(zenoh.ZError):
                session.close()
