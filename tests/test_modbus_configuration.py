"""``bridges: {modbus: ...}`` in a configuration: each mistake at its line and column, with a remedy."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import (
    BestAvailableEncryption,
    Encoding,
    KeySerializationEncryption,
    NoEncryption,
    PrivateFormat,
)
from cryptography.x509.oid import NameOID

from hil.compose import find_catalogue
from hil.config import ConfigError, parse

CATALOGUE = find_catalogue()
HEAD = """\
bench: t
devices:
  m1: {profile: mechaduino}
  s1: {profile: sac, network: {kind: pty, path: lines/s1}}
  r1: {profile: sac, at: /dev/ttyUSB3}
"""
ROLES = "tls: {certificate: a, key: b, clients: c, roles: "


def problems(given: str, head: str = HEAD) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parse(f"{head}bridges:\n  modbus: {given}\n", "b.yaml", CATALOGUE, opens_bridges=True)
    return [str(problem) for problem in caught.value.problems]


GIVE = "give each device a place of its own"
ONE = {
    "{rtu: ~}": "17: rtu: a list is wanted here, not nothing (write [] for none, or leave the key out)",
    "{rtu: {path: a}}": '17: rtu: a list is wanted here, not a mapping (begin it with "- ", as an item of a'
    " list, or write [ ] around it)",
    "{rtu: [~]}": "18: rtu.0: keys are wanted here, not nothing (write {path: ...}; its keys are path,"
    " device, baud, echo, units)",
    "{rtu: [{path: ''}]}": "25: rtu.0.path: there is nothing in it (write what it is)",
    "{rtu: [{path: 5}]}": "25: rtu.0.path: YAML takes this for the number 5; text is wanted (write it in"
    ' quotes: "5")',
    "{units: [1]}": '19: units: keys are wanted here, not a list (write "key: value" lines, indented below)',
    "{units: {m1: true}}": "24: units.m1: a whole number is wanted here, not true (write a whole number)",
    f"{{{ROLES}~}}}}": '61: tls.roles: keys are wanted here, not nothing (write "key: value" lines, indented'
    " below)",
    "{listen: 0.0.0.0:1502}": "20: listen: 0.0.0.0:1502 is reached from other computers, and Modbus"
    " has no users (listen on 127.0.0.1, add `tls` with certificates, or write `insecure: true`)",
    "{rtu: [{device: COM1}]}": "27: rtu.0.device: this is no serial port (write a path as in /dev/ttyUSB0,"
    " socket://host:port or rfc2217://host:port)",
    "{rtu: [{path: m1}]}": f'25: rtu.0.path: device m1 has its port in the same place, "m1" ({GIVE})',
    "{rtu: [{path: ./x/../m1}]}": f'25: rtu.0.path: device m1 has its port in the same place, "m1" ({GIVE})',
    "{rtu: [{path: lines/s1}]}": "25: rtu.0.path: device s1.network has its port in the same place,"
    f' "lines/s1" ({GIVE})',
    "{rtu: [{path: lines}]}": '25: rtu.0.path: device s1.network has its port at "lines/s1", and what is a'
    f" port is no folder of another ({GIVE})",
    "{rtu: [{path: m1/plc}]}": '25: rtu.0.path: device m1 has its port at "m1", and what is a port is no'
    f" folder of another ({GIVE})",
    "{rtu: [{path: control.sock}]}": "25: rtu.0.path: the bench has its control socket in the same place,"
    f' "control.sock" ({GIVE})',
    "{rtu: [{path: .}]}": f'25: rtu.0.path: the bench has its folder in the same place, "." ({GIVE})',
    "{rtu: [{path: a}, {path: b}, {path: ./a}]}": "47: rtu.2.path: the bridge modbus has a port in the same"
    f' place, "a" ({GIVE})',
    "{rtu: [{device: 'socket://a:1'}, {device: 'socket://a:1'}]}": "53: rtu.1.device: the bridge modbus has a"
    f' port in the same place, "socket://a:1" ({GIVE})',
    "{rtu: [{device: /dev/ttyUSB3}]}": "27: rtu.0.device: device r1 is in the same place,"
    f' "/dev/ttyUSB3" ({GIVE})',
    "{units: {m1: 1, s1: 1}}": "31: units.s1: unit 1 is m1 and s1 (give each a number of its own)",
    "{rtu: [{path: a, units: {m1: 3, s1: 3}}]}": "47: rtu.0.units.s1: unit 3 is m1 and s1 (give each a"
    " number of its own)",
    "{units: {m1: 1, s: 2}}": "27: units.s: there is no axis 's' (did you mean \"s1\"? there are m1, s1, r1)",
    "{rtu: [{path: a, units: {motor: 3}}]}": "36: rtu.0.units.motor: there is no axis 'motor' (there are m1,"
    " s1, r1)",
    "{units: {M1: 1}}": "20: units.M1: there is no axis 'M1' (did you mean \"m1\"? there are m1, s1, r1)",
}


@pytest.mark.parametrize("given", ONE)
def test_a_mistake_is_told_at_its_place(given: str) -> None:
    column, _, said = ONE[given].partition(": ")
    assert problems(given) == [f"b.yaml:7:{column}: bridges.modbus.{said}"]


@pytest.mark.parametrize("given", ["~", "{}", "{units: ~, tls: ~}", "{rtu: []}", "{units: {r1: 9}}"])
def test_what_may_be_left_out_may_be_null_where_the_reference_says_so(given: str) -> None:
    parse(f"{HEAD}bridges: {{modbus: {given}}}\n", "b.yaml", CATALOGUE, opens_bridges=True)


def test_a_path_in_the_benchs_own_folder() -> None:
    head = f"{HEAD}runtime_dir: /run/hil\n"
    assert problems("{rtu: [{path: /run/hil/t/m1}]}", head) == [
        'b.yaml:8:25: bridges.modbus.rtu.0.path: device m1 has its port in the same place, "/run/hil/t/m1"'
        f" ({GIVE})"
    ]
    text = f"{head}bridges: {{modbus: {{rtu: [{{path: /run/hil/m1}}]}}}}\n"  # of another bench, m1
    parse(text, "b.yaml", CATALOGUE)


def test_further_axes_are_known_by_their_addresses() -> None:
    boards = Path(__file__).parent / "boards"
    head = f"bench: t\nprofile_path: [{boards}]\ndevices: {{a1: {{profile: arm}}}}\n"
    text = f"{head}bridges: {{modbus: {{units: {{a1: 1, a1.elbow: 2}}}}}}\n"
    assert parse(text, "b.yaml", CATALOGUE, opens_bridges=True).bridges
    assert problems("{units: {a1: 1, a1.elbo: 2}}", head) == [
        "b.yaml:5:27: bridges.modbus.units.'a1.elbo': there is no axis 'a1.elbo' (did you mean \"a1.elbow\"?"
        " there are a1, a1.elbow)"
    ]


class Site:
    """Files of certificates, good and bad."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("door", "other"):
            key = ec.generate_private_key(ec.SECP256R1())
            self.write(f"{name}.key", self.pem(key, NoEncryption()))
            self.write(f"{name}.pem", _certificate(key))
            self.write(f"{name}.locked", self.pem(key, BestAvailableEncryption(b"secret")))
        self.write("door.der", b"\x30\x82\x01\x00")
        self.write("garbage.pem", b"-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n")

    def pem(self, key: ec.EllipticCurvePrivateKey, how: KeySerializationEncryption) -> bytes:
        return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, how)

    def write(self, name: str, data: bytes) -> None:
        (self.folder / name).write_bytes(data)

    def given(self, **files: str) -> str:
        names = {"certificate": "door.pem", "key": "door.key", "clients": "other.pem"} | files
        lines = "".join(f"\n      {option}: {self.folder / name}" for option, name in names.items())
        return f"\n    tls:{lines}"


