"""Profiles: what a board may say of itself."""

from hil.vocab.firmware import Board, CoreEvent, Delay, Main
from hil.vocab.profile import Profile
from hil.vocab.verbs import COMMON, Verb


class Silent:
    def __init__(self, board: Board) -> None:
        pass

    def main(self) -> Main:
        while True:
            yield Delay(1)

    def interrupt(self, event: CoreEvent) -> None:
        pass


def test_a_firmware_is_all_that_a_board_has_to_say() -> None:
    profile = Profile(firmware=Silent)
    assert list(profile.uarts) == ["main"]
    assert list(profile.table.values()) == list(COMMON)
    assert (profile.dialogues, profile.terminal_axis, profile.commands) == ({}, None, None)


def test_its_verbs_are_beside_those_of_all_boards() -> None:
    ping = Verb("ping", "say it again")
    assert list(Profile(firmware=Silent, verbs=(ping,)).table) == ["ping", *(verb.name for verb in COMMON)]
