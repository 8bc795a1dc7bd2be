"""Frames in words, for people: ``to 1: MVP ABS 0 51200``, ``from 1: ok MVP 51200``."""

from tmcl_bus.frames import Command, Move, Reply, Request, Status

PARAMETERS = {
    0: "target position",
    1: "actual position",
    2: "target speed",
    3: "actual speed",
    4: "maximum speed",
    5: "maximum acceleration",
    6: "maximum current",
    7: "standby current",
    8: "position reached",
    127: "relative to",
    140: "microstep resolution",
}
"""Names of the axis parameters that these modules have, by number."""
_WITHOUT_MOTOR = (Command.GFV,)
_WITH_VALUE = (Command.ROR, Command.ROL, Command.MVP, Command.SAP, Command.SGP, Command.SIO)
_OF_PARAMETERS = (Command.SAP, Command.GAP)
_OF_NUMBERS = (Command.SGP, Command.GGP, Command.SIO, Command.GIO)


def request_words(request: Request) -> str:
    """Say a request: command, type, motor or bank, value, as far as the command has them."""
    known = _command(request.command)
    if known is None:
        numbers = f"type {request.type} motor {request.motor} value {request.value}"
        return f"to {request.module}: command {request.command} {numbers}"
    said = [f"to {request.module}:", known.name]
    if known is Command.MVP:
        names = {move.value: move.name for move in Move}
        said.append(names.get(request.type, str(request.type)))
    elif known in (*_OF_PARAMETERS, *_OF_NUMBERS, Command.GFV):
        said.append(str(request.type))
    if known not in _WITHOUT_MOTOR:
        said.append(str(request.motor))
    if known in _WITH_VALUE:
        said.append(str(request.value))
    if known in _OF_PARAMETERS and request.type in PARAMETERS:
        said.append(f"({PARAMETERS[request.type]})")
    return " ".join(said)


def reply_words(reply: Reply) -> str:
    """Say a reply: its status, the command that it is for, the value of one that is good."""
    status = next((each for each in Status if each == reply.status), None)
    name = _name(reply.command)
    if status is Status.OK:
        return f"from {reply.module}: ok {name} {reply.value}"
    said = status.name.lower().replace("_", " ") if status else f"status {reply.status}"
    return f"from {reply.module}: {said} {name}"


def _name(number: int) -> str:
    known = _command(number)
    return known.name if known else str(number)


def _command(number: int) -> Command | None:
    return next((each for each in Command if each == number), None)
