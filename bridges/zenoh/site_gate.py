"""Gate of a bench of a site: signatures by the keys of certificates, roles by the site's list."""

import base64
import re
import secrets
import time
from collections import OrderedDict
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, NamedTuple

from bridges.zenoh.gate import Gate, Rejected, Signature
from bridges.zenoh.site_folder import SiteFolder, common_name, issuer_of, refuse_untimely
from bridges.zenoh.site_list import SiteMember
from bridges.zenoh.users import SecurityError, User
from hil.net.signature import KeySigner, is_by_key, text_of
from hil.vocab.desk_protocol import Source

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

_KEPT = 256
"""Maximum number of certificates that are kept as read: users and benches of a site that command."""
_PART = re.compile(r"hil/[^/]+/run/[^/]+/part")


class SiteGate(Gate):
    """Checks the senders of commands to a bench by the newest list of its folder."""

    def __init__(self, folder: SiteFolder, bench: str, since_ns: int = 0) -> None:
        super().__init__((), since_ns)
        self._folder, self._bench = folder, bench
        self._signers: OrderedDict[str, _Signer] = OrderedDict()
        self._known: set[str] = set()
        self.list_changed()

    @property
    def names(self) -> set[str]:
        """Names of members: the same set also when the list changes."""
        return self._known

    def list_changed(self) -> None:
        """Take the list and the certificate that the folder has now."""
        now, before = set(self._folder.list.members), set(self._known)
        self._known |= now
        self._known -= before - now
        self._signers.clear()
        self._own = KeySigner(self._bench, self._folder.certificate, self._folder.key)

    def signed(self, source: Source, bench: str, key: str, payload: bytes) -> bytes:
        """Make an attachment as this bench; of a part of a run for an asker who is a user of the site, as at
        the control socket the process's user. A stop of all is the bench's own."""
        person = source.person if _PART.fullmatch(key) else ""
        asker = person if person in self._known else bench
        return self._own.signed(key, payload, time.time_ns(), secrets.token_hex(8), asker)

    def _user(self, given: Signature, key: str, payload: bytes, now_ns: int) -> User:
        if not given.certificate:
            raise Rejected(
                "the command is signed by a password, and this bench takes signatures by a site's"
                " certificate:"
                " connect with the folder of `hil zenoh site add-user`"
            )
        signer = self._signer_of(given.certificate, now_ns)
        text = f"{given.user}\n".encode() + text_of(key, payload, given.at_ns, given.nonce)
        signature = base64.b64decode(given.signature)
        if not is_by_key(signer.key, signature, text):
            raise Rejected("the signature is wrong: check user, key and payload")
        member = self._member(signer)
        asker = self._asker(member, given.user, key)
        role = self._folder.list.role_at(asker, self._bench)
        if role is None:
            raise Rejected(
                f"{asker.name} has no role at bench {self._bench}; `hil zenoh site change` gives"
                " one, in a list"
                f" after {self._folder.list.number}"
            )
        return User(asker.name, role, is_bench=asker.is_bench)

    def _member(self, signer: "_Signer") -> SiteMember:
        name, newest = signer.name, self._folder.list
        member = newest.by_certificate(name)
        if signer.serial in newest.revoked or (member is None and newest.was_there(name)):
            raise Rejected(
                f"the certificate of {name} is revoked, by list {newest.number} of the site {newest.site} or"
                " one before; ask for a new folder"
            )
        if member is None:
            raise Rejected(
                f"{name} is not in list {newest.number} of the site {newest.site}, which bench {self._bench}"
                " has; copy the newest list to it"
            )
        return member

    def _asker(self, signer: SiteMember, user: str, key: str) -> SiteMember:
        """Member that asks: the signer, or a user for whom a bench asks another about a part of a run."""
        if user == signer.name:
            return signer
        asker = self._folder.list.members.get(user)
        if signer.is_bench and asker and _PART.fullmatch(key):
            return asker
        raise Rejected(f"the signature is that of {signer.name}, not of {user}")

    def _signer_of(self, text: str, now_ns: int) -> "_Signer":
        """Signer by a certificate of this site that is good now."""
        signer = self._signers.get(text)
        if signer is None:
            signer = self._signers[text] = self._read(text)
            if len(self._signers) > _KEPT:
                self._signers.popitem(last=False)
        if not signer.begins_s <= now_ns / 1e9 <= signer.ends_s:
            try:
                now = datetime.fromtimestamp(now_ns / 1e9, UTC)
                refuse_untimely(signer.certificate, now, f"the certificate of {signer.name}")
            except SecurityError as error:
                raise Rejected(str(error)) from None
        return signer

    def _read(self, text: str) -> "_Signer":
        from cryptography import x509

        try:
            certificate = x509.load_der_x509_certificate(base64.b64decode(text))
            begin, end = certificate.not_valid_before_utc, certificate.not_valid_after_utc
            public, name = certificate.public_key(), common_name(certificate)
            issuer = issuer_of(certificate, self._folder.authorities)
        except (
            Exception
        ):  # a stranger's bytes, read in parts: ValueError, KeyError, InvalidVersion and others
            raise Rejected("certificate: it is none that can be read (base64 of DER)") from None
        if issuer is None:
            raise Rejected(
                f"the certificate of {name!r} is not from an authority of the site"
                f" {self._folder.list.site}: it is another site's"
            )
        serial = f"{certificate.serial_number:x}"
        return _Signer(certificate, public, name, serial, begin.timestamp(), end.timestamp())


class _Signer(NamedTuple):
    """Certificate as read. It is good between two times, of seconds since 1970."""

    certificate: "Certificate"
    key: Any
    name: str
    serial: str
    begins_s: float
    ends_s: float
