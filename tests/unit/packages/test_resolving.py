"""What pip has chosen."""

from rtkit.packages.resolving import Chosen


def test_an_escaped_slash_leads_nowhere_else() -> None:
    assert Chosen("a", "1", "file:///r/a-1-py3-none-..%2F..%2Fx.whl", "").file == "x.whl"
