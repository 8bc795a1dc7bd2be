"""Model of wires and segments in a configuration, checked. The descriptions are the reference's text."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, create_model

from hil.config.explain import StrictModel
from hil.config.port_model import SERIAL, USUAL_BAUD, Name, PortConfig
from hil.vocab.address import Address, address_of, owner_of, pin_of
from hil.vocab.bus import BusKind
from hil.vocab.line_format import EVEN


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
    """An RS485 wire and what is on it. ``segment_model`` adds the keys of the kinds of nodes."""

    node_keys: ClassVar[Mapping[str, str]] = {}
    """Keys under which nodes of axes stand, each with the key below it that has the axes."""

    stations: list[str] = Field(
        default=[],
        description="Devices on this wire: `s1` is the network UART of a device, or its only one. Another"
        " UART has its name: `s1.main` is the UART of the device's port.",
    )

    taps: Mapping[Name, TapConfig] = Field(
        default={}, description="Programs on this wire, each under a name of its own: `bus0.master`."
    )
    baud: int | None = Field(
        default=None,
        ge=300,
        le=4_000_000,
        description="The speed at which taps and nodes of axes send and listen, in baud; null: that of the"
        f" first of the stations, {USUAL_BAUD} without one. A client that sets a speed at a tap has it both"
        " ways.",
    )
    format: Annotated[Literal["8N1", "8E1", "8O1", "8N2"], BeforeValidator(_format)] = Field(
        default="8N1",
        description="Data bits, parity and stop bits of a character on this wire. Boards' own UARTs have 8N1:"
        " with another format only taps, nodes of axes, and boards whose processor runs a program of yours"
        " can be on it.",
    )

    reaction_us: float | None = Field(
        default=None,
        ge=0,
        le=100_000,
        description="Spread of reaction times: each answer of a node begins up to so much later than its"
        " turnaround is over, drawn from the bench's `seed`; null: exactly then, except of nodes that share"
        " an address, which differ as two real boards do.",
    )

    def node_axes(self) -> list[str]:
        """Axes with a node on it."""
        given = ((getattr(self, key), axes_key) for key, axes_key in self.node_keys.items())
        return [axis for nodes, axes_key in given if nodes for axis in getattr(nodes, axes_key)]

    def members(self) -> tuple[str, ...]:
        """Devices on it, by a UART or a node."""
        return tuple(dict.fromkeys(owner_of(each) for each in (*self.stations, *self.node_axes())))

    def addresses(self) -> list[Address]:
        """Address of each station's UART; ``station_uart`` says which one has no name here."""
        return [address_of(station) for station in self.stations]


@lru_cache
def segment_model(buses: tuple[BusKind, ...]) -> type[SegmentConfig]:
    """Make the model with the keys of the nodes of these kinds of buses."""
    kinds = [bus.nodes for bus in buses if bus.nodes]
    keys: dict[str, Any] = {
        kind.key: (kind.model() | None, Field(default=None, description=kind.about)) for kind in kinds
    }
    made = create_model("SegmentConfig", __base__=SegmentConfig, __module__=__name__, **keys)
    made.node_keys = {kind.key: kind.axes_key for kind in kinds}
    return made
