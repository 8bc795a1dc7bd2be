"""Sites: the list of members, folders, what is refused with which sentence. Without a network."""

import json
import os
import shutil
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
import zenoh
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from bridges.zenoh.access import access_of
from bridges.zenoh.cli import app
from bridges.zenoh.options import Options
from bridges.zenoh.site_authority import SiteAuthority, new_site
from bridges.zenoh.site_folder import SiteFolder, read_certificates
from bridges.zenoh.site_list import SiteList, SiteMember, parsed, read_grant, read_label, written
from bridges.zenoh.users import SecurityError
from bridges.zenoh.zenoh_config import site_options, site_subjects
from hil.client.link import from_file
from hil.client.messages import ClientError
from hil.vocab.verbs import Role

NOW = datetime(2026, 6, 1, tzinfo=UTC)
DAY = timedelta(days=1)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sites") / "lab"
    site = new_site(folder, "lab", ["hub.lan"], 7447, NOW, 365, None)
    site.add_benches(["mill"], {"rig": "press"}, (), NOW, 365)
    site.add_benches(["lathe"], {}, (), NOW, 365)
    site.add_user("otto", [read_grant("operator@mill"), read_grant("viewer")], NOW, 365)
    site.add_user("anna", [read_grant("admin@rig=press")], NOW, 365)
    return folder


@pytest.fixture
def lab(made: Path, tmp_path: Path) -> SiteAuthority:
    """A site that a test may change."""
    return SiteAuthority(Path(shutil.copytree(made, tmp_path / "lab")))


def copied(lab: SiteAuthority, name: str) -> Path:
    """Folder of a member, at its computer."""
    return Path(shutil.copytree(lab.place(name), lab.folder.parent / f"at-{name}", dirs_exist_ok=True))


# ---- the list ----

names = st.from_regex(r"[a-z][a-z0-9_-]{0,9}", fullmatch=True).filter(lambda name: name != "router")
texts = st.from_regex(r"[A-Za-z0-9][A-Za-z0-9._/:-]{0,9}", fullmatch=True)
labels = st.dictionaries(names, texts, max_size=3)
wheres = st.one_of(st.just(""), names.map("@{}".format), st.builds("@{}={}".format, names, texts))
grants = st.lists(
    st.builds("{}{}".format, st.sampled_from(["viewer", "operator", "admin"]), wheres).map(read_grant)
)


@st.composite
def lists(draw: Callable[..., Any]) -> SiteList:
    members = {}
    for name in draw(st.lists(names, unique=True, max_size=6)):
        if draw(st.booleans()):
            members[name] = SiteMember(name, name, True, draw(labels))
        else:
            members[name] = SiteMember(name, f"{name}+2", grants=draw(grants))
    revoked = draw(st.frozensets(st.integers(0, 1 << 80).map("{:x}".format), max_size=3))
    number = draw(st.integers(1, 1 << 40))
    return SiteList("lab", number, ["tls/hub.lan:7447"], members, revoked, {"eve": 1})


@settings(max_examples=30)
@given(lists())
def test_a_list_is_read_as_it_was_written(of: SiteList) -> None:
    assert parsed(written(of), "here") == of


@given(st.binary(max_size=200))
def test_what_is_no_list_is_refused(text: bytes) -> None:
    with pytest.raises(SecurityError):
        parsed(text, "here")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"v": 2}, "list of version 2, and this hil reads 1"),
        ({"number": 0}, "whole numbers"),
        ({"number": "1"}, "whole numbers"),
        ({"revoked": ["x y"]}, "hexadecimal"),
        ({"routers": ["tcp/hub:1"]}, "endpoints"),
        ({"users": {"mill": {"certified": "x", "roles": []}}}, "same name"),
        ({"users": {"otto": {"certified": "mill", "roles": []}}}, "same name in their certificates"),
        ({"users": {"otto": {"certified": "otto", "roles": ["boss"]}}}, "no role 'boss'"),
        ({"users": {"router": {"certified": "router", "roles": []}}}, "router"),
        ({"benches": {"mill": {"certified": "mill", "labels": {"a b": "c"}}}}, "KEY=VALUE"),
        ({"benches": []}, "no list of a site"),
        ({"site": 7}, "no text"),
    ],
)
def test_a_list_with_something_wrong(made: Path, change: dict[str, Any], words: str) -> None:
    content = json.loads(written(SiteAuthority(made).list))
    with pytest.raises(SecurityError, match=words):
        parsed(json.dumps(content | change).encode(), "here")


