"""Texts of a table, read: patterns' bytes, expressions, answers. What is wrong is noted at its place."""

import re
from collections.abc import Callable
from typing import TypeVar

from hil.config.document import Finding, KeyPath
from hil.instruments.patterns import PatternRefused, bytes_text
from hil.instruments.table_expressions import Expression, ExpressionRefused, Meaning, read_expression
from hil.instruments.templates import Template, read_template
from hil.vocab.near_words import meant

_Made = TypeVar("_Made")


class DialogueTexts:
    """Reader of a table's texts. ``encoding``: that of the table; ``known``: variables by name."""

    def __init__(self, encoding: str, known: dict[str, Meaning]) -> None:
        self.findings: list[Finding] = []
        self._is_hex = encoding == "hex"
        self._code = "latin-1" if self._is_hex else encoding
        self._known = known

    def _try(self, path: KeyPath, read: Callable[[], _Made]) -> _Made | None:
        try:
            return read()
        except (PatternRefused, ExpressionRefused) as error:
            message, remedy = str(error), error.remedy
            if not remedy and (name := re.search('"(.*)"', message)):
                remedy = meant(name[1], list(self._known)) + "; a value of the command's own stands in takes:"
            self.findings.append(Finding(path, message, remedy))
            return None

    def _find(self, path: KeyPath, message: str, remedy: str, *, at_key: bool = False) -> None:
        self.findings.append(Finding(path, message, remedy, at_key))

    def _bytes(self, path: KeyPath, text: str) -> str:
        """Text as its bytes, each a character."""
        try:
            return text.encode(self._code).decode("latin-1")
        except UnicodeEncodeError as error:
            wrong = text[error.start]
            self._find(
                path, f"{wrong!r} is no character of {self._code}", "write another, or encoding: utf-8"
            )
            return ""

    def _digits(self, path: KeyPath, text: str) -> str:
        """Bytes of a text in base 16."""
        return self._try(path, lambda: bytes_text(text)) or ""

    def _expression(self, path: KeyPath, text: str | float, known: dict[str, Meaning]) -> Expression | None:
        return self._try(path, lambda: read_expression(str(text), known))

    def _condition(
        self, path: KeyPath, text: str | float | None, known: dict[str, Meaning]
    ) -> Expression | None:
        found = None if text is None else self._expression(path, text, known)
        if found and not found.names:
            self._find(
                path, f"{text} is always the same", "write a condition with a variable, or leave it out"
            )
        return found

    def _template(self, path: KeyPath, text: str, known: dict[str, Meaning]) -> Template | None:
        if not text:
            return None
        said = self._bytes(path, text)
        return self._try(
            path, lambda: read_template(said, lambda each: read_expression(each, known), is_hex=self._is_hex)
        )
