"""Terminal settings of a pty, read and set through either end of it.

The structs and numbers are those of asm-generic/termbits.h and ioctls.h (x86, Arm, RISC-V); the termios
module has no custom rates.
"""

import fcntl
import struct
import termios

_TERMIOS2 = struct.Struct("4IB19s2I")  # iflag oflag cflag lflag, line, cc, ispeed ospeed
_TCGETS2 = 0x802C542A
_TCSETS2 = 0x402C542B
_TCFLSH = 0x540B
_TIOCGEXCL = 0x80045440
_TIOCGLCKTRMIOS = 0x5456
_N_TTY = 0
_CBAUD = 0o010017


def resting(fd: int) -> bytes:
    """Settings between two clients, for ``apply``: raw, at 50 baud.

    50 baud stands for "no client has chosen". It is also what makes a second open with parity work: the
    kernel drops the parity bit, and glibc reports EINVAL when a request has changed nothing.
    """
    *_, line, cc, _, _ = _TERMIOS2.unpack(fcntl.ioctl(fd, _TCGETS2, bytes(_TERMIOS2.size)))
    chars = bytearray(cc)
    chars[termios.VMIN], chars[termios.VTIME] = 1, 0
    cflag = termios.B50 | termios.CS8 | termios.CREAD | termios.CLOCAL
    return _TERMIOS2.pack(0, 0, cflag, 0, line, bytes(chars), 50, 50)


def apply(fd: int, settings: bytes) -> None:
    """Set at once; flushes nothing in either direction."""
    fcntl.ioctl(fd, _TCSETS2, settings)


def baud(fd: int) -> int | None:
    """Rate of the client, custom ones too; None for 50 (see ``resting``) and for 0 (hang up)."""
    fields = _TERMIOS2.unpack(fcntl.ioctl(fd, _TCGETS2, bytes(_TERMIOS2.size)))
    if fields[2] & _CBAUD == termios.B50:
        return None
    return int(fields[-1]) or None


def discard_unread(slave: int) -> None:
    """Drop what was written to the clients and not read. What they wrote stays."""
    # Not termios.tcflush, whose termios.error is no OSError.
    fcntl.ioctl(slave, _TCFLSH, termios.TCIFLUSH)


def let_go_on(slave: int) -> None:
    """End a stop (tcflow) and a line discipline that a client has left: both stay for the next."""
    fcntl.ioctl(slave, termios.TIOCSETD, struct.pack("i", _N_TTY))
    end_stop(slave)


def end_stop(slave: int) -> None:
    """Let clients' bytes go on that one of them has stopped (tcflow)."""
    fcntl.ioctl(slave, termios.TCXONC, termios.TCOON)


def is_locked(slave: int) -> bool:
    """True if root has locked settings (TIOCSLCKTRMIOS), which only root could undo."""
    return any(fcntl.ioctl(slave, _TIOCGLCKTRMIOS, bytes(_TERMIOS2.size)))


def is_exclusive(slave: int) -> bool:
    """True if a client has asked that nobody else may open the pts (TIOCEXCL)."""
    return fcntl.ioctl(slave, _TIOCGEXCL, bytes(4)) != bytes(4)


def end_exclusive(slave: int) -> None:
    """End TIOCEXCL: the kernel keeps it while any fd is open, and ours always is."""
    fcntl.ioctl(slave, termios.TIOCNXCL)
