"""The rfc2217 port: a TCP listener with the Telnet option of RFC 2217 around each client's bytes."""

from hil.net.tcp_port import TcpOptions, TcpPort
from hil.vocab.ports import Port, PortContext
from virtual_ports.rfc2217.telnet import Telnet


class Options(TcpOptions):
    """A TCP listener that speaks RFC 2217, for pyserial's `rfc2217://` and drivers of virtual COM ports."""


def make(options: Options, context: PortContext) -> Port:
    return TcpPort(options, context, lambda: Telnet(f"hil {context.device}"), scheme="rfc2217")
