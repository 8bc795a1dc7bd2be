"""Model of a bench's configuration, checked. The field descriptions are the reference's text."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, BeforeValidator, Field, PrivateAttr, SerializeAsAny

from hil.config.axis_keys import AxisKeys, axis_parameters, usual_axis_parameters
from hil.config.board_parameters import BuildValues
from hil.config.catalogue import ONLY_AXIS, ProfileInfo
from hil.config.commands_model import KEPT_COMMANDS, CommandsConfig
from hil.config.device_parts_model import AxisConfig, FieldStarts, FlashConfig, Register, SetpointsConfig
from hil.config.device_program import ProgramKey
from hil.config.device_sketch import SketchKey
from hil.config.explain import OR_NULL, DefaultsModel, LazyModel, StrictModel
from hil.config.fault_model import FaultConfig
from hil.config.labels_model import Labels
from hil.config.magnet_model import MagnetKey
from hil.config.port_model import Name, PortConfig, usable_path
from hil.config.processor_model import DriverPins, Voltages, measured
from hil.config.recordings_model import KEPT_RECORDINGS, RecordingsConfig
from hil.config.shaft_load import LoadConfig
from hil.config.written import Written
from hil.vocab.address import Address, owner_of
from hil.vocab.axis_plan import AxisPlan, Load
from hil.vocab.firmware import NETWORK
from hil.vocab.ports import ADAPTER, UsbIdentity

if TYPE_CHECKING:
    from hil.config.segment_model import SegmentConfig, WireConfig
    from hil.config.switch_model import AxisSwitchConfig
else:

    def _segment() -> type[BaseModel]:
        from hil.config.segment_model import SegmentConfig

        return SegmentConfig

    def _wire() -> type[BaseModel]:
        from hil.config.segment_model import WireConfig

        return WireConfig

    def _switch() -> type[BaseModel]:
        from hil.config.switch_model import AxisSwitchConfig

        return AxisSwitchConfig

    SegmentConfig, WireConfig, AxisSwitchConfig = (
        Annotated[Any, LazyModel(load)] for load in (_segment, _wire, _switch)
    )

_Path = Annotated[Path, Field(strict=False), BeforeValidator(usable_path)]
_Baud = Annotated[int, Field(ge=50, le=4_000_000)]


class DeviceConfig(DefaultsModel):
    """A board, emulated or real. ``device_model`` adds the keys of the kinds of buses.

    Long because it is the table of a board's keys, each with its bounds and its description.
    """

    profile: str = Field(description="The kind of board, by the name of its profile.")
    at: str | None = Field(
        default=None,
        description="A real board instead of an emulated one: the path or URL of its serial port"
        " (`/dev/ttyUSB0`, `socket://host:port`, `rfc2217://host:port`). Programs reach it through `port`;"
        " `baud` is the adapter's speed; keys of emulated boards are not allowed with it.",
    )
    port: PortConfig | None = Field(
        default=None,
        description="Where clients reach the board: the name of a kind of port, or a mapping of `kind` and"
        " that kind's own options. A board without a serial interface has none.",
    )
    network: PortConfig | None = Field(
        default=None,
        description="Where clients reach the board's second serial interface (a SAC's network posts), as"
        " `port`; null: no port there. Its name is the device's with `.network`.",
    )
    ports: Mapping[Name, PortConfig] = Field(
        default={},
        description="Where clients reach the board's other serial interfaces, by their names in the profile,"
        " each as `port`. The name of such a port is `device.interface`, as in `arm.logger`.",
    )
    baud: _Baud | None = Field(
        default=None,
        description="Character timing of the serial line, in baud (10 bit times a character), as of a UART;"
        " null: bytes take no time, as over USB CDC. On a board with several serial interfaces it is for the"
        " first.",
    )
    bauds: Mapping[Name, _Baud | None] = Field(
        default={},
        description="The same for the board's other serial interfaces, by their names in the profile, at a"
        " port or on a segment, as in `{logger: 9600}`.",
    )
    echo: bool | None = Field(
        default=None,
        description="Whether the adapter to a real board (`at`) echoes what it sends: true drops the echo;"
        " null: it is believed to have none, because a board's terminal may echo what is typed. On Modbus"
        " it is a part of the address, `&echo=true`; null: recognised by itself.",
    )
    flash: FlashConfig = Field(
        default=FlashConfig.model_construct(),
        description="Contents of the board's non-volatile memory at its start.",
    )
    firmware: ProgramKey = Field(
        default=None,
        description="Compiled program of the board's processor, a `.hex` or an `.elf` file; a relative path"
        " is looked up from this file. It is in the board's flash at each start, instead of what was"
        " uploaded; null: what was uploaded last. Only of boards with a `processor`.",
    )
    sketch: SketchKey = Field(
        default=None,
        description="Sketch of your own in Python, beside the stock firmware: a file with `setup(board)` and"
        " `loop(board)`; null: the stock one alone. Only of a Mechaduino.",
    )
    bootloader: ProgramKey = Field(
        default=None,
        description="Bootloader of your own in the processor's boot section, a file as `firmware`; null: hil"
        " answers a tool that uploads as optiboot does.",
    )
    auto_reset: bool = Field(
        default=True,
        description="Whether opening the first serial port resets the processor, as DTR does; false: as with"
        " the trace RESET EN cut, so that nothing can be uploaded.",
    )
    voltages: Voltages = Field(
        default={},
        description="Voltages at the processor's analogue pins, in V, or fields that they follow, as in"
        " `{A0: 2.5, A1: {of: m1.current_a_A, gain: 0.5}}`.",
    )
    fields: FieldStarts = Field(default={})
    parameters: BuildValues = Field(default={})
    rs485: DriverPins | None = Field(
        default=None, description="Driver of the line that the processor's serial interface is on."
    )
    magnet: MagnetKey | None = Field(
        default=None,
        description="The magnet that an encoder reads: its shaft, as in `m1`, or a mapping as in"
        " `{of: m1, zero_deg: 90}`; null: there is none.",
    )
    hardware: str = Field(
        description="The board's version, one of its profile's; left out: the profile's default."
    )
    plant: Literal["simple", "full"] = Field(
        default="simple",
        description="The model of motor and load. `simple`: inertia, viscous friction and a torque constant;"
        " coil currents follow their command at once. `full`: also coils with inductance and"
        " back-EMF behind a supply, detent torque, dry friction, a load, and the encoder's errors.",
    )
    motor: str | None = Field(
        default=None,
        description="Another motor than the profile's, one of the catalogue, as in `nema23-2.8A`; its"
        " driver is then set to the motor's rated current. What `axis` has goes first.",
    )
    load: LoadConfig | None = Field(
        default=None,
        description="What the shaft turns, a mapping of `kind` and that kind's numbers; needs `plant: full`.",
    )
    axis: Mapping[str, float] = Field(
        default={},
        description="Axis parameters that differ from the profile's; each name ends in its unit. On a board"
        " with several axes these are for the first, as are `load` and `registers`.",
    )
    registers: Mapping[str, Register] = Field(
        default={},
        description="Contents of the encoder's registers at power-up that differ from the profile's.",
    )
    axes: Mapping[Name, AxisConfig] = Field(
        default={},
        description="Axes of a board with several axes, by their names in the profile, as in `elbow`: what"
        " differs from the profile.",
    )
    setpoints: SetpointsConfig | None = Field(
        default=None,
        description="Set-point time-out: what the axis does when no further `position`, `velocity` or"
        " `torque` comes; null: it follows the last one.",
    )
    setpoint_rate_Hz: Annotated[float, OR_NULL] = Field(
        default=50.0,
        ge=1,
        le=200,
        description="Set-points a second that a run types at a real servo (`at`), or writes to a real drive"
        " that follows set-points; for a CANopen drive the rate of SYNC, one for all drives on a"
        " bus.",
    )
    line_delay_ms: Annotated[float, OR_NULL] = Field(
        default=0.0,
        ge=0,
        le=60_000,
        description="Maximum delay of the line to a real board (`at`) beside that of a cable, there and"
        " back, as over a network or on a busy computer: a run tells the board its motions so much earlier,"
        " and waits so much longer for its answers.",
    )
    poll_interval_ms: Annotated[float, OR_NULL] = Field(
        default=20.0,
        ge=1,
        le=10_000,
        description="Interval of readings of a real drive's state (`at: modbus+...`, `at: can+...`); a slow"
        " line makes it longer; for a CANopen drive whole periods of SYNC.",
    )
    spi_previous_command: int = Field(
        default=0xFFFF,
        ge=0,
        le=0xFFFF,
        description="The SPI frame sent before the first one. The encoder answers one frame late, so the"
        " first answer belongs to this; 0xFFFF reads the angle.",
    )

    def port_of(self, uart: str) -> PortConfig | None:
        """Port of a UART by its name; empty: of the first."""
        return self.ports_by_uart().get(uart)

    def ports_by_uart(self) -> dict[str, PortConfig]:
        """Ports by the names of UARTs; the first one's is empty."""
        named = {"": self.port, NETWORK: self.network}
        return {name: port for name, port in named.items() if port} | dict(self.ports)

    def uart_bauds(self, profile: ProfileInfo) -> dict[str, int | None]:
        """Speeds of the UARTs by their names."""
        own = {profile.first_uart: self.baud} | dict(self.bauds)
        return {name: own.get(name, numbers.baud) for name, numbers in profile.uarts.items()}

    def usb_identity(self, profile: ProfileInfo, uart: str) -> UsbIdentity:
        """Identity on a USB of what is behind a UART; empty: behind the first. A UART with a baud has an
        adapter in front of it."""
        has_baud = self.uart_bauds(profile).get(uart or profile.first_uart) is not None
        if has_baud or (device := profile.usb_device) is None:
            return ADAPTER
        return UsbIdentity(**device.model_dump(), is_native=profile.usb == "native")

    def axis_config(self, profile: ProfileInfo, name: str) -> AxisKeys:
        """Keys of an axis: those under its name, over the device's own if it is the first axis."""
        is_first = name == next(iter(profile.axes))
        motor, load, axis, registers = (
            (self.motor, self.load, self.axis, self.registers) if is_first else (None, None, {}, {})
        )
        if given := self.axes.get(name):
            motor, load = given.motor or motor, given.load or load
            axis, registers = dict(axis) | dict(given.axis), dict(registers) | dict(given.registers)
        return AxisKeys((given and given.plant) or self.plant, motor, load, axis, registers)

    def axis_parameters(self, profile: ProfileInfo, name: str = ONLY_AXIS) -> dict[str, float]:
        """Parameters of an axis: the profile's for its plant, with its motor's and its own in their place,
        and with the friction of its load."""
        return axis_parameters(self.axis_config(profile, name), profile.axes[name])

    def usual_parameters(self, profile: ProfileInfo, name: str = ONLY_AXIS) -> dict[str, float]:
        """Parameters of an axis without its own: the profile's for its plant, with those of its motor."""
        return usual_axis_parameters(self.axis_config(profile, name), profile.axes[name])

    def axis_plans(self, profile: ProfileInfo, seed: int) -> dict[str, AxisPlan]:
        """Plans that the core opens this device's axes with, by name. ``seed``: the first axis's."""
        plans = {}
        for index, (name, info) in enumerate(profile.axes.items()):
            own = self.axis_config(profile, name)
            load = own.load.parts() if own.load else Load()
            plans[name] = AxisPlan(
                axis_parameters(own, info),
                own.plant or self.plant,
                load,
                seed + (index << 28),
                law=info.law,
                processor=profile.plan_of(info),
                fields=profile.fields_of(name, self.fields),
            )
        return plans

    def register_values(self, profile: ProfileInfo, name: str = ONLY_AXIS) -> dict[str, int]:
        """Registers of an axis at power-up: the profile's, with its own in their place."""
        return dict(profile.axes[name].registers) | dict(self.axis_config(profile, name).registers)

    def power_up(self, profile: ProfileInfo) -> dict[str, dict[str, int]]:
        """Fields of the axes that the power sets, by the axis's name."""
        spi = {"spi_previous_command": self.spi_previous_command}
        return {name: self.register_values(profile, name) | spi for name in profile.axes}


