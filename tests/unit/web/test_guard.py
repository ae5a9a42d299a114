"""Requests are answered at a bounded rate, and by the names of the page only."""

from __future__ import annotations

from rtkit.web.guard import MOST_A_SECOND, Pace, WebGuard


def test_requests_beyond_the_rate_are_refused_until_time_has_passed() -> None:
    now = [0.0]
    pace = Pace(lambda: now[0])
    assert sum(pace.admits() for _ in range(3 * MOST_A_SECOND)) == 2 * MOST_A_SECOND
    now[0] = 0.5
    assert sum(pace.admits() for _ in range(MOST_A_SECOND)) == MOST_A_SECOND // 2
    now[0] = 60.0
    assert sum(pace.admits() for _ in range(3 * MOST_A_SECOND)) == 2 * MOST_A_SECOND


def test_a_form_of_another_site_is_refused_before_its_secret_counts() -> None:
    guard = WebGuard("secret", frozenset({"127.0.0.1"}))
    sent = {"host": "127.0.0.1:80", "authorization": "Bearer secret"}
    assert guard.refusal("POST", "/api/do", {**sent, "content-type": "application/json"}) is None
    for more in (
        {"content-type": "text/plain"},
        {"content-type": "multipart/form-data"},
        {"content-type": "application/json", "origin": "null"},
        {"content-type": "application/json", "origin": "https://127.0.0.1:80"},
        {"content-type": "application/json", "sec-fetch-site": "cross-site"},
    ):
        assert guard.refusal("POST", "/api/do", sent | more) is not None