def _certificate(key: ec.EllipticCurvePrivateKey) -> bytes:
    name, now = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "door")]), datetime.now(UTC)
    builder = x509.CertificateBuilder().subject_name(name).issuer_name(name).public_key(key.public_key())
    builder = builder.serial_number(1).not_valid_before(now).not_valid_after(now + timedelta(days=1))
    return builder.sign(key, hashes.SHA256()).public_bytes(Encoding.PEM)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    return Site(tmp_path_factory.mktemp("site"))


FILES: dict[str, tuple[dict[str, str], str]] = {
    "missing": (
        {"certificate": "no.pem"},
        "9:20: certificate: no.pem is not there (write where",
    ),
    "folder": ({"clients": "."}, "11:16: clients: . is no file (write where the file is)"),
    "DER": ({"certificate": "door.der"}, "9:20: certificate: door.der is not PEM (a file in PEM has a line"),
    "garbage": (
        {"clients": "garbage.pem"},
        "11:16: clients: garbage.pem has no certificate (write where a certificate in PEM is)",
    ),
    "key for certificate": (
        {"certificate": "door.key"},
        "9:20: certificate: door.key has no certificate (write where a certificate in PEM is)",
    ),
    "certificate for key": (
        {"key": "door.pem"},
        "10:12: key: door.pem has no private key (write where the key is, in PEM)",
    ),
    "other key": (
        {"key": "other.key"},
        "10:12: key: other.key is not the key of door.pem (write where the key of that certificate is)",
    ),
    "locked key": ({"key": "door.locked"}, "10:12: key: door.locked is locked with a password (take it off"),
    "unreadable": (
        {"key": "/proc/self/mem"},  # no user can
        "10:12: key: /proc/self/mem cannot be read: Input/output error (let the user who serves the bench",
    ),
}


@pytest.mark.parametrize("case", FILES)
def test_files_that_cannot_be_used_are_told_by_the_check(site: Site, case: str) -> None:
    files, wanted = FILES[case]
    place, _, said = wanted.partition(": ")
    (found,) = problems(site.given(**files))
    at, _, rest = found.removeprefix("b.yaml:").partition(": bridges.modbus.tls.")
    assert at == place
    assert rest.replace(f"{site.folder}/", "").replace(str(site.folder), ".").startswith(said)


def test_all_mistakes_are_told_at_once(site: Site) -> None:
    given = f"{site.given(key='other.key')}\n    units: {{m2: 1, s1: 1}}\n    rtu: [{{path: m1}}]"
    assert [each.split(" ")[1] for each in problems(given)] == [
        "bridges.modbus.tls.key:",
        "bridges.modbus.units.m2:",
        "bridges.modbus.units.s1:",
        "bridges.modbus.rtu.0.path:",
    ]


def test_two_mistakes_in_files_are_both_told(site: Site) -> None:
    assert len(problems(site.given(certificate="no.pem", clients="door.der"))) == 2


def test_who_opens_no_door_looks_at_no_file_and_lets_axes_go(site: Site) -> None:
    text = f"{HEAD}bridges:\n  modbus: {site.given(key='no.key')}\n"
    parse(text, "b.yaml", CATALOGUE)
    parse(text.replace("no.key", "door.key"), "b.yaml", CATALOGUE, opens_bridges=True)
    parse(f"{HEAD}bridges: {{modbus: {{units: {{m9: 1}}}}}}\n", "b.yaml", CATALOGUE)  # of a reload
