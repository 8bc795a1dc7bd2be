"""The rfc2217 port: the tcp port with the Telnet option of RFC 2217 around each client's bytes."""

from pydantic import Field

from hil.vocab.ports import Port, PortContext
from virtual_ports.rfc2217.telnet import Telnet
from virtual_ports.tcp.port import Options as TcpOptions
from virtual_ports.tcp.port import TcpPort


class Options(TcpOptions):
    """A TCP listener that speaks RFC 2217, for pyserial's `rfc2217://` and drivers of virtual COM ports."""

    port: int = Field(
        default=0, ge=0, le=65535, description="TCP port number; 0 takes any free one, shown in the address."
    )


def make(options: Options, context: PortContext) -> Port:
    """The port, still closed."""
    return TcpPort(options, context, lambda: Telnet(f"hil {context.device}"), scheme="rfc2217")
