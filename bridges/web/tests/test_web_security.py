"""Who comes in: names of the door, pages of other sites, users, and what everybody is told."""

import asyncio
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import aiohttp
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID
from pages_of_tests import Door, opened

from bridges.web.bridge import Options
from bridges.web.http_door import SECURITY, HostNames
from bridges.web.login_sessions import AGAIN_S, ATTEMPTS, LIFE_S, MOST_SESSIONS, LoginLimit, Sessions
from bridges.web.page_files import read_page
from bridges.web.password_hash import fits, hash_of, is_hash
from bridges.web.web_users import UsersError, parse_users, read_users
from hil.vocab.desk_protocol import Source
from hil.vocab.verbs import Role

PASSWORD = "long and green"
HASH = hash_of(PASSWORD, bytes(16))
ANN = Source("ann", Role.OPERATOR)


def run(use: Callable[[Door], Awaitable[None]], **options: Any) -> None:
    async def main() -> None:
        async with opened(**options) as door:
            await use(door)

    asyncio.run(main())


@pytest.fixture
def users(tmp_path: Path) -> Path:
    file = tmp_path / "users"
    file.write_text(f"# who may come in\nann:operator:{HASH}\nguest:viewer:{HASH}\n")
    file.chmod(0o600)
    return file


# ---- names ----


@pytest.mark.parametrize(
    ("host", "is_known"),
    [
        ("localhost:8080", True),
        ("LOCALHOST:8080", True),
        ("127.0.0.1:8080", True),
        ("[::1]:8080", True),
        ("lab1:8080", True),
        ("proxy:9000", True),
        ("proxy:8080", False),
        ("lab1:9000", False),
        ("localhost", False),
        ("localhost:80", False),
        ("localhost.:8080", False),
        ("localhost:8080.evil.example", False),
        ("evil.example:8080", False),
        ("127.0.0.1.nip.io:8080", False),
        ("0.0.0.0:8080", False),
        ("", False),
        (None, False),
    ],
)
def test_only_its_own_names_are_answered(host: str | None, is_known: bool) -> None:
    assert HostNames("http", "0.0.0.0", 8080, ["lab1", "proxy:9000"]).is_known(host) is is_known


def test_a_port_that_urls_leave_out_may_be_left_out() -> None:
    names = HostNames("https", "10.0.0.5", 443, ["lab1"])
    assert all(names.is_known(each) for each in ("lab1", "lab1:443", "10.0.0.5", "[::1]"))
    assert not HostNames("http", "10.0.0.5", 443, ["lab1"]).is_known("lab1")


@pytest.mark.parametrize(
    ("origin", "is_own"),
    [
        (None, True),
        ("http://localhost:8080", True),
        ("http://LOCALHOST:8080", True),
        ("https://localhost:8080", False),
        ("http://localhost:8081", False),
        ("http://127.0.0.1:8080", False),
        ("http://localhost:8080.evil.example", False),
        ("null", False),
        ("", False),
    ],
)
def test_only_its_own_page_may_ask(origin: str | None, is_own: bool) -> None:
    assert HostNames("http", "127.0.0.1", 8080, []).is_own(origin, "localhost:8080") is is_own


@pytest.mark.parametrize(
    ("host", "origin", "is_own"),
    [
        ("bench.example", "https://bench.example", True),
        ("bench.example:443", "https://bench.example:443", True),
        ("bench.example", "http://bench.example", False),
        ("bench.example", "https://other.example", False),
        ("[2001:db8::1]:8443", "https://[2001:db8::1]:8443", True),
        ("lab1:8080", "http://lab1:8080", True),
        ("lab1:8080", "https://lab1:8080", False),
    ],
)
def test_behind_a_proxy_the_page_is_one_of_https(host: str, origin: str, is_own: bool) -> None:
    names = HostNames(
        "http", "127.0.0.1", 8080, ["https://bench.example", "https://[2001:db8::1]:8443", "lab1"]
    )
    assert names.is_known(host)
    assert names.is_own(origin, host) is is_own


def test_the_cookie_of_a_proxy_is_for_tls(users: Path) -> None:
    async def use(door: Door) -> None:
        of_proxy = {"Host": "bench.example", "Origin": "https://bench.example"}
        given = {"user": "ann", "password": PASSWORD}
        for headers, is_secure in ((of_proxy, True), ({}, False)):
            async with door.session.post(f"{door.url}api/login", json=given, headers=headers) as answer:
                assert ("Secure" in answer.headers["Set-Cookie"]) is is_secure

    run(use, users=users, names=["https://bench.example"])


