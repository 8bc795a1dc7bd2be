"""Folder of one member of a site: its certificate and key, the authority, the signed list. Checked with a
sentence for each thing that is wrong; the list may be replaced while a daemon or a router runs."""

import base64
import os
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bridges.zenoh.site_list import SiteList, SiteMember, parsed, written
from bridges.zenoh.users import SecurityError, refuse_endless
from hil.net.signature import NO_CRYPTOGRAPHY, is_by_key, read_key

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

AUTHORITY, CERTIFICATE, KEY, SITE_KEY, LIST = "ca.pem", "cert.pem", "key.pem", "site.pub", "members"
"""Names of the files. ``ca.pem`` has all authorities that issue certificates, intermediate ones too."""
USER_FILES = (AUTHORITY, CERTIFICATE, KEY)
FILES = (*USER_FILES, SITE_KEY, LIST)
SEEN = "members.seen"
"""File with the highest number of a list that was taken, so that none goes back after a restart either."""
_LINE = b"signature: "
_DOMAIN = b"hil site members\n"
_FILE_BYTES = 1 << 22


def read_file(path: Path) -> bytes:
    """Read a file of a site. Raises SecurityError: it is not there, or cannot be read."""
    try:
        refuse_endless(path)
        with path.open("rb") as file:
            return file.read(_FILE_BYTES)
    except OSError as error:
        raise SecurityError(f"{path}: {error.strerror}") from None


def refuse_open(path: Path) -> None:
    """Refuse a private key that others can read. Raises SecurityError."""
    if (mode := path.stat().st_mode & 0o777) & 0o077:
        raise SecurityError(f"{path}: others can read this key (mode {mode:04o}); chmod 600 {path}")


def signed_list(of: SiteList, key: Any) -> bytes:
    """Text of a list with its signature in the last line. ``key``: the site's private key."""
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec

    text = written(of)
    signature = key.sign(_DOMAIN + text, ec.ECDSA(hashes.SHA256()))
    return text + _LINE + base64.b64encode(signature) + b"\n"


def checked_list(content: bytes, key: Any, where: str) -> SiteList:
    """List of a file's content, whose signature is checked by the site's public key.

    Raises:
        SecurityError: it is another site's, or was changed.
    """
    text, mark, last = content.rpartition(_LINE)
    if not mark:
        raise SecurityError(f"{where}: its last line, the signature, is missing; copy the file again")
    try:
        signature = base64.b64decode(last.strip(), validate=True)
    except ValueError:
        signature = b""
    if not is_by_key(key, signature, _DOMAIN + text):
        raise SecurityError(
            f"{where}: {SITE_KEY} has not signed it: it is another site's list, or it was changed; copy both"
            " files from the site's folder of this member"
        )
    return parsed(text, where)


def read_certificates(path: Path) -> "list[Certificate]":
    """Certificates of a PEM file. Raises SecurityError: there is none."""
    from cryptography import x509

    try:
        return x509.load_pem_x509_certificates(read_file(path))
    except ValueError:
        raise SecurityError(f"{path}: there is no certificate in it (PEM); copy it again") from None


def common_name(certificate: "Certificate") -> str:
    """Common name of a certificate's subject; empty: it has none."""
    from cryptography.x509.oid import NameOID

    names = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    return str(names[0].value) if names else ""


def refuse_untimely(certificate: "Certificate", now: datetime, whose: str) -> None:
    """Refuse a certificate that has ended or not begun. Raises SecurityError."""
    begin, end = certificate.not_valid_before_utc, certificate.not_valid_after_utc
    if now > end:
        raise SecurityError(
            f"{whose} expired at {end:%Y-%m-%d %H:%M} UTC (it is {now:%Y-%m-%d %H:%M} here); renew it:"
            " `hil zenoh site rotate` at the authority, and copy it"
        )
    if now < begin:
        raise SecurityError(
            f"{whose} is valid from {begin:%Y-%m-%d %H:%M} UTC on, and it is {now:%Y-%m-%d %H:%M}"
            " here; compare"
            " the clocks of this computer and of the authority's"
        )


def issuer_of(certificate: "Certificate", authorities: "list[Certificate]") -> "Certificate | None":
    """Authority that issued a certificate; None: none of these did."""
    from cryptography import x509
    from cryptography.exceptions import InvalidSignature

    for each in authorities:
        with suppress(ValueError, TypeError, InvalidSignature, x509.ExtensionNotFound):
            if each.extensions.get_extension_for_class(x509.BasicConstraints).value.ca:
                certificate.verify_directly_issued_by(each)
                return each
    return None


def refuse_partial(folder: Path, files: Sequence[str]) -> None:
    """Refuse a folder in which files are missing. Raises SecurityError."""
    if not folder.is_dir():
        raise SecurityError(f"{folder}: there is no such folder; `hil zenoh site` makes it, copy it here")
    if missing := [name for name in files if not (folder / name).exists()]:
        raise SecurityError(
            f"{folder}: {' and '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing: the"
            " folder was"
            " copied in part; copy it again"
        )


