"""Private certification authority: makes keys with certificates, and revokes them.

It lies in the folder of keys of one user. A certificate names its owner (common name), the role
(``rtkit:role:ROLE``, an alternative name of the kind URI), and the hosts that it may stand for.
"""

from __future__ import annotations

import contextlib
import fcntl
import ipaddress
import os
import re
import shutil
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta
from typing import NamedTuple

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.keys import folder
from rtkit.keys.roles import ROLE_PREFIX, role_of
from rtkit.rtc.nearest import did_you_mean

CA_DAYS = 3650
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._\-]{0,62}")
_TAKEN = re.compile(r"nobody|user|owner|(uid|rtkit)-.*")
_SKEW = timedelta(minutes=5)
"""How far the clock of another host may be behind when it gets a certificate."""


class Issued(NamedTuple):
    """A certificate that was issued; times are UTC.

    Attributes:
        hosts: Names and addresses that its owner may be a server at.
        revoked: When it was revoked, None if it was not.
    """

    name: str
    role: str
    serial: str
    begins: datetime
    ends: datetime
    hosts: tuple[str, ...]
    revoked: datetime | None = None


def init(name: str, hosts: Sequence[str] = (), days: int = CA_DAYS) -> None:
    """Make the CA, and a certificate of this user with the role administrator.

    Raises:
        Refused: There is one already, or the folder is open to others.
        Malformed: It is no name, or no host.
    """
    _check(name, hosts)
    place = folder.path()
    folder.make(place)
    with _locked():
        for each in (folder.CA_KEY, folder.CA_CERTIFICATE, folder.KEY):
            if os.path.lexists(folder.file(each)):
                raise Refused(f"keys are there already, and never overwritten: {place}")
        key = ec.generate_private_key(ec.SECP256R1())
        subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"rtkit CA of {name}")])
        usage = _usage(signs=True)
        certificate = (
            _builder(subject, subject, key.public_key(), days)
            .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            .add_extension(usage, critical=True)
            .add_extension(_own_id(key.public_key()), critical=False)
            .sign(key, hashes.SHA256())
        )
        folder.make(folder.file(folder.ISSUED))
        # The key of the CA comes last but one: with it the folder counts as made.
        _write_revoked(certificate, key, [])
        folder.write(folder.file(folder.CA_CERTIFICATE), _pem(certificate), is_new=False)
        folder.write(folder.file(folder.CA_KEY), _pem_of_key(key))
        data, secret = _issue(certificate, key, name, "administrator", hosts, days)
        folder.write(folder.file(folder.CERTIFICATE), data, is_new=False)
        folder.write(folder.file(folder.KEY), secret)


def issue(name: str, role: str, hosts: Sequence[str], days: int, output: str) -> Issued:
    """Make a key with a certificate, in a new folder that is to be handed over.

    Raises:
        NotFound: There is no CA here.
        Refused: The folder is there; somebody of that name has another role.
        Malformed: It is no name, or no host.
    """
    _check(name, hosts)
    if os.path.lexists(output):
        raise Refused(f"is there already, and never overwritten: {output}")
    if not os.path.isdir(above := os.path.dirname(os.path.abspath(output))):
        raise NotFound(f"no such folder: {above}")
    with _locked():
        certificate, key = _authority()
        now = datetime.now(UTC)
        for each in issued():
            if each.name == name and each.role != role and not each.revoked and each.ends > now:
                raise Refused(f"{name} is {each.role} (rtkeys revoke {name} ends that)")
        ends = certificate.not_valid_after_utc
        if now + timedelta(days=days) > ends:
            raise Refused(f"the CA itself ends before that, at {ends:%Y-%m-%d}")
        data, secret = _issue(certificate, key, name, role, hosts, days)
        draft = f"{output.rstrip('/')}.{os.getpid()}"
        os.mkdir(draft, 0o700)
        try:
            for file, content in (
                (folder.CA_CERTIFICATE, _pem(certificate)),
                (folder.REVOKED, folder.read(folder.REVOKED)),
                (folder.CERTIFICATE, data),
                (folder.KEY, secret),
            ):
                folder.write(os.path.join(draft, file), content)
            os.rename(draft, output)
        except BaseException:
            shutil.rmtree(draft)
            raise
    return _described(x509.load_pem_x509_certificate(data), {})


