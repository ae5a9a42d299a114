"""What is reserved of a host once a system is up; whom it is refused."""

from __future__ import annotations

import pytest

from rtkit.deployment.actions import Create
from rtkit.deployment.limits import NO_LIMITS, SlaveLimits, reserved
from rtkit.deployment.wanted import wanted
from rtkit.errors import Malformed

MIB = 1 << 20
LIMIT = "rtkit.limit.memory"


def test_what_a_system_says_outranks_what_lives_and_the_rest_counts_too(make, world) -> None:
    for name, more in (("Sink0", "1G"), ("Other", "10M"), ("Sink1", "20M")):
        world.perform(Create(f"Sink?instance_name={name}&manager_name=s&{LIMIT}={more}"))
    create = {"rtkit.create": "Sink?manager_name=s"}
    system = wanted(
        make.profile(
            make.component("Sink0", properties={**create, LIMIT: "100M"}),
            make.component("Sink1", properties=create),
            make.component("Sink2", properties={"rtkit.create": f"Sink?manager_name=t&{LIMIT}=1M"}),
        ),
        "box",
    )
    living = world.snapshot().components
    assert reserved(system, living, {"m2": [living[1]]}) == {
        "Sink0": SlaveLimits(memory=100 * MIB),
        "Other": SlaveLimits(memory=10 * MIB),
        "Sink1": NO_LIMITS,  # its create string is stated, and says none
        "Sink2": SlaveLimits(memory=MIB),
        "Other in m2": SlaveLimits(memory=10 * MIB),
    }


@pytest.mark.parametrize(
    ("own", "why"),
    [
        ({"rtkit.create": "Sink", LIMIT: "1G"}, "Sink0 has limits, and only a slave can be"),
        ({"rtkit.create": f"Sink?{LIMIT}=1G"}, "Sink0 has limits, and only a slave can be"),
        ({"rtkit.create": "Sink?manager_name=s", LIMIT: "much"}, "not an amount of memory"),
        ({"rtkit.create": "Sink?manager_name=s", f"{LIMIT}y": "1G"}, "unknown limit"),
    ],
)
def test_a_system_whose_limits_nothing_could_hold_is_refused(make, own, why) -> None:
    with pytest.raises(Malformed, match=why):
        wanted(make.profile(make.component("Sink0", properties=own)), "box")
