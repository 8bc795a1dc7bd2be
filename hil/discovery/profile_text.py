"""Text of a ``board.py``: where it says what, and what Python silently accepts."""

import ast
from collections.abc import Iterator

Place = tuple[int, int]
"""Line and column, from 1."""


class ProfileText:
    """Text of a module that defines ``PROFILE``, which Python has read already."""

    def __init__(self, text: bytes) -> None:
        self._tree = ast.parse(text)
        self._said: ast.expr | None = None
        for node in self._tree.body:
            targets = node.targets if isinstance(node, ast.Assign) else []
            targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
            if any(isinstance(target, ast.Name) and target.id == "PROFILE" for target in targets):
                self._said = node.value  # type: ignore[attr-defined]

    def at(self, part: str | None = None) -> Place:
        """Place of ``PROFILE``, or of a part of it; the first line where it is not written out."""
        node: ast.expr | None = self._said
        if part and isinstance(node, ast.Call):
            node = next((each.value for each in node.keywords if each.arg == part), node)
        return (node.lineno, node.col_offset + 1) if node else (1, 1)

    def twice(self) -> Iterator[tuple[str, Place]]:
        """Find keys that are twice in one written mapping: Python takes the last, and is silent."""
        for node in ast.walk(self._tree):
            keys = node.keys if isinstance(node, ast.Dict) else []
            seen: dict[str, int] = {}
            for key in filter(None, keys):
                name = ast.unparse(key)
                if name in seen:
                    message = f"{name} is given twice, first in line {seen[name]}"
                    yield message, (key.lineno, key.col_offset + 1)
                seen.setdefault(name, key.lineno)
