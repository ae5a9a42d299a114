"""Signs packages and bundles with the key of an operator, and checks who signed one.

What is signed is the SHA-256 of the RECORD of a wheel, which has that of every file in it, or of
``bundle.json``. The signature is a compact JWS (RFC 7515) by ES256, the certificate in ``x5c``. In
a wheel it is ``RECORD.jws``, the one place that wheels have for it, and which RECORD leaves out.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import tempfile
import zipfile
from collections.abc import Sequence
from datetime import UTC, datetime
from hashlib import sha256
from typing import Any

from rtkit.errors import Refused, RtkitError
from rtkit.packages.wheel import SIGNATURE, Wheel, read_wheel

VARIABLE = "RTKIT_SIGNED"
WHEEL, BUNDLE = "rtkit-wheel", "rtkit-bundle"
_LARGEST = 1 << 14


def are_required() -> bool:
    """Return whether the settings have only what is signed installed."""
    return os.environ.get(VARIABLE, "") not in ("", "0")


def signed(data: bytes, type: str) -> str:
    """Return the signature of this user below data.

    Raises:
        NotFound: This user has no key.
        Refused: It is not that of an operator, or it is good no longer.
    """
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec

    from rtkit.keys import folder
    from rtkit.keys.authority import checked

    certificate = x509.load_pem_x509_certificate(folder.read(folder.CERTIFICATE))
    _check_operator(checked(certificate))
    key = serialization.load_pem_private_key(folder.read(folder.KEY), None)
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise Refused(f"not a key that rtkeys made: {folder.file(folder.KEY)}")
    shown = base64.b64encode(certificate.public_bytes(serialization.Encoding.DER)).decode()
    header = json.dumps({"alg": "ES256", "typ": type, "x5c": [shown]})
    plain = ".".join(_encoded(each) for each in (header.encode(), _payload(sha256(data).digest())))
    return f"{plain}.{_encoded(_fixed(key.sign(plain.encode(), ec.ECDSA(hashes.SHA256()))))}"


def signer(signature: bytes, digest: bytes, type: str) -> str:
    """Return who has signed what has a SHA-256: an operator of the CA that this user knows.

    Raises:
        NotFound: This user knows no CA.
        Refused: It is not what was signed, or none of the CA's operators has signed it; says why.
    """
    from cryptography import x509
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec

    from rtkit.keys.authority import checked

    try:
        plain, _, end = signature[:_LARGEST].decode("ascii").strip().rpartition(".")
        header, payload = (_decoded(each) for each in plain.split("."))
        head: Any = json.loads(header)
        (shown,) = head["x5c"]
        certificate = x509.load_der_x509_certificate(base64.b64decode(shown, validate=True))
        if (head["alg"], head["typ"]) != ("ES256", type):
            raise ValueError(f"{head['alg']} {head['typ']}")
        ended = _unfixed(_decoded(end))
        key = certificate.public_key()
    except (ValueError, KeyError, TypeError) as error:
        raise Refused(f"has no signature of rtkit: {error}") from None
    owner = checked(certificate)
    _check_operator(owner)
    try:
        assert isinstance(key, ec.EllipticCurvePublicKey)
        key.verify(ended, plain.encode(), ec.ECDSA(hashes.SHA256()))
    except (InvalidSignature, AssertionError):
        raise Refused(f"has a signature that is not of {owner.name}") from None
    if payload != _payload(digest):
        raise Refused(f"is not what {owner.name} has signed")
    return owner.name


def _check_operator(owner: Any) -> None:
    """Refuse a certificate (`Issued`) that may not sign packages."""
    from rtkit.keys.roles import includes

    if owner.revoked is not None:
        raise Refused(f"is signed by {owner.name}, whose certificate is revoked")
    if not owner.begins <= datetime.now(UTC) <= owner.ends:
        raise Refused(f"is signed by {owner.name}, whose certificate has expired")
    if not includes(owner.role, "operator"):
        raise Refused(f"is signed by {owner.name}, who is {owner.role or 'nothing'}, not operator")


def signer_of(wheel: Wheel) -> str:
    """Return who has signed a wheel that was read.

    Raises:
        Refused: Nobody, or none who may; says why.
    """
    if not wheel.signature:
        raise Refused(f"{wheel.file} is not signed (rtpkg sign signs it)")
    try:
        return signer(wheel.signature, sha256(wheel.record).digest(), WHEEL)
    except RtkitError as error:
        raise Refused(f"{wheel.file} {error}") from None


def shown_signer(wheel: Wheel) -> str | None:
    """Return who has signed a wheel, None where nobody has whom this user trusts."""
    try:
        return signer_of(wheel)
    except RtkitError:
        return None


def check(wheels: Sequence[Wheel], *, is_required: bool = False) -> None:
    """Refuse wheels that are not signed, where that or the settings require it.

    Raises:
        Refused: One is not; says why.
    """
    if is_required or are_required():
        for each in wheels:
            signer_of(each)


def sign_wheel(path: str) -> None:
    """Sign a wheel; it is replaced as a whole by the same with a signature.

    Raises:
        Refused: It is not safe, or this user may not sign.
    """
    wheel = read_wheel(path)
    signature = signed(wheel.record, WHEEL)
    folder = os.path.dirname(os.path.abspath(path))
    with tempfile.TemporaryDirectory(dir=folder, prefix=".rtpkg-") as draft:
        made = os.path.join(draft, wheel.file)
        with zipfile.ZipFile(path) as old, zipfile.ZipFile(made, "w") as new:
            info = next(i.filename for i in old.infolist() if i.filename.endswith("/RECORD"))
            for each in old.infolist():
                if each.filename != f"{info}{SIGNATURE}":
                    with old.open(each) as source, new.open(each, "w") as target:
                        shutil.copyfileobj(source, target, 1 << 20)
            new.writestr(f"{info}{SIGNATURE}", signature)
        signer_of(read_wheel(made))
        os.replace(made, path)


def _payload(digest: bytes) -> bytes:
    return json.dumps({"hash": f"sha256={_encoded(digest)}"}).encode()


def _encoded(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def _decoded(text: str) -> bytes:
    found = base64.urlsafe_b64decode(f"{text}{'=' * (-len(text) % 4)}")
    if _encoded(found) != text:
        raise ValueError("not base64url")
    return found


def _fixed(signature: bytes) -> bytes:
    """Return an ECDSA signature as JWS writes it: both numbers, 32 bytes each."""
    from cryptography.hazmat.primitives.asymmetric.utils import decode_dss_signature

    return b"".join(each.to_bytes(32, "big") for each in decode_dss_signature(signature))


def _unfixed(signature: bytes) -> bytes:
    from cryptography.hazmat.primitives.asymmetric.utils import encode_dss_signature

    if len(signature) != 64:
        raise ValueError(f"{len(signature)} bytes of signature")
    return encode_dss_signature(
        int.from_bytes(signature[:32], "big"), int.from_bytes(signature[32:], "big")
    )