@pytest.mark.parametrize("text", ["rig", "rig=", "=press", "Rig=press", "rig=a b", "rig=a=b", "1=2", ""])
def test_a_label_that_is_none(text: str) -> None:
    with pytest.raises(SecurityError, match="write KEY=VALUE, as in rig=press"):
        read_label(text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("boss", "no role 'boss'; write viewer, operator, admin"),
        ("", "no role ''"),
        ("operator@", "a bench's name or a label"),
        ("operator@Mill", "a bench's name or a label"),
        ("operator@rig=", "KEY=VALUE"),
        ("bench@mill", "no role 'bench'"),
    ],
)
def test_a_role_that_is_none(text: str, words: str) -> None:
    with pytest.raises(SecurityError, match=words):
        read_grant(text)


@pytest.mark.parametrize(
    ("user", "bench", "role"),
    [
        ("otto", "mill", Role.OPERATOR),
        ("otto", "lathe", Role.VIEWER),
        ("anna", "mill", Role.ADMIN),
        ("anna", "lathe", None),
        ("mill", "lathe", Role.OPERATOR),
    ],
)
def test_roles_by_bench_and_label(made: Path, user: str, bench: str, role: Role | None) -> None:
    of = SiteAuthority(made).list
    assert of.role_at(of.members[user], bench) == role


# ---- folders ----


def test_a_folder_has_what_its_member_needs_and_nothing_of_others(made: Path) -> None:
    found = {
        str(path.relative_to(made)): path.stat().st_mode & 0o777 for path in made.rglob("*") if path.is_file()
    }
    own = {"ca.pem", "cert.pem", "key.pem"}
    member = {*own, "site.pub", "members"}
    wanted = {"ca.pem", "members", "site.key", "site.pub", *(f"router/{name}" for name in member)}
    wanted |= {f"benches/{bench}/{name}" for bench in ("mill", "lathe") for name in member}
    wanted |= {f"users/{user}/{name}" for user in ("otto", "anna") for name in {*own, "zenoh.json"}}
    assert set(found) == wanted
    private = {path for path in found if b"PRIVATE KEY" in (made / path).read_bytes()}
    assert private == {path for path in found if path.endswith(("key.pem", "site.key"))}
    assert {found[path] for path in private} == {0o600}
    assert "password" not in "".join((made / path).read_text() for path in found)


def test_a_folder_that_is_good(lab: SiteAuthority) -> None:
    folder = SiteFolder(copied(lab, "mill"), NOW)
    assert folder.member("mill").labels == {"rig": "press"}
    options = site_options(Options(site=folder.folder), folder)
    assert (options.listen, options.connect) == ([], ["tls/hub.lan:7447"])
    assert site_options(Options(site=folder.folder, listen=["tls/0.0.0.0:1"]), folder).connect == []
    assert SiteFolder(copied(lab, "router"), NOW).own is None


def _without(*names: str) -> Callable[[SiteAuthority, Path], None]:
    def change(_: SiteAuthority, folder: Path) -> None:
        for name in names:
            (folder / name).unlink()

    return change


def _of_another_site(*names: str) -> Callable[[SiteAuthority, Path], None]:
    def change(lab: SiteAuthority, folder: Path) -> None:
        other = new_site(lab.folder.parent / "other", "lab", ["hub.lan"], 7447, NOW, 365, None)
        other.add_benches(["mill"], {}, (), NOW, 365)
        for name in names:
            shutil.copy(other.place("mill") / name, folder / name)

    return change


