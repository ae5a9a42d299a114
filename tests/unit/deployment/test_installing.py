"""Steps that install: done before anything is touched, taken back, gone on with after a kill."""

from __future__ import annotations

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.deployment.applying import Applier
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.packages import Packages
from rtkit.deployment.wanted import wanted
from rtkit.errors import NotFound, Refused
from rtkit.fast_dataclass import replace
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.rtc.enums import PortType
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile

PORTS = (PortProfile("out", PortType.OUT),)
MODULES = {
    f"/m/{name}.py": [ComponentPattern(TypeProfile(name), PORTS, {"default": {"k": "0"}})]
    for name in ("One", "Two")
}


class Shop:
    """Has packages, and installs them unless one `fails`."""

    def __init__(self, fails: str = "", kills: int = -1) -> None:
        self.there: set[str] = set()
        self.fails = fails
        self.left = kills

    def install(self, package: str) -> None:
        if self.left == 0:
            raise KeyboardInterrupt
        self.left -= 1
        if package == self.fails:
            raise NotFound("no repository has it")
        self.there.add(package)

    def uninstall(self, package: str) -> None:
        self.there.remove(package)


def told(name: str) -> rts.ComponentInstance:
    values = {"create": f"{name}?instance_name={name}0", "module": f"/m/{name}.py:{name}Init"}
    properties = tuple(ExtensionProperty(f"rtkit.{key}", value) for key, value in values.items())
    return rts.ComponentInstance(
        f"RTC:::{name}:", f"localhost/{name}0.rtc", f"{name}0", properties=properties
    )


def goal_of(shop: Shop) -> DeploymentGoal:
    components = (told("One"), told("Two"))
    profile = rts.RtsProfile("RTSystem:a:b:1", "0.2", "", "", components=components)
    of = {"One0": "one==1", "Two0": "two==1"}
    packages = Packages(of, frozenset(shop.there), installer=shop)
    return replace(DeploymentGoal(wanted(profile, "box")), packages=packages)


def apply(world: FakeManager, shop: Shop, *, rolls_back: bool = False) -> list[str]:
    tree, goal, done = fake_tree(world), goal_of(shop), []
    before = tree.snapshot()
    Applier(tree, goal, lambda _: None, done.append).run(
        goal.plan(before), before, rolls_back=rolls_back
    )
    return done


def test_packages_are_installed_before_anything_else() -> None:
    world, shop = FakeManager([], modules=MODULES), Shop()
    done = apply(world, shop)
    assert [step.partition(" ")[2] for step in done[:2]] == [
        "install one==1 on localhost",
        "install two==1 on localhost",
    ]
    assert shop.there == {"localhost/one==1", "localhost/two==1"}
    assert sorted(world.components) == ["One0", "Two0"]
    assert apply(world, shop) == []


def test_a_package_that_cannot_be_installed_leaves_all_that_lives_untouched() -> None:
    world, shop = FakeManager([], modules=MODULES), Shop(fails="localhost/two==1")
    with pytest.raises(NotFound, match="install two==1 on localhost: no repository has it"):
        apply(world, shop)
    assert not world.components
    assert shop.there == {"localhost/one==1"}


def test_the_way_back_removes_what_was_installed_on_the_way() -> None:
    world, shop = FakeManager([], modules=MODULES), Shop(fails="localhost/two==1")
    with pytest.raises(NotFound, match="everything is as it was before"):
        apply(world, shop, rolls_back=True)
    assert shop.there == set()
    broken = {"/m/One.py": MODULES["/m/One.py"]}
    world, shop = FakeManager([], modules=broken), Shop()
    with pytest.raises(Refused, match="everything is as it was before"):
        apply(world, shop, rolls_back=True)
    assert (shop.there, list(world.components)) == (set(), [])


def test_what_was_there_before_stays_on_the_way_back() -> None:
    world, shop = FakeManager([], modules=MODULES), Shop(fails="localhost/two==1")
    shop.there.add("localhost/one==1")
    with pytest.raises(NotFound, match="everything is as it was before"):
        apply(world, shop, rolls_back=True)
    assert shop.there == {"localhost/one==1"}


@pytest.mark.parametrize("kills", range(3))
def test_interrupted_at_each_step_it_goes_on(kills: int) -> None:
    world, shop = FakeManager([], modules=MODULES), Shop(kills=kills)
    if kills < 2:
        with pytest.raises(KeyboardInterrupt, match="left; run it again to go on"):
            apply(world, shop)
    shop.left = -1
    apply(world, shop)
    assert sorted(world.components) == ["One0", "Two0"]
