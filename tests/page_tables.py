"""Preparations of pages by page and heading, and commands that are carried out in a way of their own."""

from collections.abc import Callable

from page_sessions import Session

Prepare = Callable[[Session], None]
CarryOut = Callable[[Session, str], str]
PREPARATIONS: dict[tuple[str, str], Prepare] = {}
"""By page and heading."""
CARRIED_OUT: dict[tuple[str, str], CarryOut] = {}
"""By page and the command's beginning."""


def page(name: str) -> str:
    return "docs/faq.md" if name == "faq" else f"docs/how-to/{name}.md"


def before(name: str, heading: str) -> Callable[[Prepare], Prepare]:
    def enter(prepare: Prepare) -> Prepare:
        PREPARATIONS[page(name), heading] = prepare
        return prepare

    return enter


def carries_out(name: str, command: str) -> Callable[[CarryOut], CarryOut]:
    def enter(carry_out: CarryOut) -> CarryOut:
        CARRIED_OUT[page(name), command] = carry_out
        return carry_out

    return enter