def _edited(lab: SiteAuthority, folder: Path) -> None:
    text = (folder / "members").read_text()
    (folder / "members").write_text(text.replace("viewer", "admin"))


def _removed(lab: SiteAuthority, folder: Path) -> None:
    lab.remove(["mill"])
    shutil.copy(lab.folder / "members", folder)


def _back(lab: SiteAuthority, folder: Path) -> None:
    old = (folder / "members").read_bytes()
    lab.change("otto", [read_grant("viewer")])
    shutil.copy(lab.folder / "members", folder)
    SiteFolder(folder, NOW)
    (folder / "members").write_bytes(old)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_without("key.pem"), "key.pem is missing: the folder was copied in part"),
        (_without("members", "site.pub"), "site.pub and members are missing"),
        (lambda _, folder: shutil.rmtree(folder), "no such folder"),
        (lambda _, folder: os.chmod(folder / "key.pem", 0o640), "mode 0640.; chmod 600"),
        (
            lambda _, folder: (folder / "cert.pem").write_text(""),
            "empty, or no regular file|Invalid argument",
        ),
        (lambda _, folder: (folder / "cert.pem").write_text("x"), "no certificate in it"),
        (lambda _, folder: (folder / "key.pem").write_text("x"), "no private key in it"),
        (lambda lab, folder: shutil.copy(lab.place("lathe") / "cert.pem", folder), "not the key of cert.pem"),
        (_of_another_site("ca.pem"), "they are of two sites"),
        (_of_another_site("cert.pem", "key.pem"), "no authority in ca.pem issued it"),
        (_of_another_site("members"), "another site's list, or it was changed"),
        (_edited, "another site's list, or it was changed"),
        (lambda _, folder: (folder / "members").write_text("{}"), "its last line, the signature, is missing"),
        (_removed, "the certificate of 'mill' is revoked in list 6"),
        (_back, "it is list 5, and list 6 was here already"),
    ],
)
def test_a_folder_with_something_wrong(
    lab: SiteAuthority, change: Callable[[SiteAuthority, Path], object], words: str
) -> None:
    folder = copied(lab, "mill")
    change(lab, folder)
    with pytest.raises(SecurityError, match=words):
        SiteFolder(folder, NOW).member("mill")


@pytest.mark.parametrize(
    ("at", "words"),
    [
        (
            NOW + 366 * DAY,
            r"expired at 2027-06-01 .*it is 2027-06-02 .* here.; renew it: `hil zenoh site rotate`",
        ),
        (
            NOW - DAY,
            "valid from 2026-05-31 23:00 UTC on, and it is 2026-05-31 00:00 here; compare the clocks",
        ),
        (NOW + 4000 * DAY, "ca.pem: the authority's certificate expired"),
    ],
)
def test_a_certificate_that_is_not_good_now(lab: SiteAuthority, at: datetime, words: str) -> None:
    with pytest.raises(SecurityError, match=words):
        SiteFolder(copied(lab, "mill"), at)


def test_the_folder_of_another_member(lab: SiteAuthority) -> None:
    with pytest.raises(SecurityError, match="folder of the bench lathe, and this is the bench mill"):
        SiteFolder(copied(lab, "lathe"), NOW).member("mill")


