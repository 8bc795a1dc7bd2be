"""Sessions by steps at twins: times, ends of motions, boards that fall silent or are none."""

from typing import Any

import pytest

from hil.testing import Bench
from hil.testing.parity.parity_scores import STOOD, SessionScore, scored
from hil.testing.parity.step_player import LATE_MS, NotThisBoard, StepPlayer
from hil.testing.parity.twin_player import SETTLE_MS, twin_answers
from hil.testing.parity.typed_session import StepAnswer, TypedSession, typed_session
from hil.vocab.dialogue import DialogueError

VD = {"types": "vd\r", "shows": "\r\n0\t0\r\n", "within_ms": 10_000}


def session_of(*steps: dict[str, Any], profile: str = "sac", **keys: Any) -> TypedSession:
    return typed_session({"profile": profile, "moves": False, "steps": list(steps), **keys})


def typed(text: str, **keys: Any) -> dict[str, Any]:
    return {"types": text, "for_ms": 200, **keys}


def at_board(session: TypedSession, board: Bench, expected: list[StepAnswer]) -> list[StepAnswer]:
    """Answers of another twin that is taken as the board, with what came before an error."""
    player = StepPlayer(session, expected)
    board.start()
    board.talk("b", player.settle(SETTLE_MS))
    board.talk("b", player.play())
    return player.answers


def board_bench(profile: str = "sac", *faults: dict[str, Any], **keys: Any) -> Bench:
    return Bench({"bench": "board", "devices": {"b": {"profile": profile, **keys}}, "faults": list(faults)})


def score_of(session: TypedSession, board: Bench, tolerance_ms: float = 1.0) -> SessionScore:
    twin = twin_answers(session)
    return scored(session, at_board(session, board, twin), twin, lambda line: False, tolerance_ms)


def test_answers_have_their_times_and_ends() -> None:
    session = session_of(typed("vd\r"), typed("xm200v60a0d0u0f\r", stands=VD), typed("\r"))
    speed, move, empty = twin_answers(session)
    assert (speed.text, speed.stood_ms) == ("vd\r\n0\t0\r\nSAC>", None)
    # 13 characters at 38400 baud, from the first one's echo on, which follows two more.
    assert (speed.first_ms, speed.last_ms) == (pytest.approx(0.52, abs=0.01), pytest.approx(3.65, abs=0.01))
    assert move.text == "xm200v60a0d0u0f\r\nSAC>"
    assert move.stood_ms == pytest.approx(1000, abs=51)
    assert empty.text == "\r\nSAC>"


def test_a_board_that_signals_its_end() -> None:
    ends = {"shows": "\x12", "within_ms": 5000}
    session = session_of(typed("$O1\r"), typed("xm200v60a0d0u0ft100000\r", stands=ends), typed("vd\r"))
    _, move, speed = twin_answers(session)
    assert move.stood_ms == pytest.approx(1106.2, abs=1)  # 200 steps at 60 rpm, and the wait
    assert speed.text == "vd\r\n0\t0\r\nSAC>"


def test_an_answer_that_takes_longer_than_its_time_is_whole() -> None:
    session = session_of({"types": "q\r", "for_ms": 50}, typed("\r"))
    listing, empty = twin_answers(session)
    assert (len(listing.text), listing.text[-4:], empty.text) == (1364, "SAC>", "\r\nSAC>")
    assert listing.last_ms is not None
    assert listing.last_ms < 50 + LATE_MS


def test_a_board_like_its_twin_has_it_all() -> None:
    session = session_of(typed("vd\r"), typed("xm200v60a0d0u0f\r", stands=VD))
    score = score_of(session, board_bench())
    assert [each.is_equal for each in score.steps] == [True, True]
    assert (score.percent, score.equal, score.host_ms) == (100.0, 2, 0.0)


