"""``bridges: {web: ...}`` in a configuration: each mistake at its line and column, with a remedy."""

from pathlib import Path

import pytest

from bridges.web.password_hash import hash_of
from hil.compose import find_catalogue
from hil.config import ConfigError, parse

CATALOGUE = find_catalogue()
HEAD = "bench: t\ndevices: {m1: {profile: mechaduino}}\nbridges:\n  web: "
HASH = hash_of("long and green", bytes(16))


def problems(given: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parse(f"{HEAD}{given}\n", "b.yaml", CATALOGUE, opens_bridges=True)
    return [
        str(problem).replace(": bridges.web", ": ").replace(": .", ": ") for problem in caught.value.problems
    ]


def taken(given: str) -> None:
    parse(f"{HEAD}{given}\n", "b.yaml", CATALOGUE, opens_bridges=True)


ALL_OR_NONE = (
    "add `users` (`hil web user` makes them) and `tls`, or listen on 127.0.0.1, or write `insecure: true`"
)
REFUSED = {
    "{lisen: 1}": ("b.yaml:4:9: lisen: ", 'did you mean "listen"?'),
    "{port: 70000}": ("b.yaml:4:15: port: ", "65535"),
    '{port: "80"}': ("b.yaml:4:15: port: ", "number"),
    "{host: a b}": ("b.yaml:4:15: host: ", "(write an address and a port, as in 127.0.0.1:8080)"),
    "{host: ''}": ("b.yaml:4:15: host: ", "(write an address and a port, as in 127.0.0.1:8080)"),
    "{port: 80, listen: 81}": ("b.yaml:4:15: port: ", "beside listen: the address is there twice (leave out"),
    "{listen: 70000}": ("b.yaml:4:17: listen: ", "'70000' is no port (a port is 1 to 65535, or 0 for any"),
    "{listen: a b}": ("b.yaml:4:17: listen: ", "(write an address and a port, as in 127.0.0.1:8080)"),
    "{listen: '::1'}": ("b.yaml:4:17: listen: ", '(write it in brackets and quotes, as in "[::1]:8080")'),
    "{listen: true}": ("b.yaml:4:17: listen: ", "text"),
    "{names: [lab1, 'a b']}": ("b.yaml:4:1", "(write a name or an address, with or without a port"),
    "{names: ['lab1:99999']}": ("b.yaml:4:1", "(write a name or an address, with or without a port"),
    "{token: boss}": ("b.yaml:4:16: token: ", "viewer"),
    "{sockets: 0}": ("b.yaml:4:18: sockets: ", "1"),
    "{listen: 0.0.0.0}": ("b.yaml:4:", f"and anybody there could move the axes ({ALL_OR_NONE})"),
    "{listen: '[::]', users: u}": ("b.yaml:4:", "and the network could read passwords (add `tls`"),
    "{listen: lab1, token: admin}": ("b.yaml:4:", "and the network could read passwords (add `tls`"),
    "{users: u, token: admin}": ("b.yaml:4:", "users and token: there is one way in (leave out one of them)"),
}


@pytest.mark.parametrize("given", REFUSED)
def test_a_mistake_has_its_place_and_its_remedy(given: str) -> None:
    (problem,) = problems(given)
    place, words = REFUSED[given]
    assert problem.startswith(place)
    assert words in problem


@pytest.mark.parametrize(
    "given",
    [
        "~",
        "{}",
        "{port: 0, host: localhost}",
        "{host: '::1', port: ~}",
        "{listen: 0}",
        "{listen: localhost}",
        "{listen: '[::1]:0', names: [lab1, 'lab1:9000', '[::1]:9000', 10.0.0.5]}",
        "{token: viewer}",
        "{listen: 0.0.0.0:80, insecure: true}",
    ],
)
def test_what_is_closed_or_meant_is_taken(given: str) -> None:
    taken(given)


def test_files_are_read_by_the_check(tmp_path: Path) -> None:
    users = tmp_path / "users"
    (missing,) = problems(f"{{users: {users}}}")
    assert missing == (
        f"b.yaml:4:16: users: {users}: No such file or directory (`hil web user NAME:ROLE` makes a line)"
    )
    users.write_text(f"ann:operator:{HASH}\neve:viewer:plain\nbob:boss:{HASH}\n")
    users.chmod(0o644)
    (readable,) = problems(f"{{users: {users}}}")
    assert readable == f"b.yaml:4:16: users: {users}: others can read it (mode 0644) (chmod 600 {users})"
    users.chmod(0o600)
    (wrong,) = problems(f"{{users: {users}}}")
    assert (
        f"{users}:2: behind eve:viewer: there is no hash of a password; {users}:3: there is no role" in wrong
    )
    users.write_bytes(b"ann\xff")
    (no_text,) = problems(f"{{users: {users}}}")
    assert "is not UTF-8 text (save the file as UTF-8)" in no_text
    users.write_text(f"ann:operator:{HASH}\n")
    taken(f"{{users: {users}}}")


def test_certificates_are_read_by_the_check(tmp_path: Path) -> None:
    certificate, key = tmp_path / "door.pem", tmp_path / "door.key"
    given = f"{{listen: 0.0.0.0, token: admin, tls: {{certificate: {certificate}, key: {key}}}}}"
    one, other = problems(given)
    assert f"tls.certificate: {certificate} is not there (write where the file is, in PEM)" in one
    assert f"tls.key: {key} is not there (write where the file is, in PEM)" in other
    certificate.write_text("no\n")
    key.mkdir()
    (folder,) = problems(given)
    assert f"tls.key: {key} is no file" in folder
    key.rmdir()
    key.write_text("no\n")
    (neither,) = problems(given)
    assert f"tls.certificate: {certificate} and {key} are no certificate and its open key" in neither