def test_a_proxy_needs_users() -> None:
    with pytest.raises(ValueError, match="a proxy, by which others could move the axes"):
        Options(names=["https://bench.example"])
    assert Options(names=["https://bench.example"], insecure=True)
    with pytest.raises(ValueError, match="names"):
        Options(names=["https://"], token="viewer")


PLACES = [
    ("GET", "/"),
    ("GET", "/api/hello"),
    ("POST", "/api/login"),
    ("POST", "/api/logout"),
    ("GET", "/ws"),
]
UPGRADE = {
    **{"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"},
    **{"Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==", "Sec-WebSocket-Protocol": "hil.v1"},
}


def test_a_name_that_leads_here_opens_nothing() -> None:
    """DNS rebinding: to the browser the page is one of evil.example, whose address is this computer's now."""

    async def use(door: Door) -> None:
        port = door.url.rstrip("/").rpartition(":")[2]
        rebound = {"Host": f"evil.example:{port}", "Origin": f"http://evil.example:{port}"}
        for method, path in PLACES:
            headers = {**rebound, **(UPGRADE if path == "/ws" else {})}
            async with door.session.request(method, door.url[:-1] + path, headers=headers) as answer:
                assert answer.status == 421, path
        assert door.bridge.status()["links"] == 0
        assert door.bridge.status()["rejected"] == len(PLACES)

    run(use)


def test_pages_of_other_sites_are_refused_everywhere() -> None:
    async def use(door: Door) -> None:
        for origin in ("http://evil.example", "null", "http://localhost:1"):
            for method, path in PLACES:
                headers = {"Origin": origin, **(UPGRADE if path == "/ws" else {})}
                async with door.session.request(method, door.url[:-1] + path, headers=headers) as answer:
                    assert answer.status == 403, path
        async with door.page(origin=door.url[:-1]) as page:
            assert page.hello["role"] == "admin"

    run(use)


def test_each_answer_has_the_headers_of_security() -> None:
    async def use(door: Door) -> None:
        asked = [
            *PLACES,
            ("GET", "/nothing"),
            ("PUT", "/"),
            ("DELETE", "/api/login"),
            ("GET", "/../../etc/passwd"),
        ]
        for method, path in asked:
            async with door.session.request(method, door.url[:-1] + path) as answer:
                assert {name: answer.headers.get(name) for name in SECURITY} == SECURITY, (method, path)
        async with door.session.get(door.url, headers={"Host": "evil.example"}) as answer:
            assert answer.headers["Content-Security-Policy"] == SECURITY["Content-Security-Policy"]
        async with door.session.get(f"{door.url}ws", headers=UPGRADE) as answer:
            assert answer.status == 101
            assert answer.headers["Content-Security-Policy"] == SECURITY["Content-Security-Policy"]

    run(use)


def test_the_policy_lets_nothing_in_from_elsewhere() -> None:
    policy = dict(each.strip().partition(" ")[::2] for each in SECURITY["Content-Security-Policy"].split(";"))
    assert policy["default-src"] == policy["base-uri"] == policy["frame-ancestors"] == "'none'"
    assert policy["script-src"] == policy["connect-src"] == policy["style-src"] == "'self'"
    assert not any("unsafe" in each or "http" in each or "*" in each for each in policy.values())


@pytest.mark.parametrize(
    "path", ["/%2e%2e/%2e%2e/etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/bridge.py"]
)
def test_there_are_no_files_but_the_page(path: str) -> None:
    async def use(door: Door) -> None:
        connection = await asyncio.open_connection("127.0.0.1", int(door.url[:-1].rpartition(":")[2]))
        reader, writer = connection
        host = door.url.removeprefix("http://").rstrip("/")
        writer.write(f"GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n".encode())
        assert (await reader.readline()).split()[1] in (b"404", b"400")
        writer.close()
        await writer.wait_closed()

    run(use)


# ---- users ----


def test_a_password_opens_with_a_cookie_that_scripts_do_not_see(users: Path) -> None:
    async def use(door: Door) -> None:
        async with door.session.get(f"{door.url}api/hello") as answer:
            told = await answer.json()
            assert told.pop("version") == read_page().version
            assert told == {"login": "password", "user": None, "role": None}
        with pytest.raises(aiohttp.WSServerHandshakeError, match="401"):
            async with door.page():
                pass
        for given in ({"user": "ann", "password": PASSWORD + "x"}, {"user": "bob", "password": PASSWORD}):
            async with door.session.post(f"{door.url}api/login", json=given) as answer:
                assert (answer.status, answer.cookies) == (401, {})
        async with door.session.post(
            f"{door.url}api/login", json={"user": "ann", "password": PASSWORD}
        ) as answer:
            assert answer.status == 204
            (cookie,) = answer.cookies.values()
            assert (cookie["httponly"], cookie["samesite"], cookie["path"]) == (True, "Strict", "/")
            assert cookie["secure"] == ""
            assert len(cookie.value) >= 32
        async with door.page() as page:
            assert (page.hello["user"], page.hello["role"]) == ("ann", "operator")
            async with door.session.post(f"{door.url}api/logout") as answer:
                assert answer.status == 204
            await page.closed()
        with pytest.raises(aiohttp.WSServerHandshakeError, match="401"):
            async with door.page(headers={"Cookie": f"{cookie.key}={cookie.value}"}):
                pass

    run(use, users=users)