def test_another_setting_parts_at_the_command_that_shows_it() -> None:
    session = session_of(typed("vd\r"), typed("cf\r"), typed("vd\r"))
    board = board_bench()
    board.start()
    board.run(200)
    board.port("b").write(b"v120\r")
    score = score_of(session, board)
    assert [each.is_equal for each in score.steps] == [True, False, True]
    assert score.steps[1].parting is not None
    assert (score.steps[1].parting.board, score.steps[1].parting.twin) == ("v\t120\r\n", "v\t100\r\n")


def test_a_motion_of_another_length_parts_at_its_end() -> None:
    moves = typed("xm200v60a0d0u0f\r", stands=VD)
    slow = typed("xm200v50a0d0u0f\r", stands=VD)
    board = twin_answers(session_of(slow))
    twin = twin_answers(session_of(moves))
    (score,) = scored(session_of(moves), board, twin, lambda line: False, 20.0).steps
    assert set(score.late) == {STOOD}
    assert score.late[STOOD].late_ms == pytest.approx(200, abs=51)
    assert score.parting is not None  # the echo has the other speed


def test_a_motion_without_an_end_says_whose() -> None:
    session = session_of(typed("xm200v60a0d0u0f\r", stands=VD))
    twin = twin_answers(session)
    board = [StepAnswer(twin[0].text, twin[0].first_ms, twin[0].last_ms, None)]
    (score,) = scored(session, board, twin, lambda line: False, 20.0).steps
    assert (score.never_stood, score.is_equal) == (("board",), False)
    assert score.percent < 70


def test_what_host_and_adapter_add_is_not_counted() -> None:
    session = session_of(typed("vd\r"), typed("\r"))
    twin = twin_answers(session)
    board = [StepAnswer(each.text, each.first_ms, each.last_ms) for each in twin]
    for each, late_ms in zip(board, (3.0, 5.0), strict=True):
        assert each.first_ms is not None
        assert each.last_ms is not None
        each.first_ms, each.last_ms = each.first_ms + late_ms, each.last_ms + late_ms
    score = scored(session, board, twin, lambda line: False, 1.5)
    assert score.host_ms == pytest.approx(3.0)
    assert [sorted(each.late) for each in score.steps] == [[], ["first byte", "last byte"]]
    assert score.times_ms == pytest.approx([0, 0, 2, 2])
    assert score.steps[1].percent == pytest.approx(50 + 50 * 0.75)


def test_what_prepares_is_typed_but_not_scored() -> None:
    session = session_of(typed("v120\r", prepares=True), typed("vd\r"))
    score = score_of(session, board_bench())
    assert [(each.number, each.step.types) for each in score.steps] == [(1, "vd\r")]


def test_a_board_that_never_answers() -> None:
    session = session_of(*[typed("vd\r")] * 5)
    board = board_bench("sac", {"fault": "byte_drop", "target": "b", "rate": 1.0, "towards": "client"})
    player = StepPlayer(session, twin_answers(session))
    board.start()
    board.talk("b", player.settle(SETTLE_MS))
    with pytest.raises(DialogueError, match=r"nothing answers: .* is the baud right"):
        board.talk("b", player.play())
    assert [each.text for each in player.answers] == ["", ""]


def test_a_board_that_stops_answering() -> None:
    session = session_of(*[typed("vd\r")] * 9)
    player = StepPlayer(session, twin_answers(session))
    lost = {"fault": "byte_drop", "target": "b", "rate": 1.0, "start_s": 1.9, "towards": "client"}
    board = board_bench("sac", lost)
    board.start()
    with pytest.raises(DialogueError, match=r"stopped answering: nothing came of .vd\\r. and .vd\\r."):
        board.talk("b", player.play())
    said = [bool(each.text) for each in player.answers]
    assert said == [True] * (len(said) - 2) + [False] * 2
    assert 2 < len(said) < 9


def test_another_board_is_noticed_before_it_is_told_to_move() -> None:
    session = session_of(*[typed("kpq")] * 5, profile="mechaduino")
    player = StepPlayer(session, twin_answers(session))
    board = board_bench("sac")
    board.start()
    board.run(200)
    with pytest.raises(NotThisBoard, match="is no answer of a mechaduino: another board, or another baud"):
        board.talk("b", player.play())
    assert len(player.answers) == 1
