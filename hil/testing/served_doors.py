"""Clients of the doors of a bench that is served."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from hil.net.endpoint import endpoint
from hil.testing.given import no_such

ZENOH = "tcp/"
"""Beginning of an address of a zenoh bridge that sessions of a test can join."""
_SERIAL = "/"
"""Beginning of the path of a serial line, among the places at which a Modbus bridge listens."""


def modbus_client(listens: Sequence[str], name: str, options: Mapping[str, Any]) -> Any:
    """Connect a client of pymodbus to one of the places at which a Modbus bridge listens: a serial line by
    its path, or with an empty name its TCP. Raises KeyError: there is no such line."""
    from pymodbus.client import ModbusSerialClient, ModbusTcpClient

    lines = {each: each for each in listens if each.startswith(_SERIAL)}
    if name and name not in lines:
        raise no_such("serial line of the Modbus bridge", name, lines)
    if name:
        made: Any = ModbusSerialClient(name, **options)
    else:
        host, port = endpoint(next(each for each in listens if each not in lines))
        made = ModbusTcpClient(host, **{"port": port} | dict(options))
    made.connect()
    return made


def zenoh_session(address: str) -> Any:
    """Open a session of zenoh at a bridge that listens at this address."""
    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([address]))
    return zenoh.open(config)