def revoke(which: str) -> list[Issued]:
    """Revoke the certificates of a name, or of a serial number; return those that were good.

    Raises:
        NotFound: None was issued; tells what may have been meant.
        Refused: All are revoked already.
    """
    with _locked():
        certificate, key = _authority()
        known = issued()
        found = [each for each in known if which in (each.name, each.serial)]
        if not found:
            hint = did_you_mean(which, sorted({each.name for each in known}))
            raise NotFound(f"no such certificate: {which}{hint}")
        now = [each for each in found if each.revoked is None]
        if not now:
            raise Refused(f"revoked already: {which}")
        at = datetime.now(UTC)
        entries = [
            x509.RevokedCertificateBuilder(int(each.serial, 16), each.revoked or at).build()
            for each in known
            if each in found or each.revoked is not None
        ]
        _write_revoked(certificate, key, entries)
    return [each._replace(revoked=at) for each in now]


def issued() -> list[Issued]:
    """Return what the CA of this folder has issued, by name and time.

    Raises:
        NotFound: There is no CA here.
    """
    authority = x509.load_pem_x509_certificate(folder.read(folder.CA_CERTIFICATE))
    if not os.path.lexists(folder.file(folder.CA_KEY)):
        raise NotFound(f"the CA is not here, only a certificate of it: {folder.path()}")
    gone = revoked(folder.read(folder.REVOKED), authority)
    names = sorted(os.listdir(folder.file(folder.ISSUED)))
    files = [os.path.join(folder.ISSUED, each) for each in names if each.endswith(".crt")]
    found = [_described(x509.load_pem_x509_certificate(folder.read(each)), gone) for each in files]
    return sorted(found, key=lambda each: (each.name, each.begins))


def own() -> Issued:
    """Return the certificate that this user shows.

    Raises:
        NotFound: There is none.
    """
    authority = x509.load_pem_x509_certificate(folder.read(folder.CA_CERTIFICATE))
    gone = revoked(folder.read(folder.REVOKED), authority)
    return _described(x509.load_pem_x509_certificate(folder.read(folder.CERTIFICATE)), gone)


def checked(certificate: x509.Certificate) -> Issued:
    """Return what a certificate says, that the CA of this folder has issued.

    Raises:
        NotFound: There is no certificate of a CA here.
        Refused: Another one has issued it.
    """
    authority = x509.load_pem_x509_certificate(folder.read(folder.CA_CERTIFICATE))
    gone = revoked(folder.read(folder.REVOKED), authority)
    try:
        certificate.verify_directly_issued_by(authority)
        return _described(certificate, gone)
    except (ValueError, TypeError, InvalidSignature, x509.ExtensionNotFound):
        subject = certificate.subject.rfc4514_string()
        raise Refused(f"is signed by {subject}, whom the CA here does not know") from None


def revoked(data: bytes, authority: x509.Certificate) -> dict[int, datetime]:
    """Return serial numbers and times of a list of what is revoked, signed by the CA.

    Raises:
        Refused: It cannot be read, or somebody else wrote it.
    """
    try:
        listed = x509.load_pem_x509_crl(data)
        is_ours = listed.is_signature_valid(authority.public_key())  # type: ignore[arg-type]
    except (ValueError, TypeError) as error:
        raise Refused(f"{folder.file(folder.REVOKED)}: {error}") from None
    if not is_ours:
        raise Refused(f"not signed by the CA: {folder.file(folder.REVOKED)}")
    return {each.serial_number: each.revocation_date_utc for each in listed}


def _authority() -> tuple[x509.Certificate, ec.EllipticCurvePrivateKey]:
    if not os.path.lexists(folder.file(folder.CA_KEY)):
        raise NotFound(f"no CA in {folder.path()} (rtkeys init makes one)")
    certificate = x509.load_pem_x509_certificate(folder.read(folder.CA_CERTIFICATE))
    key = serialization.load_pem_private_key(folder.read(folder.CA_KEY), None)
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise Refused(f"not the key of a CA of rtkit: {folder.file(folder.CA_KEY)}")
    return certificate, key


