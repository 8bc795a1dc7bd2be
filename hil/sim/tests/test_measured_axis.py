"""A voltage that follows a field of a servo without wires: the field is that of the sample's time."""

from avr_words import CONVERT, RESULT
from test_processor import started

from hil.testing import Bench

CONFIG = {
    "bench": "b",
    "devices": {
        "u1": {"profile": "uno", "voltages": {"A0": {"of": "m1.position_deg", "gain": 0.05}}},
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
    },
}


def measured(cuts_ms: list[float]) -> bytes:
    with Bench(CONFIG) as bench:
        bench.run(4100)
        processor = started(bench, CONVERT)
        bench.axis("m1").do("enable")
        bench.axis("m1").do("position", position_deg=60.0)
        for ms in cuts_ms:
            bench.run(ms)
        return processor.data(RESULT, 2)


def test_it_does_not_matter_how_time_is_cut() -> None:
    for ms in (9.5, 17.5, 23.5):
        assert measured([ms]) == measured([0.05] * round(ms / 0.05))