def test_a_user_may_do_what_the_role_says(users: Path) -> None:
    """The desk is told who asks; what it lets a role do is the desk's, and tested there."""

    async def use(door: Door) -> None:
        async with door.session.post(f"{door.url}api/login", json={"user": "guest", "password": PASSWORD}):
            pass
        async with door.page() as page:
            await page.ask("ask", operation="status")
            assert door.desk.asked[-1] == (Source("guest", Role.VIEWER, via="web"), "status", "")
            assert (await page.ask("open", port="m1"))["code"] == "forbidden"

    run(use, users=users)


def test_too_many_attempts_have_to_wait(users: Path) -> None:
    async def use(door: Door) -> None:
        wrong = {"user": "nobody", "password": "x" * 2000}  # too long to be looked at: no time is spent
        codes = []
        for _ in range(ATTEMPTS + 2):
            async with door.session.post(f"{door.url}api/login", json=wrong) as answer:
                codes.append(answer.status)
        assert codes == [401] * ATTEMPTS + [429] * 2
        assert 0 < int(answer.headers["Retry-After"]) <= AGAIN_S
        right = {"user": "ann", "password": PASSWORD}
        async with door.session.post(f"{door.url}api/login", json=right) as answer:
            assert answer.status == 429

    run(use, users=users)


@pytest.mark.parametrize("body", [b"", b"[]", b"{", b"\xff", b'{"user": "a"}' + b" " * 5000])
def test_what_is_no_login_is_refused(users: Path, body: bytes) -> None:
    async def use(door: Door) -> None:
        headers = {"Content-Type": "application/json"}
        async with door.session.post(f"{door.url}api/login", data=body, headers=headers) as answer:
            assert answer.status == 400
        async with door.session.post(
            f"{door.url}api/login", data=body, headers={"Content-Type": "text/plain"}
        ) as a:
            assert a.status == 415

    run(use, users=users)


@pytest.mark.parametrize(
    "rest", ["Content-Encoding: gzip\r\nContent-Length: 9\r\n\r\n012345678", "Content-Length: 9\r\n\r\n{"]
)
def test_a_body_that_is_broken_is_the_clients_fault(
    users: Path, caplog: pytest.LogCaptureFixture, rest: str
) -> None:
    """Whoever can reach the door could fill the log with faults of hil's own else."""

    async def use(door: Door) -> None:
        parts = urlsplit(door.url)
        reader, writer = await asyncio.open_connection(parts.hostname, parts.port)
        head = f"POST /api/login HTTP/1.1\r\nHost: {parts.netloc}\r\nContent-Type: application/json\r\n"
        writer.write((head + rest).encode())
        if "gzip" in rest:
            assert (await reader.readline()).startswith(b"HTTP/1.1 400")
        writer.close()
        await door.until(lambda: door.bridge.status()["rejected"] == 1)

    run(use, users=users)
    assert caplog.text == ""


def test_a_token_opens(caplog: pytest.LogCaptureFixture) -> None:
    async def use(door: Door) -> None:
        (token,) = [each.args[0] for each in caplog.records if "token" in each.message]  # type: ignore[index]
        assert str(token) not in str(door.bridge.status())
        for given, status in (({"token": "x"}, 401), ({"token": 5}, 401), ({"token": token}, 204)):
            async with door.session.post(f"{door.url}api/login", json=given) as answer:
                assert answer.status == status
        async with door.page() as page:
            assert page.hello["role"] == "viewer"

    with caplog.at_level("INFO", "hil"):
        run(use, token="viewer")


def certificate(folder: Path) -> dict[str, Path]:
    key, name = (
        ec.generate_private_key(ec.SECP256R1()),
        x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "lab1")]),
    )
    now = datetime.now(UTC)
    made = x509.CertificateBuilder().subject_name(name).issuer_name(name).public_key(key.public_key())
    made = made.serial_number(1).not_valid_before(now).not_valid_after(now + timedelta(days=1))
    files = {"certificate": folder / "door.pem", "key": folder / "door.key"}
    files["certificate"].write_bytes(made.sign(key, hashes.SHA256()).public_bytes(Encoding.PEM))
    files["key"].write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
    return files