def _issue(
    authority: x509.Certificate,
    signer: ec.EllipticCurvePrivateKey,
    name: str,
    role: str,
    hosts: Sequence[str],
    days: int,
) -> tuple[bytes, bytes]:
    """Return a certificate and its key, and keep the first among what was issued."""
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    names = [x509.UniformResourceIdentifier(ROLE_PREFIX + role), *map(_general_name, hosts)]
    used = [ExtendedKeyUsageOID.CLIENT_AUTH]
    if hosts:
        used.append(ExtendedKeyUsageOID.SERVER_AUTH)
    public = signer.public_key()
    certificate = (
        _builder(subject, authority.subject, key.public_key(), days)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(_usage(signs=False), critical=True)
        .add_extension(x509.ExtendedKeyUsage(used), critical=False)
        .add_extension(x509.SubjectAlternativeName(names), critical=False)
        .add_extension(_own_id(key.public_key()), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(public), critical=False)
        .sign(signer, hashes.SHA256())
    )
    kept = os.path.join(folder.file(folder.ISSUED), f"{certificate.serial_number:x}.crt")
    folder.write(kept, _pem(certificate))
    return _pem(certificate), _pem_of_key(key)


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, days: int
) -> x509.CertificateBuilder:
    now = datetime.now(UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - _SKEW)
        .not_valid_after(now + timedelta(days=days))
    )


def _usage(*, signs: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=True,
        key_cert_sign=signs,
        crl_sign=signs,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        encipher_only=False,
        decipher_only=False,
    )


def _own_id(key: ec.EllipticCurvePublicKey) -> x509.SubjectKeyIdentifier:
    return x509.SubjectKeyIdentifier.from_public_key(key)


def _write_revoked(
    authority: x509.Certificate,
    key: ec.EllipticCurvePrivateKey,
    entries: list[x509.RevokedCertificate],
) -> None:
    builder = (
        x509.CertificateRevocationListBuilder()
        .issuer_name(authority.subject)
        .last_update(datetime.now(UTC) - _SKEW)
        .next_update(authority.not_valid_after_utc)
    )
    for each in entries:
        builder = builder.add_revoked_certificate(each)
    data = builder.sign(key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)
    folder.write(folder.file(folder.REVOKED), data, is_new=False)


def _described(certificate: x509.Certificate, gone: dict[int, datetime]) -> Issued:
    (name,) = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    others = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    uris = others.get_values_for_type(x509.UniformResourceIdentifier)
    addresses = map(str, others.get_values_for_type(x509.IPAddress))
    return Issued(
        str(name.value),
        role_of(uris),
        f"{certificate.serial_number:x}",
        certificate.not_valid_before_utc,
        certificate.not_valid_after_utc,
        (*others.get_values_for_type(x509.DNSName), *addresses),
        gone.get(certificate.serial_number),
    )


def _check(name: str, hosts: Sequence[str]) -> None:
    if not _NAME.fullmatch(name):
        raise Malformed(f"not a name (letters, digits, . _ -): {name[:80]!r}")
    if _TAKEN.fullmatch(name):
        raise Malformed(f"a name that users of the same host have in rules: {name}")
    for each in hosts:
        _general_name(each)


def _general_name(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        if not re.fullmatch(r"[A-Za-z0-9]([A-Za-z0-9.\-]{0,251}[A-Za-z0-9])?", host):
            raise Malformed(f"not the name or address of a host: {host[:80]!r}") from None
        return x509.DNSName(host)


@contextlib.contextmanager
def _locked() -> Iterator[None]:
    """Let one process at a time change what the CA keeps."""
    if not os.path.isdir(folder.path()):
        raise NotFound(f"no CA in {folder.path()} (rtkeys init makes one)")
    descriptor = os.open(folder.file("lock"), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _pem(certificate: x509.Certificate) -> bytes:
    return certificate.public_bytes(serialization.Encoding.PEM)


def _pem_of_key(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
