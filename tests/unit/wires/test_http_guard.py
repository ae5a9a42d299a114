"""The guard of the HTTP endpoint: nonces."""

from __future__ import annotations

import re

from rtkit.link.secret import Secret
from rtkit.wires.http import digest
from rtkit.wires.http.guard import Guard

SECRET = Secret("me", "it")
NOW_S = 12.5


def nonce_of(guard: Guard) -> str:
    found = re.search('nonce="(.*?)"', guard.check("GET", "/", None, NOW_S).challenge)
    assert found
    return found[1]


def test_two_who_ask_at_the_same_time_prove_with_nonces_of_their_own() -> None:
    guard = Guard(SECRET)
    for nonce in [nonce_of(guard) for _ in range(3)]:
        proof = digest.authorization(SECRET, "GET", "/", nonce, 1, "own")
        assert guard.check("GET", "/", proof, NOW_S).identity == "me"
        assert "stale=true" in guard.check("GET", "/", proof, NOW_S).challenge


def test_a_nonce_grows_old() -> None:
    guard = Guard(SECRET)
    proof = digest.authorization(SECRET, "GET", "/", nonce_of(guard), 1, "own")
    assert "stale=true" in guard.check("GET", "/", proof, NOW_S + 301).challenge
