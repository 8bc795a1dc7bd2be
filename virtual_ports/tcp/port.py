"""The tcp port: raw bytes, as the device sends and reads them."""

from hil.net.tcp_port import TcpOptions, TcpPort
from hil.vocab.ports import Port, PortContext


class Options(TcpOptions):
    """A TCP listener that carries raw bytes."""


def make(options: Options, context: PortContext) -> Port:
    return TcpPort(options, context)