def test_what_is_replaced_is_taken_and_what_is_wrong_is_not(lab: SiteAuthority) -> None:
    folder = SiteFolder(copied(lab, "mill"), NOW)
    folder.refresh(NOW)
    old = (folder.folder / "members").read_bytes()
    lab.remove(["otto"])
    shutil.copy(lab.folder / "members", folder.folder)
    folder.refresh(NOW)
    assert (folder.list.number, set(folder.list.members)) == (6, {"mill", "lathe", "anna"})
    (folder.folder / "members").write_bytes(old)
    with pytest.raises(SecurityError, match="an older one could give back what was revoked"):
        folder.refresh(NOW)
    assert folder.list.number == 6
    folder.refresh(NOW)  # it is said once
    before = folder.version
    lab.rotate(["mill"], NOW, 365)
    for name in ("cert.pem", "members"):
        shutil.copy(lab.place("mill") / name, folder.folder)
    with pytest.raises(SecurityError, match="not the key of"):
        folder.refresh(NOW)
    shutil.copy(lab.place("mill") / "key.pem", folder.folder)
    folder.refresh(NOW)
    assert folder.version[0] == 7
    assert folder.version[1] != before[1]


# ---- changes ----


def test_a_name_is_there_once(lab: SiteAuthority) -> None:
    for name in ("otto", "Otto", "mill", "MILL"):
        with pytest.raises(SecurityError, match="is there already"):
            lab.add_user(name, [], NOW, 1)
    with pytest.raises(SecurityError, match="twice"):
        lab.add_benches(["press", "press"], {}, (), NOW, 1)
    with pytest.raises(SecurityError, match="router's certificate"):
        lab.add_user("Router", [], NOW, 1)
    assert lab.list.number == 5


def test_a_key_that_is_stolen_or_was_taken_back_never_counts_again(lab: SiteAuthority) -> None:
    old = read_certificates(lab.place("otto") / "cert.pem")[0]
    lab.rotate(["otto"], NOW, 365)
    assert lab.list.members["otto"].certified == "otto"
    lab.rotate(["otto"], NOW, 365, is_stolen=True)
    assert lab.list.members["otto"].certified == "otto+2"
    lab.remove(["otto"])
    lab.add_user("otto", [], NOW, 365)
    assert lab.list.members["otto"].certified == "otto+3"
    assert lab.list.was_there("otto")
    assert lab.list.was_there("otto+2")
    assert not lab.list.was_there("otto+3")
    assert lab.list.by_certificate("otto") is None
    assert old.subject.rfc4514_string() == "CN=otto"


def test_what_cannot_be_changed(lab: SiteAuthority) -> None:
    with pytest.raises(SecurityError, match="no such member; there: mill, lathe, otto, anna"):
        lab.remove(["mila"])
    with pytest.raises(SecurityError, match="roles are for users"):
        lab.change("mill", [read_grant("viewer")])
    with pytest.raises(SecurityError, match="labels are for benches"):
        lab.change("otto", None, {})
    with pytest.raises(SecurityError, match="not empty, and nothing is overwritten"):
        new_site(lab.folder, "lab", ["hub"], 1, NOW, 1, None)
    with pytest.raises(SecurityError, match=r"there is no site\.key"):
        SiteAuthority(lab.place("mill"))


def test_the_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)

    def said(line: str, code: int = 0) -> str:
        done = CliRunner().invoke(app, ["site", *line.split()])
        assert done.exit_code == code, done.output
        return done.output

    said("new lab --router hub.lan")
    said("add-bench lab mill lathe --label rig=press")
    assert "no bench of the site is that yet" in said("add-user lab otto --role operator@rig=pres")
    said("change lab otto --role viewer@mill")
    assert "operator" not in said("show lab")
    content = json.loads(said("show lab --json"))
    assert [each["name"] for each in content["members"]] == ["router", "mill", "lathe", "otto"]
    assert said("show lab/benches/mill").startswith("lab: list 4")
    assert "user otto until" in said("show lab/users/otto")
    said("rotate lab --days 2")
    assert "within 30 days end router, mill, lathe, otto" in said("show lab")
    said("remove lab otto lathe")
    assert '"number": 6' in said("show lab --json")
    assert not (tmp_path / "lab/users/otto").exists()
    assert "a bench has one value of it" in said("change lab mill --label a=1 --label a=2", 2)
    assert "is missing" in said(f"show {tmp_path / 'lab/benches'}", 2).replace("are missing", "is missing")
    assert "is there already" in said("add-bench lab mill", 2)


