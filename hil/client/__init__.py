"""A client of a bench over zenoh, for scripts in other processes and on other hosts.

``connect`` is for asyncio, ``connect_sync`` for everything else; both give a bench whose ``axis(name)`` has
the verbs as methods. ``Lab`` has all the benches behind a door, and stops them.

May import: hil.net, hil.vocab, hil.wire, the standard library, zenoh.
"""

from hil.client.asynchronous import AsyncAxis, AsyncBench, connect
from hil.client.lab import Lab, LabAnswer
from hil.client.messages import Ack, ClientError, CommandError, State
from hil.client.synchronous import Axis, Bench, connect_sync

__all__ = [
    "Ack",
    "AsyncAxis",
    "AsyncBench",
    "Axis",
    "Bench",
    "ClientError",
    "CommandError",
    "Lab",
    "LabAnswer",
    "State",
    "connect",
    "connect_sync",
]
