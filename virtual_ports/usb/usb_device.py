"""Device behind its host controller: requests of USB 2.0, chapter 9, and the ways to its endpoints. Pure."""

import struct
from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple, Protocol

from virtual_ports.usb.descriptors import COMMUNICATION, CONFIGURATION_VALUE, DATA, Descriptors
from virtual_ports.usb.endpoints import Answer, Endpoint
from virtual_ports.usb.urb import (
    OK,
    SHUT_DOWN,
    STALL,
    UNLINKED,
    Command,
    Submit,
    Unlink,
    ret_submit,
    ret_unlink,
)

_SETUP = struct.Struct("<BBHHH")
TO_HOST = 0x80
_KIND, _STANDARD, _CLASS = 0x60, 0x00, 0x20
_RECIPIENT = 0x1F
_ENDPOINT_HALT = 0
_INTERFACES = (COMMUNICATION, DATA)
_NOTHING = b"\x00\x00"
_HALTED = b"\x01\x00"


class _To(IntEnum):
    DEVICE = 0
    INTERFACE = 1
    ENDPOINT = 2


class _Request(IntEnum):
    GET_STATUS = 0
    CLEAR_FEATURE = 1
    SET_FEATURE = 3
    SET_ADDRESS = 5
    GET_DESCRIPTOR = 6
    GET_CONFIGURATION = 8
    SET_CONFIGURATION = 9
    GET_INTERFACE = 10
    SET_INTERFACE = 11


class Setup(NamedTuple):
    """Request of a control transfer."""

    request_type: int
    request: int
    value: int
    where: int
    length: int

    @property
    def recipient(self) -> int:
        return self.request_type & _RECIPIENT

    @property
    def is_to_host(self) -> bool:
        return bool(self.request_type & TO_HOST)


class UsbFunction(Protocol):
    """Function of the device, beside what all devices do."""

    def request(self, setup: Setup, data: bytes) -> bytes | None:
        """Carry out a request of its class to its interface; answers what the host gets. None: it does not
        know the request."""

    def configured(self, *, is_configured: bool) -> None:
        """Begin again, or rest until the host configures the device."""


class UsbDevice:
    """Device with its endpoints, by their addresses. ``answer`` takes what goes to the host."""

    def __init__(
        self,
        descriptors: Descriptors,
        function: UsbFunction,
        endpoints: Mapping[int, Endpoint],
        answer: Answer,
    ) -> None:
        self._descriptors = descriptors
        self._function = function
        self._endpoints = endpoints
        self._answer = answer
        self.configuration = 0
        """Value of the configuration that the host has chosen; 0: none."""

    def handle(self, command: Command) -> None:
        """Take a command of the host."""
        if isinstance(command, Unlink):
            # A list: an unlink of a transfer that was answered asks each.
            is_found = any([each.unlink(command.victim) for each in self._endpoints.values()])
            self._answer(ret_unlink(command.seqnum, UNLINKED if is_found else OK))
        elif command.endpoint == 0:
            self._control(command)
        else:
            address = command.endpoint | (TO_HOST if command.is_in else 0)
            endpoint = self._endpoints.get(address)
            if endpoint is None or not self.configuration:
                self._answer(ret_submit(command.seqnum, STALL, 0))
            else:
                endpoint.submit(command)

    def _control(self, submit: Submit) -> None:
        setup = Setup(*_SETUP.unpack(submit.setup))
        data = None
        if setup.is_to_host or not (submit.is_in or len(submit.data) != setup.length):
            data = self._request(setup, submit.data)
        if data is None:
            self._answer(ret_submit(submit.seqnum, STALL, 0))
        elif setup.is_to_host and submit.is_in:
            data = data[: min(setup.length, submit.length)]
            self._answer(ret_submit(submit.seqnum, OK, len(data), data))
        else:
            self._answer(ret_submit(submit.seqnum, OK, submit.length))

    def _request(self, setup: Setup, data: bytes) -> bytes | None:
        kind = setup.request_type & _KIND
        if kind == _STANDARD:
            return self._of_host(setup) if setup.is_to_host else self._to_device(setup)
        if kind == _CLASS and setup.recipient == _To.INTERFACE and self.configuration:
            return self._function.request(setup, data)
        return None

    def _of_host(self, setup: Setup) -> bytes | None:
        """Answer a standard request that asks for something."""
        match setup.request, setup.recipient:
            case (_Request.GET_DESCRIPTOR, _To.DEVICE):
                return self._descriptors.find(setup.value >> 8, setup.value & 0xFF, setup.where)
            case (_Request.GET_CONFIGURATION, _To.DEVICE):
                return bytes((self.configuration,))
            case (_Request.GET_INTERFACE, _To.INTERFACE) if self._has_interface(setup.where):
                return b"\x00"
            case (_Request.GET_STATUS, _To.DEVICE):
                return _NOTHING  # powered by the bus, and no remote wake-up
            case (_Request.GET_STATUS, _To.INTERFACE) if self._has_interface(setup.where):
                return _NOTHING
            case (_Request.GET_STATUS, _To.ENDPOINT):
                return self._endpoint_status(setup.where)
        return None

    def _to_device(self, setup: Setup) -> bytes | None:
        """Carry out a standard request that sets something."""
        match setup.request, setup.recipient:
            case (_Request.SET_ADDRESS, _To.DEVICE):
                return b""  # the host controller knows it
            case (_Request.SET_CONFIGURATION, _To.DEVICE):
                return self._configure(setup.value)
            case (_Request.SET_INTERFACE, _To.INTERFACE) if (
                self._has_interface(setup.where) and setup.value == 0
            ):
                return b""
            case ((_Request.CLEAR_FEATURE | _Request.SET_FEATURE), _To.ENDPOINT) if (
                setup.value == _ENDPOINT_HALT
            ):
                return self._set_halt(setup.where, is_halted=setup.request == _Request.SET_FEATURE)
        return None

    def _has_interface(self, number: int) -> bool:
        return bool(self.configuration) and number in _INTERFACES

    def _endpoint_status(self, address: int) -> bytes | None:
        if address & ~TO_HOST == 0:
            return _NOTHING
        endpoint = self._endpoints.get(address) if self.configuration else None
        if endpoint is None:
            return None
        return _HALTED if endpoint.is_halted else _NOTHING

    def _set_halt(self, address: int, *, is_halted: bool) -> bytes | None:
        if address & ~TO_HOST == 0:
            return b""
        endpoint = self._endpoints.get(address) if self.configuration else None
        if endpoint is None:
            return None
        if is_halted:
            endpoint.halt()
        else:
            endpoint.clear()
        return b""

    def _configure(self, value: int) -> bytes | None:
        if value not in (0, CONFIGURATION_VALUE):
            return None
        self.configuration = value
        for endpoint in self._endpoints.values():
            endpoint.fail(SHUT_DOWN)
            endpoint.clear()
        self._function.configured(is_configured=value != 0)
        return b""