def read_own(folder: Path, now: datetime) -> "tuple[list[Certificate], Certificate, Any]":
    """Authorities, certificate and private key of a member.

    Raises:
        SecurityError: they do not belong together, or are not good now.
    """
    authorities = read_certificates(folder / AUTHORITY)
    certificate = read_certificates(folder / CERTIFICATE)[0]
    refuse_open(folder / KEY)
    key = read_key(read_file(folder / KEY), True, str(folder / KEY), SecurityError)
    if certificate.public_key() != key.public_key():
        raise SecurityError(f"{folder}: {KEY} is not the key of {CERTIFICATE}; copy both again")
    issuer = issuer_of(certificate, authorities)
    if issuer is None:
        by = certificate.issuer.rfc4514_string()
        raise SecurityError(
            f"{folder / CERTIFICATE}: it is from {by!r}, and no authority in {AUTHORITY} issued it:"
            " they are of"
            f" two sites; or {AUTHORITY} lacks the intermediate authority: append its certificate"
        )
    refuse_untimely(issuer, now, f"{folder / AUTHORITY}: the authority's certificate")
    refuse_untimely(certificate, now, f"{folder / CERTIFICATE}: the certificate")
    return authorities, certificate, key


class SiteFolder:
    """Folder of a member. ``list`` is the newest that was taken.

    Raises:
        SecurityError: files are missing, do not belong together, or are not good now.
    """

    def __init__(self, folder: Path, now: datetime) -> None:
        self.folder = folder
        try:
            import cryptography  # noqa: F401
        except ImportError:
            raise SecurityError(NO_CRYPTOGRAPHY) from None
        refuse_partial(folder, FILES)
        self._site_key = read_key(read_file(folder / SITE_KEY), False, str(folder / SITE_KEY), SecurityError)
        self._stamps: dict[str, object] = {}
        self.authorities, self.certificate, self.key = read_own(self.folder, now)
        self._stamp()
        self.list = self._newest_list()
        self._remember()

    def __str__(self) -> str:
        return str(self.folder)

    @property
    def own(self) -> SiteMember | None:
        """This member, as the list has it; None: it is not in the list, or is the router."""
        return self.list.by_certificate(common_name(self.certificate))

    @property
    def is_revoked(self) -> bool:
        return f"{self.certificate.serial_number:x}" in self.list.revoked

    def member(self, wanted: str = "") -> SiteMember:
        """This member. ``wanted``: name of the bench that it has to be.

        Raises:
            SecurityError: it was revoked, is not in the list, or is another.
        """
        name, own = common_name(self.certificate), self.own
        if self.is_revoked or own is None:
            how = "is revoked" if self.is_revoked else "has a name that is not"
            raise SecurityError(
                f"{self.folder}: the certificate of {name!r} {how} in list {self.list.number} of the site"
                f" {self.list.site}; ask for a new folder"
            )
        if wanted and (own.name != wanted or not own.is_bench):
            kind = "bench" if own.is_bench else "user"
            raise SecurityError(
                f"{self.folder}: it is the folder of the {kind} {own.name}, and this is the bench {wanted};"
                f" copy the folder {wanted}, or add it: `hil zenoh site add-bench`"
            )
        return own

    @property
    def version(self) -> tuple[int, int]:
        """Number of the list and of the certificate: others are to be used where it differs."""
        return self.list.number, self.certificate.serial_number

    def refresh(self, now: datetime) -> None:
        """Take files that were replaced.

        Raises:
            SecurityError: they are not good; those before stay. It is said once.
        """
        if self._stamp():
            self.list = self._newest_list()
            self._remember()
            self.authorities, self.certificate, self.key = read_own(self.folder, now)

    def _stamp(self) -> bool:
        """Note which files are there. False: the same as before."""
        stamps: dict[str, object] = {}
        for name in (AUTHORITY, CERTIFICATE, KEY, LIST):
            with suppress(OSError):
                stat = (self.folder / name).stat()
                stamps[name] = (stat.st_mtime_ns, stat.st_ino, stat.st_size)
        before, self._stamps = self._stamps, stamps
        return before != stamps

    def _newest_list(self) -> SiteList:
        path = self.folder / LIST
        taken = checked_list(read_file(path), self._site_key, str(path))
        seen = self._seen()
        if taken.number < seen:
            raise SecurityError(
                f"{path}: it is list {taken.number}, and list {seen} was here already: an older one"
                " could give"
                " back what was revoked; copy the newest"
            )
        return taken

    def _seen(self) -> int:
        taken: SiteList | None = getattr(self, "list", None)
        seen = taken.number if taken else 0
        with suppress(OSError, ValueError):
            seen = max(seen, int((self.folder / SEEN).read_text()))
        return seen

    def _remember(self) -> None:
        """Note the list's number, where the folder can be written; in memory it is in any case."""
        path = self.folder / SEEN
        with suppress(OSError, ValueError):
            if path.exists() and int(path.read_text()) == self.list.number:
                return
        with suppress(OSError):
            begun = path.with_name(f".{SEEN}.{os.getpid()}")
            begun.write_text(f"{self.list.number}\n")
            begun.replace(path)


def opened_folder(folder: Path) -> SiteFolder:
    """Folder of a member, as it is now. Raises SecurityError."""
    return SiteFolder(folder, datetime.now(UTC))