# ---- access control ----


@pytest.mark.parametrize(
    ("who", "flow", "message", "key", "is_allowed"),
    [
        ("otto", "ingress", "query", "hil/mill/axis/m1/cmd/go", True),
        ("otto", "ingress", "query", "hil/lathe/axis/m1/cmd/go", False),
        ("otto", "ingress", "put", "hil/lathe/axis/m1/cmd/go", False),
        ("otto", "egress", "reply", "hil/lathe/axis/m1/state", True),
        ("otto", "ingress", "query", "hil/*/halt", True),
        ("otto", "ingress", "put", "hil/mill/axis/m1/state", False),
        ("otto", "ingress", "query", "hil/mill/segment/s/fault", False),
        ("anna", "ingress", "query", "hil/mill/segment/s/fault", True),
        ("anna", "egress", "put", "hil/lathe/axis/m1/state", False),
        ("anna", "egress", "put", "hil/mill/axis/m1/state", True),
        ("anna", "ingress", "query", "hil/*/axis/*/state", True),
        ("anna", "egress", "reply", "hil/lathe/axis/m1/state", False),
        ("anna", "ingress", "liveliness_query", "hil/*/@live/daemon", True),
        ("anna", "ingress", "liveliness_token", "hil/mill/@live/daemon", False),
        ("anna", "ingress", "declare_queryable", "hil/mill/**", False),
        ("mill", "ingress", "put", "hil/mill/axis/m1/state", True),
        ("mill", "ingress", "put", "hil/lathe/axis/m1/state", False),
        ("mill", "ingress", "reply", "hil/lathe/axis/m1/state", False),
        ("mill", "ingress", "liveliness_token", "hil/lathe/@live/daemon", False),
        ("mill", "ingress", "query", "hil/lathe/run/r1/part", True),
        ("mill", "ingress", "query", "hil/lathe/axis/m1/cmd/go", False),
    ],
)
def test_a_router_lets_through(
    made: Path, who: str, flow: str, message: str, key: str, is_allowed: bool
) -> None:
    control = access_of(site_subjects(SiteAuthority(made).list), "*")
    rules = {rule["id"]: rule for rule in control["rules"]}
    known = [each["id"] for each in control["subjects"] if who in each["cert_common_names"]]
    mine = [
        rules[n] for each in control["policies"] if set(known) & {*each["subjects"]} for n in each["rules"]
    ]
    assert is_allowed == any(
        flow in rule["flows"]
        and message in rule["messages"]
        and any(zenoh.KeyExpr(each).includes(zenoh.KeyExpr(key)) for each in rule["key_exprs"])
        for rule in mine
    )


# ---- a user's folder ----


def test_a_users_file_signs_with_the_key_beside_it(lab: SiteAuthority) -> None:
    folder = copied(lab, "otto")
    entries, door, signer = from_file(folder / "zenoh.json")
    assert door == "tls/hub.lan:7447"
    assert signer is not None
    assert signer.user == "otto"
    assert entries["transport"]["link"]["tls"]["connect_private_key"] == str(folder / "key.pem")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_without("cert.pem"), "cert.pem is missing: the folder was copied in part"),
        (_without("key.pem", "ca.pem"), "key.pem is missing|ca.pem is missing"),
        (lambda _, folder: os.chmod(folder / "key.pem", 0o644), "others can read this key"),
        (lambda lab, folder: shutil.copy(lab.place("anna") / "cert.pem", folder), "is not the key of"),
    ],
)
def test_a_users_folder_with_something_wrong(
    lab: SiteAuthority, change: Callable[[SiteAuthority, Path], object], words: str
) -> None:
    folder = copied(lab, "otto")
    change(lab, folder)
    with pytest.raises(ClientError, match=words):
        from_file(folder / "zenoh.json")
