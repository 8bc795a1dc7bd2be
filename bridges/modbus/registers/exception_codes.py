"""Exceptions of Modbus for refusals of a bench, the same at the door and on a line."""

from bridges.modbus.protocol.pdu import Code, Refused
from hil.vocab.verbs import VerbRefused

EXCEPTIONS = {
    "no_device": Code.GATEWAY_TARGET_FAILED,
    "no_place": Code.ILLEGAL_DATA_ADDRESS,
    "no_verb": Code.ILLEGAL_DATA_ADDRESS,
    "no_parameter": Code.ILLEGAL_DATA_ADDRESS,
    "no_run": Code.ILLEGAL_DATA_ADDRESS,
    "bad_request": Code.ILLEGAL_DATA_VALUE,
    "bad_parameter": Code.ILLEGAL_DATA_VALUE,
    "bad_run": Code.ILLEGAL_DATA_VALUE,
    "bad_config": Code.ILLEGAL_DATA_VALUE,
    "not_now": Code.SERVER_DEVICE_BUSY,
    "busy": Code.SERVER_DEVICE_BUSY,
    "cannot": Code.SERVER_DEVICE_FAILURE,
    "failed": Code.SERVER_DEVICE_FAILURE,
    "forbidden": Code.ILLEGAL_FUNCTION,
}
"""Exceptions by the codes of refusals. Modbus/TCP Security refuses by role with 01 (R-29)."""


def code_and_reason(error: Refused | VerbRefused) -> tuple[Code, str]:
    """Exception of a refusal, and the reason in words."""
    if isinstance(error, Refused):
        return error.code, str(error)
    return EXCEPTIONS.get(error.code, Code.SERVER_DEVICE_FAILURE), f"{error.code}: {error}"
