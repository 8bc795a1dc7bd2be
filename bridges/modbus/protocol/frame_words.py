"""Frames of Modbus RTU in words, questions and answers."""

from bridges.modbus.protocol.client_side import AnswerError, parse_answer
from bridges.modbus.protocol.frame import TO_ALL
from bridges.modbus.protocol.identification import IdentificationPiece
from bridges.modbus.protocol.pdu import Function, Refused, Request, Span, exception_words, parse

_EXCEPTION = 0x80


def said(raw: bytes, asked: bytes) -> str:
    """Say a frame in words, with its unit. ``asked``: the frame that it answers; empty: it is a question."""
    unit, pdu = "all" if raw[0] == TO_ALL else str(raw[0]), raw[1:-2]
    try:
        if not asked:
            return f"to {unit}: {_question(pdu)}"
        return f"from {unit}: {_answer(asked[1:-2], pdu)}"
    except (Refused, AnswerError) as error:
        digits = f": {pdu[1:].hex(' ')}" if len(pdu) > 1 else ""
        return f"{unit}, function {raw[1]}{digits} ({error})"


def _question(pdu: bytes) -> str:
    if pdu[0] & _EXCEPTION:
        return f"{_exception(pdu)}, which nobody has asked for"
    request = parse(pdu, is_serial_line=True)
    parts = []
    if request.write:
        parts.append(f"write {_values(Span(*request.write[:2], len(request.write.values)), request)}")
    if request.read:
        parts.append(f"read {_span(request.read)}")
    if request.mask:
        address, and_mask, or_mask = request.mask
        parts.append(f"mask holding register {address}: and {and_mask:04x}h or {or_mask:04x}h")
    return ", ".join(parts) or _other(request)


def _other(request: Request) -> str:
    if request.function == Function.DIAGNOSTICS:
        return f"diagnosis {request.sub_function}: {request.data.hex(' ')}"
    if request.function == Function.REPORT_SERVER_ID:
        return "report server ID"
    return f"identification, category {request.read_device_id_code} from object {request.object_id}"


def _answer(question: bytes, pdu: bytes) -> str:
    if pdu[0] & _EXCEPTION:
        return f"function {pdu[0] & ~_EXCEPTION}: {_exception(pdu)}"
    request = parse(question, is_serial_line=True)
    answer = parse_answer(request, pdu)
    if request.read:
        return f"{_span(request.read)}: {_listed(answer.values)}"
    if request.write:
        return f"{_span(Span(*request.write[:2], len(request.write.values)))} written"
    if request.mask:
        return f"holding register {request.mask.address} masked"
    if request.sub_function is not None:
        return f"diagnosis {request.sub_function}: {answer.data.hex(' ')}"
    if answer.identification:
        return f"identification: {_objects(answer.identification)}"
    return f"server ID: {_text(answer.data)}"


def _span(span: Span) -> str:
    what = span.table.value
    if span.count == 1:
        return f"{what.removesuffix('s')} {span.address}"
    return f"{what} {span.address} to {span.address + span.count - 1}"


def _values(span: Span, request: Request) -> str:
    assert request.write
    return f"{_span(span)}: {_listed(request.write.values)}"


def _listed(values: tuple[int, ...]) -> str:
    return " ".join(map(str, values))


def _objects(piece: IdentificationPiece) -> str:
    more = "" if piece.next_object_id is None else f", more from object {piece.next_object_id}"
    return ", ".join(f"{number} {_text(value)}" for number, value in piece.objects.items()) + more


def _text(data: bytes) -> str:
    return repr(data)[1:]


def _exception(pdu: bytes) -> str:
    if len(pdu) < 2:
        raise AnswerError("an exception without its code")
    code = pdu[1]
    return f"exception {code:02} ({exception_words(code)})"
