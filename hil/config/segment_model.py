"""Model of wires and segments in a configuration, checked. The descriptions are the reference's text."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from hil.config.explain import StrictModel
from hil.config.modbus_model import ModbusConfig
from hil.config.port_model import SERIAL, USUAL_BAUD, Name, PortConfig
from hil.vocab.address import Address, address_of, owner_of, pin_of
from hil.vocab.line_format import EIGHT_N_1, EVEN


def _format(value: Any) -> Any:
    """Read ``8E1``, which YAML takes for a number."""
    return EVEN if isinstance(value, float) and value == float(EVEN) else value


class WireConfig(StrictModel):
    """A wire from an output to an input."""

    from_: str = Field(
        alias="from", description="A device and one of its outputs, as in `s1.clk`, or in `arm.elbow.clk`."
    )
    to: str = Field(description="A device and one of its inputs, as in `m1.step`, or in `arm.elbow.step`.")

    def ends(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Axis and pin of the output, and of the input."""
        return pin_of(self.from_), pin_of(self.to)


class TapConfig(StrictModel):
    """Tap, at which a program outside is a station of a segment."""

    port: PortConfig = Field(
        description="Where it reaches the wire, as a device's `port`; a real adapter: `serial`."
    )
    real: bool = Field(
        default=False,
        description="The tap leads to a real line with real nodes: a twin leaves the wire when a real node"
        " with its address sends. The default is true for a `serial` port.",
    )
    listen: bool = Field(default=False, description="It only listens; what it sends is dropped and counted.")
    echo: bool | None = Field(
        default=None,
        description="Its adapter echoes what it sends, because its receiver stays on. Of a `serial` port: the"
        " real adapter does, and the echo is dropped; null: recognised by itself. Of other ports: true makes"
        " it hear what it sends itself.",
    )
    framing: str | None = Field(
        default=None,
        description="Framing of the packets on this wire, for its statistics, captures and faults: `sac`,"
        " `modbus_rtu`, `bytes`; null: that of the boards and nodes on it, `bytes` if there are none: what is"
        " between two silences, whatever it means.",
    )

    @property
    def hears_itself(self) -> bool:
        """True if the wire gives it what it sends."""
        return bool(self.echo) and self.port.kind != SERIAL


class SegmentConfig(StrictModel):
    """An RS485 wire and what is on it."""

    stations: list[str] = Field(
        default=[],
        description="Devices on this wire: `s1` is the network UART of a device, or its only one. Another"
        " UART has its name: `s1.main` is the UART of the device's port.",
    )

    taps: Mapping[Name, TapConfig] = Field(
        default={}, description="Programs on this wire, each under a name of its own: `bus0.master`."
    )
    modbus: ModbusConfig | None = Field(
        default=None, description="Axes on this wire as nodes of Modbus RTU, a mapping."
    )
    baud: int | None = Field(
        default=None,
        ge=300,
        le=4_000_000,
        description="The speed at which taps and Modbus nodes send and listen, in baud; null: that of the"
        f" first of the stations, {USUAL_BAUD} without one. A client that sets a speed at a tap has it both"
        " ways.",
    )
    format: Annotated[Literal["8N1", "8E1", "8O1", "8N2"], BeforeValidator(_format)] = Field(
        default="8N1",
        description="Data bits, parity and stop bits of a character on this wire. Boards' own UARTs have 8N1:"
        " with another format only taps and Modbus nodes can be on it.",
    )

    @property
    def speaks_modbus(self) -> bool:
        """True if it has to speak Modbus RTU, by its nodes or its format."""
        return self.modbus is not None or self.format != EIGHT_N_1.name

    def members(self) -> tuple[str, ...]:
        """Devices on it, by a UART or a Modbus node."""
        nodes = self.modbus.units if self.modbus else ()
        return tuple(dict.fromkeys(owner_of(each) for each in (*self.stations, *nodes)))

    def addresses(self) -> list[Address]:
        """Address of each station's UART; ``station_uart`` says which one has no name here."""
        return [address_of(station) for station in self.stations]
