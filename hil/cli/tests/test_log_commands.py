"""`hil log commands`: what it lists, and what its check finds."""

import base64
import json
import time
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from hil.cli.framework.command_group import app
from hil.net.signature import signed
from hil.wire.command_lines import AFTER, BEGINS, chained

HOUR_NS = 3_600_000_000_000
SECRET, KEY, PAYLOAD = "correct-horse-battery", "hil/b/axis/m1/cmd/enable", b"{}"


def row(user: str, hours_ago: int, signer: str = "") -> dict[str, Any]:
    wall_ns = time.time_ns() - hours_ago * HOUR_NS
    told: dict[str, Any] = {"wall_ns": wall_ns, "user": user, "door": "zenoh", "operation": "enable"}
    told |= {"target": "m1", "given": {}, "outcome": "done"}
    if signer:
        attachment = signed(signer, SECRET, KEY, PAYLOAD, wall_ns, "00" * 8).decode()
        payload = base64.b64encode(PAYLOAD).decode()
        told["proof"] = {"key": KEY, "attachment": attachment, "payload_base64": payload}
    return told


@pytest.fixture
def state(tmp_path: Path) -> Path:
    rows = [row("ann", 5, "ann"), row("bob", 3), row("ann", 1, "ann")]
    before, texts = "", []
    for each in [{BEGINS: "hil 1", "bench": "b", AFTER: "", "wall_ns": 1}, *rows]:
        line = chained(each, before)
        before = line.chain
        texts.append(line.text + "\n")
    (tmp_path / "b" / "commands").mkdir(parents=True)
    (tmp_path / "b" / "commands" / "2026-11-29.jsonl").write_text("".join(texts))
    (tmp_path / "users").write_text(f"# lab\nann:operator:{SECRET}\n")
    return tmp_path


def asked(state: Path, *words: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["log", "commands", "--state-dir", str(state), *words])
    return result.exit_code, result.output


def test_it_lists_by_user_and_time(state: Path) -> None:
    code, text = asked(state, "--user", "ann", "--since", "2h")
    assert code == 0
    assert text.endswith("Z b: ann at zenoh: m1: enable: done\n")
    assert len(text.splitlines()) == 1
    code, text = asked(state, "--json")
    assert [each["user"] for each in json.loads(text)[1:]] == ["ann", "bob", "ann"]


def test_the_check_finds_what_was_changed_and_who_signed(state: Path) -> None:
    assert asked(state, "--check") == (0, "4 lines, each follows the one before\n")
    code, text = asked(state, "--check", "--passwords", str(state / "users"))
    assert (code, text) == (0, "4 lines, each follows the one before; 2 signatures are right\n")
    (state / "users").write_text("ann:operator:another-password\n")
    code, text = asked(state, "--passwords", str(state / "users"))
    assert (code, text.count("the signature is wrong")) == (1, 2)
    path = state / "b" / "commands" / "2026-11-29.jsonl"
    path.write_text("".join(line for line in path.read_text().splitlines(True) if "bob" not in line))
    code, text = asked(state, "--check")
    assert code == 1
    assert f"{path}:3: it was changed, or lines before it are missing" in text


def test_what_is_wrong_with_its_words_is_said(state: Path) -> None:
    (state / "b.yaml").write_text("bench: b\n")
    wrong = CliRunner().invoke(app, ["log", "commands", str(state / "b.yaml")])
    assert wrong.exit_code == 2
    assert f"{state}/b.yaml:1: this is no log of commands; `hil log commands` alone" in wrong.output
    absent = CliRunner().invoke(app, ["log", "commands", str(state / "nofile")])
    assert (absent.exit_code, "write a path that is there" in absent.output) == (2, True)
    assert "is no time; write 90s" in asked(state, "--since", "soon")[1]
    assert "keep_days: 30" in asked(state, "--bench", "none")[1]


def test_signatures_by_certificates_are_checked_with_the_authority(state: Path) -> None:
    x509 = pytest.importorskip("cryptography.x509")
    from datetime import UTC, datetime, timedelta

    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import Encoding

    from hil.net.signature import KeySigner

    def certificate(name: str, key: Any, issuer: str, by: Any) -> Any:
        names = [x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, each)]) for each in (name, issuer)]
        now = datetime.now(UTC)
        begun = x509.CertificateBuilder(names[1], names[0], key.public_key(), x509.random_serial_number())
        return begun.not_valid_before(now).not_valid_after(now + timedelta(1)).sign(by, hashes.SHA256())

    site, ann = (ec.generate_private_key(ec.SECP256R1()) for _ in range(2))
    authority = certificate("site", site, "site", site)
    signer = KeySigner("ann", certificate("ann", ann, "site", site), ann)
    told = row("ann", 0)
    proof = {"key": KEY, "payload_base64": base64.b64encode(PAYLOAD).decode()}
    told["proof"] = proof | {"attachment": signer.signed(KEY, PAYLOAD, 5, "00" * 8).decode()}
    (state / "ca.crt").write_bytes(authority.public_bytes(Encoding.PEM))
    head = chained({BEGINS: "hil 1", "bench": "b", AFTER: ""}, "")
    day = state / "day.jsonl"
    day.write_text(f"{head.text}\n{chained(told, head.chain).text}\n")
    words = (str(day), "--authority", str(state / "ca.crt"))
    assert asked(state, *words) == (0, "2 lines, each follows the one before; 1 signatures are right\n")
    told["proof"]["payload_base64"] = base64.b64encode(b"[]").decode()
    day.write_text(f"{head.text}\n{chained(told, head.chain).text}\n")
    code, text = asked(state, *words)
    assert (code, "the signature is wrong" in text) == (1, True)
