"""A SAC as a node of its network: packets that it sends, and the effect of those that come.

Source: SAC user manual, communications, network, device ID, ACK, CRC, soft_ops. Decisions: README.md.
"""

from collections.abc import Iterator

from device_profiles.sac.framing import FRAMING, TURNAROUND_CHARACTERS
from device_profiles.sac.packet import DATA_MAX, UNUSABLE_ADDRESSES, Malformed, Packet, PacketDecoder, frame
from device_profiles.sac.session import Session
from device_profiles.sac.terminal import Steps
from device_profiles.sac.typed_text import Text
from hil.vocab.firmware import Delay, Uart
from hil.wire.serial_line import character_ns

BROADCAST = 0
ACK, NAK, DC1, DC2 = b"\x06", b"\x15", b"\x11", b"\x12"
_SIGNALS = (ACK, NAK, DC1, DC2)
SEPARATORS = " ."
"""Characters with which a message's data begins if it is text."""
REPLY = "\\/"
_FRAME_ONLY = b"\0\2\3"


class Network:
    def __init__(self, session: Session) -> None:
        self._session = session
        self.decoder = PacketDecoder()
        self._uart: Uart | None = None
        self.last_sender: int | None = None
        """Node that a reply goes to; None: nobody, as after a packet to everybody."""

    def use(self, uart: Uart, address: int | None) -> None:
        """Use this port for packets from now on. ``address``: of this unit; None before it is known."""
        if uart is not self._uart:
            self.decoder = PacketDecoder()
        self._uart = uart
        uart.wake_on(FRAMING)
        uart.listen_for(address)

    # ---- out ----

    def typed(self, text: str) -> bool:
        """Handle a terminal's line. True if it was the network's: it begins with an address, or replies."""
        line = Text(text)
        if line.peek() and line.peek() in REPLY:
            line.take()
            if self.last_sender is not None:
                self.send(self.last_sender, line.rest().encode("latin-1"))
            return True
        if not line.is_digit():
            return False
        self.send((line.number() or 0) % 256, line.rest().encode("latin-1"))
        return True

    def send(self, destination: int, data: bytes) -> None:
        """Send a packet. Nothing goes to an unusable address; characters of a packet's frame are left out."""
        if self._uart is None or destination in UNUSABLE_ADDRESSES:
            return
        data = data.translate(None, _FRAME_ONLY)[:DATA_MAX]
        own_id = self._session.parameters.device_id
        self._uart.write(frame(destination, own_id, data, self._session.is_crc_on))

    def operation(self, begins: bool) -> None:
        """Tell everybody, as soft_ops does, that a command begins or ends."""
        self.send(BROADCAST, DC1 if begins else DC2)

    # ---- in ----

    def received(self) -> Iterator[Packet]:
        """Take the packets for this unit since the last call; malformed ones are passed over."""
        if self._uart is None:
            return
        for item in self.decoder.feed(self._uart.read_all()):
            if isinstance(item, Malformed):
                continue
            if item.destination in (BROADCAST, self._session.parameters.device_id):
                yield item

    def acknowledge(self, packet: Packet) -> Steps:
        """Send ACK, or NAK for a wrong CRC; nothing to a broadcast, or to what is an answer itself."""
        if packet.destination == BROADCAST or is_signal(packet) or not self._session.is_ack_on:
            return
        if self._uart and self._uart.baud:
            turnaround_ns = character_ns(TURNAROUND_CHARACTERS, self._uart.baud)
            yield Delay(turnaround_ns + self._uart.reaction_ns())
        self.send(packet.origin, ACK if packet.is_good else NAK)
        yield Delay(0)  # the main loop waits until it is out

    def remember(self, packet: Packet) -> None:
        """Note whom a reply goes to: nobody after a broadcast."""
        self.last_sender = None if packet.destination == BROADCAST else packet.origin


def is_signal(packet: Packet) -> bool:
    """True if a packet is a signal: a byte that is never answered and never executed."""
    return packet.data in _SIGNALS