def test_with_tls_the_cookie_is_for_tls(tmp_path: Path, users: Path) -> None:
    async def use(door: Door) -> None:
        assert door.url.startswith("https://")
        async with door.session.post(
            f"{door.url}api/login", json={"user": "ann", "password": PASSWORD}
        ) as answer:
            (cookie,) = answer.cookies.values()
            assert cookie["secure"] is True
        async with door.page() as page:
            assert page.hello["user"] == "ann"
        plain = door.url.replace("https", "http")
        with pytest.raises(aiohttp.ClientError):
            await door.session.get(plain)

    run(use, users=users, tls=certificate(tmp_path))


# ---- their parts ----


def test_a_hash_fits_its_password_alone() -> None:
    assert fits(PASSWORD, HASH)
    assert not fits(PASSWORD + "x", HASH)
    assert HASH.startswith("scrypt$14$8$5$AAAAAAAAAAAAAAAAAAAAAA$")
    assert is_hash(HASH)


@pytest.mark.parametrize(
    "text", ["", "scrypt$14$8$5$", HASH[:-4], HASH + "AAAA", HASH.replace("14", "20"), "é" + HASH]
)
def test_what_is_no_hash_is_none(text: str) -> None:
    assert not is_hash(text)
    with pytest.raises(ValueError, match="no hash"):
        fits(PASSWORD, text)


def test_all_wrong_lines_of_users_are_told() -> None:
    lines = [
        f"ann:operator:{HASH}",
        "",
        "# no",
        "ann:viewer:" + HASH,
        "bob:boss:" + HASH,
        "é:viewer:x",
        "eve:viewer:pw",
        "joe",
    ]
    with pytest.raises(UsersError) as caught:
        parse_users(lines, "users")
    said = [message for message, _ in caught.value.problems]
    assert said == [
        "users:4: ann is there twice, first in line 1",
        "users:5: there is no role 'boss'; there are viewer, operator, admin",
        "users:6: 'é' is no name: letters, digits, _ . - and at most 64 of them",
        "users:7: behind eve:viewer: there is no hash of a password",
        "users:8: 'joe' is no line of a user",
    ]


def test_a_file_of_users_is_for_its_owner_alone(users: Path) -> None:
    assert read_users(users)["ann"].role is Role.OPERATOR
    assert HASH not in repr(read_users(users))
    users.chmod(0o640)
    with pytest.raises(UsersError, match=r"others can read it \(mode 0640\); chmod 600"):
        read_users(users)


def test_a_session_lives_after_its_last_use() -> None:
    sessions = Sessions()
    sessions.begin("key", ANN, 0.0)
    assert sessions.find("key", LIFE_S) == ANN
    assert sessions.find("key", 2 * LIFE_S) == ANN
    assert sessions.find("other", 0.0) is None
    assert sessions.find("key", 3 * LIFE_S + 1) is None
    for number in range(MOST_SESSIONS + 1):
        sessions.begin(f"key{number}", ANN, 0.0)
    assert sessions.find("key0", 0.0) is None
    assert sessions.find("key1", 0.0) == ANN


def test_a_session_lives_while_a_page_is_open_and_its_time_after_it() -> None:
    sessions = Sessions()
    sessions.begin("key", ANN, 0.0)
    with sessions.in_use("key", lambda: 3 * LIFE_S), sessions.in_use("key", lambda: 2 * LIFE_S):
        assert sessions.find("key", 1.5 * LIFE_S) == ANN
    assert sessions.find("key", 4 * LIFE_S) == ANN
    assert sessions.find("key", 5 * LIFE_S + 1) is None
    with sessions.in_use("key", lambda: 6 * LIFE_S):  # it has ended: nothing brings it back
        assert sessions.find("key", 5 * LIFE_S + 1) is None


def test_attempts_that_were_right_are_not_counted() -> None:
    limit = LoginLimit()
    for _ in range(3 * ATTEMPTS):
        assert limit.wait_s("a", 100.0) == 0.0
        limit.succeeded("a")
    assert [limit.wait_s("a", 100.0) for _ in range(ATTEMPTS)] == [0.0] * ATTEMPTS
    assert limit.wait_s("a", 100.0) > 0


def test_attempts_come_back_one_by_one() -> None:
    limit = LoginLimit()
    assert [limit.wait_s("a", 100.0) for _ in range(ATTEMPTS)] == [0.0] * ATTEMPTS
    assert limit.wait_s("a", 100.0) == pytest.approx(AGAIN_S)
    assert limit.wait_s("b", 100.0) == 0.0
    assert limit.wait_s("a", 100.0 + AGAIN_S) == 0.0
    assert limit.wait_s("a", 100.0 + AGAIN_S) == pytest.approx(AGAIN_S)