class BenchConfig(StrictModel):
    """A daemon's whole set-up. ``bench_model`` adds the keys of the kinds of buses."""

    bus_keys: ClassVar[tuple[str, ...]] = ("segments",)
    """Keys under which wires with stations stand."""

    bench: Name = Field(description="The bench's name: a letter a-z and up to 31 more of a-z, 0-9, _ and -.")
    labels: Labels = Field(default={})
    devices: Mapping[Name, DeviceConfig] = Field(
        min_length=1, description="The boards, each under a name of its own (same form as the bench's)."
    )
    wires: list[WireConfig] = Field(
        default=[],
        description="Wires between pins, each a mapping of `from` and `to`, as in `{from: s1.clk, to:"
        " m1.step}`; an edge reaches the other board at the same nanosecond. Devices joined by wires share"
        " one simulated time.",
    )
    switches: Mapping[Name, AxisSwitchConfig] = Field(
        default={},
        description="Switches along axes, each under a name of its own, as in `home: {axis: s1, to_deg: -180,"
        " to: s1.Estop}`. An axis and the board of the pin share one simulated time.",
    )
    segments: Mapping[Name, SegmentConfig] = Field(
        default={},
        description="RS485 wires, each under a name of its own: what one station sends, the others hear."
        " Devices on one segment share one simulated time.",
    )
    faults: list[FaultConfig] = Field(
        default=[],
        description="Faults that are there from the start, as `hil fault inject` makes them later.",
    )
    bridges: Mapping[str, SerializeAsAny[BaseModel]] = Field(
        default={},
        description="Doors for other protocols, each under the name of its kind, with that kind's options.",
    )
    profile_path: list[_Path] = Field(
        default=[],
        description="Folders with boards of your own, each a folder with `board.py` and `profile.yaml`."
        " A relative one is looked up from the configuration's folder.",
    )
    rate_hz: int = Field(
        default=1000,
        ge=100,
        le=6500,
        description="How often the real-time core wakes, in Hz. Not the control rate: each wake runs every"
        " control step that is due, at its exact simulated time.",
    )
    speed: float = Field(
        default=1.0, gt=0, le=1000, description="Simulated seconds that pass in one second of wall time."
    )
    seed: int = Field(default=0, description="Where all randomness starts: same seed and inputs, same bytes.")
    cpu: int | None = Field(
        default=None,
        ge=0,
        le=1023,
        description="The CPU that the real-time core is pinned to; null: the one that fewest benches have.",
    )
    recordings: RecordingsConfig = KEPT_RECORDINGS
    commands: CommandsConfig = KEPT_COMMANDS
    runtime_dir: _Path | None = Field(
        default=None,
        description="Where ports, sockets and their stable names are put; null: the daemon's choice.",
    )
    state_dir: _Path | None = Field(
        default=None, description="Where the boards' non-volatile memory is kept; null: the daemon's choice."
    )

    _written: Written = PrivateAttr(default=Written())

    @property
    def written(self) -> Written:
        """Places of its doors and ports in the file, and old keys."""
        return self._written

    def with_written(self, written: Written) -> "BenchConfig":
        """Note how it was written; answers the same bench."""
        self._written = written
        return self

    def wires_of(self, key: str) -> Mapping[str, Any]:
        """Wires of a kind of bus by name, each of the model of its kind."""
        of_kind: Mapping[str, Any] = getattr(self, key)
        return of_kind

    def bus_wires(self) -> dict[str, Any]:
        """Segments, and the wires of all kinds of buses, by name."""
        return {name: wire for key in self.bus_keys for name, wire in self.wires_of(key).items()}

    def joints(self) -> list[tuple[str, ...]]:
        """Devices that share their time, by wire between pins, by segment and by bus."""
        wired = [tuple(owner_of(axis) for axis, _ in wire.ends()) for wire in self.wires]
        devices = self.devices.items()
        read = [(name, owner_of(v.source[0])) for name, d in devices for v in measured(d.voltages).values()]
        read += [(name, owner_of(device.magnet.of)) for name, device in devices if device.magnet]
        switched = [switch.members() for switch in self.switches.values()]
        return [*wired, *read, *switched, *(each.members() for each in self.bus_wires().values())]

    def tap_ports(self) -> dict[str, PortConfig]:
        """Ports of the taps of segments and buses, by their addresses."""
        return {
            str(Address(name, tap)): each.port
            for name, wire in self.bus_wires().items()
            for tap, each in wire.taps.items()
        }

    @property
    def twins(self) -> dict[str, DeviceConfig]:
        """The emulated boards."""
        return {name: device for name, device in self.devices.items() if device.at is None}

    @property
    def real(self) -> dict[str, DeviceConfig]:
        """The real boards, drives among them."""
        return {name: device for name, device in self.devices.items() if device.at is not None}
