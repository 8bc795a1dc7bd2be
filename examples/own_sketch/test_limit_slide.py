"""``limit_slide.ino``: it searches its limit switch, and goes nowhere behind it."""

import pytest

DEG_PER_STEP = 360 / 1600


def started(bench, folder, *faults):
    """Bench on which the sketch has said how its search was, and what it said."""
    b = bench(folder / "bench.yaml")
    for kind, given in faults:
        b.fault(kind, "d1.limit", **given)
    return b, said(b, within_ms=10000)


def said(b, line="", within_ms=20000):
    """Answer to a line, or what comes by itself."""
    port, heard = b.port("u1"), bytearray()
    if line:
        port.write(f"{line}\n".encode())
    b.wait_until(lambda: heard.extend(port.read()) or heard.endswith(b"\r\n"), within_ms=within_ms)
    return heard.decode().strip()


def test_its_zero_is_where_the_contact_opens_for_good(bench, built):
    b, text = started(bench, built("limit_slide"))
    assert text == "homed"
    # It begins at 0, goes to -90 and on while the contact bounces, and stands 20 steps behind its opening.
    assert b.axis("d1").snapshot().position_deg == pytest.approx(-88 + 20 * DEG_PER_STEP, abs=0.5)
    assert said(b, "1600") == "at 1600"
    b.run(ms=200)
    assert b.axis("d1").snapshot().position_deg == pytest.approx(-88 + 360, abs=0.5)


def test_it_does_not_go_on_at_its_switch(bench, built):
    b, _ = started(bench, built("limit_slide"))
    answer = said(b, "-1600")
    assert answer.startswith("switch at -")
    b.run(ms=200)
    assert b.axis("d1").snapshot().position_deg == pytest.approx(-90, abs=0.5)
    assert said(b, "0") == "at 0"


def test_other_bounces_give_the_same_zero(bench, built):
    """Each seed has its own; the places differ by steps of the motor's swing."""
    folder, stands_deg = built("limit_slide"), []
    for seed in range(4):
        path = folder / f"seed{seed}.yaml"
        path.write_text(f"{(folder / 'bench.yaml').read_text()}seed: {seed}\n")
        b = bench(path)
        assert said(b) == "homed"
        stands_deg.append(b.axis("d1").snapshot().position_deg)
    assert max(stands_deg) - min(stands_deg) <= 2 * DEG_PER_STEP


def test_a_broken_wire_is_noticed_behind_the_longest_way(bench, built):
    _, text = started(bench, built("limit_slide"), ("switch_wire_broken", {}))
    assert text == "no switch"


def test_a_switch_that_a_crash_has_moved_moves_the_zero(bench, built):
    b, text = started(bench, built("limit_slide"), ("switch_moved", {"by_deg": 45}))
    assert text == "homed"
    assert b.axis("d1").snapshot().position_deg == pytest.approx(-43 + 20 * DEG_PER_STEP, abs=0.5)
