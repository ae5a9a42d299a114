"""Rows of §10 of the command reference: lines of dry runs, and reasons of failures."""

from dataclasses import replace

import pytest

from rtkit.deployment import actions as act
from rtkit.deployment.creation import creation_plan
from rtkit.deployment.layered_plan import merged
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.running import start_plan, stop_plan, teardown_plan
from rtkit.deployment.wanted import wanted
from rtkit.deployment.wiring import wiring_plan
from rtkit.errors import Malformed, NotFound
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, Transition
from rtkit.rtc.pattern import ContextPattern
from rtkit.rtc.profiles import ExecutionContextProfile

OPTIONS = (
    "{'dataport.data_type': 'IDL:RTC/TimedLong:1.0', 'dataport.interface_type': 'corba_cdr',"
    " 'dataport.dataflow_type': 'push', 'dataport.subscription_type': 'new'}"
)


def bring_up(make, world, profile):
    system, live = make.live(profile, world)
    for plan in (creation_plan(system, live), None):
        plan = plan or wiring_plan(system, LiveIndex(world.snapshot(), system))
        assert not any(check.failure for check in plan.checks)
        for action, _ in merged(plan.steps):
            assert world.perform(action).ok, action
    return system


def failures(plan):
    return [check.failure for check in plan.checks if check.failure]


def blocked(plan):
    return [step.blocked for step in plan.steps if step.blocked]


def test_dry_run_of_a_resurrection(make, world):
    system, live = make.live(make.pair(), world)
    creation = creation_plan(system, live)
    lines = [*creation.lines(), *wiring_plan(system, live, creation.made).lines()]
    source, sink = "/localhost/Source0.rtc", "/localhost/Sink0.rtc"
    assert lines == [
        'Check for required component "RTC:Me:test:Source:1.0", "Source0"'
        f" at path {source} (Required)",
        f'Check for required component "RTC:Me:test:Sink:1.0", "Sink0" at path {sink} (Required)',
        f'Check for required port "out" on component at path {source} (Required)',
        f'Check for required port "in" on component at path {sink} (Required)',
        f'Create component "RTC:Me:test:Source:1.0", "Source0" at path {source}'
        " in slave slaveSource0 (Required)",
        f'Create component "RTC:Me:test:Sink:1.0", "Sink0" at path {sink}'
        " in slave slaveSink0 (Required)",
        f"Connect {source}:out to {sink}:in with ID wire and properties {OPTIONS} (Required)",
        *(
            f'Set parameter "{name}" in set "{set_id}" on component at path {path} to "{value}"'
            for path in (source, sink)
            for set_id, name, value in (
                ("default", "gain", "2"),
                ("default", "mode", "a"),
                ("fast", "gain", "9"),
            )
        ),
        f"Set rate of execution context 0 on component at path {source} to 1000",
        f"Set rate of execution context 0 on component at path {sink} to 1000",
        f'Set configuration set "fast" active on component at path {source}',
        f'Set configuration set "fast" active on component at path {sink}',
    ]


def test_optional_components_are_not_checked(make, world):
    system, live = make.live(make.pair(required=False), world)
    plan = creation_plan(system, live)
    assert not plan.checks
    assert not any(line.endswith("(Required)") for line in plan.lines())


def test_what_holds_is_not_done_again(make, world):
    system = bring_up(make, world, make.pair())
    live = LiveIndex(world.snapshot(), system)
    assert creation_plan(system, live).steps == ()
    plan = wiring_plan(system, live)
    assert plan.is_done
    assert all(step.holds for step in plan.steps)
    assert len(list(plan.lines())) == 9


def test_only_what_differs_is_done(make, world):
    system = bring_up(make, world, make.pair())
    world.perform(act.SetParameters("Sink0", "default", {"gain": "5", "mode": "z"}))
    world.perform(act.ActivateSet("Source0", "default"))
    world.perform(act.Disconnect("wire"))
    plan = wiring_plan(system, LiveIndex(world.snapshot(), system))
    assert [action for action, _ in merged(plan.steps)] == [
        act.Connect(system.connectors[0].profile),
        act.SetParameters("Sink0", "default", {"gain": "2", "mode": "a"}),
        act.ActivateSet("Source0", "fast"),
    ]


def test_without_creation_components_must_be_there(make, world):
    system, live = make.live(make.pair(), world)
    plan = creation_plan(system, live, may_create=False)
    assert plan.steps == ()
    assert failures(plan) == [
        "Required component missing: /localhost/Source0.rtc",
        "Required component missing: /localhost/Sink0.rtc",
    ]


def test_a_required_port_that_is_missing(make, world):
    bring_up(make, world, make.pair())
    ports = world.components["Sink0"].ports
    world.update("Sink0", ports=tuple(port for port in ports if port.name != "in"))
    system, live = make.live(make.pair(), world)
    told = "Required port not found: in (on /localhost/Sink0.rtc)"
    assert failures(creation_plan(system, live, may_create=False)) == [told]


def test_what_nobody_can_make_is_missing(make, world):
    system, live = make.live(make.profile(make.component("Sink0")), world)
    assert failures(creation_plan(system, live)) == [
        "Required component missing: /localhost/Sink0.rtc"
        " (nothing tells how to make it; --stand-in generates it)"
    ]


def test_identity_is_compared(make, world):
    world.perform(act.Create("Sink?instance_name=Sink0"))
    system, live = make.live(make.profile(make.component("Sink0", id="RTC:X:test:Sink:1.0")), world)
    assert failures(creation_plan(system, live)) == [
        "ID of component at /localhost/Sink0.rtc is RTC:Me:test:Sink:1.0, not RTC:X:test:Sink:1.0"
    ]


def test_instance_names_are_compared(make, world):
    world.perform(act.Create("Sink?instance_name=Other", ("localhost/Sink0.rtc",)))
    system, live = make.live(make.profile(make.component("Sink0")), world)
    assert failures(creation_plan(system, live)) == [
        "Instance name of component at /localhost/Sink0.rtc is Other, not Sink0"
    ]


def test_one_that_lives_elsewhere_is_not_made_again(make, world):
    world.perform(act.Create("Sink?instance_name=Sink0", ("localhost/dir/Sink0.rtc",)))
    own = make.component("Sink0", properties={"rtkit.create": "Sink"})
    system, live = make.live(make.profile(own), world)
    plan = creation_plan(system, live)
    assert plan.steps == ()
    assert failures(plan) == [
        "Required component missing: /localhost/Sink0.rtc (Sink0 is at /localhost/dir/Sink0.rtc)"
    ]


def test_paths_below_a_manager_are_found(make, world):
    world.perform(act.Create("Sink?instance_name=Sink0&manager_name=s"))
    for uri in ("localhost/manager.mgr/Sink0.rtc", "localhost/manager.mgr/s.mgr/Sink0.rtc"):
        system, live = make.live(make.profile(make.component("Sink0", uri=uri)), world)
        assert not failures(creation_plan(system, live))
    for uri in ("localhost/other.mgr/Sink0.rtc", "localhost/x/Sink0.rtc", "far/s.mgr/Sink0.rtc"):
        system, live = make.live(make.profile(make.component("Sink0", uri=uri)), world)
        assert failures(creation_plan(system, live))


def test_a_zombie_elsewhere_is_told_where_it_is(make, world):
    system = bring_up(make, world, make.pair())
    world.kill("slaveSink0")
    found = world.snapshot()
    elsewhere = tuple(
        replace(c, names=("localhost/x/Sink0.rtc",)) if c.instance == "Sink0" else c
        for c in found.components
    )
    live = LiveIndex(replace(found, components=elsewhere), system)
    told = failures(creation_plan(system, live, may_create=False))[0]
    path = "/localhost/Sink0.rtc"
    assert told == (
        f"Required component missing: {path} (zombie in manager {found.manager}: signal 9)"
    )


def test_a_zombie_is_made_again(make, world):
    system = bring_up(make, world, make.pair())
    world.kill("slaveSink0")
    live = LiveIndex(world.snapshot(), system)
    assert failures(creation_plan(system, live, may_create=False))[0] == (
        "Required component missing: /localhost/Sink0.rtc (zombie: signal 9)"
    )
    plan = creation_plan(system, live)
    assert not failures(plan)
    assert [step.action for step in plan.steps] == [
        act.Create("Sink?manager_name=slaveSink0&instance_name=Sink0", ("localhost/Sink0.rtc",))
    ]


def test_a_zombie_tells_how_it_was_made_when_the_profile_does_not(make, world):
    world.perform(act.Create("Sink?manager_name=s&instance_name=Sink0&x=y"))
    world.kill("s")
    plan = creation_plan(*make.live(make.profile(make.component("Sink0")), world))
    assert not failures(plan)
    (step,) = plan.steps
    assert step.action.create == "Sink?manager_name=s&instance_name=Sink0&x=y"
    assert step.text.endswith("in slave s")


def test_unknown_hosts_are_errors_of_what_would_be_made_only(make, world):
    own = make.component("Sink0", uri="10.0.0.9/Sink0.rtc", properties={"rtkit.create": "Sink"})
    system, live = make.live(make.profile(own), world)
    with pytest.raises(NotFound, match=r"no such host: 10\.0\.0\.9 \(component Sink0\)"):
        creation_plan(system, live)
    world.perform(act.Create("Sink?instance_name=Sink0", ("10.0.0.9/Sink0.rtc",)))
    assert not failures(creation_plan(system, LiveIndex(world.snapshot(), system)))


def test_names_that_none_may_bear_are_found_before_anything_is_made(make, world):
    bad = make.component("Si:nk", properties={"rtkit.create": "Sink"})
    with pytest.raises(Malformed, match="characters that are not allowed"):
        creation_plan(*make.live(make.profile(bad), world))


def test_modules_are_loaded_once_and_first(make, world):
    told = {"rtkit.create": "Sink", "rtkit.module": "a/sink.py:init"}
    parts = [make.component(f"Sink{n}", properties=told, required=n == 1) for n in range(2)]
    system, live = make.live(make.profile(*parts), world)
    plan = creation_plan(system, live)
    assert [layer.name for layer in plan.layers] == ["load", "create"]
    assert plan.steps[0].action == act.Load("a/sink.py", "init")
    assert plan.steps[0].line == 'Load module "a/sink.py:init" (Required)'
    assert plan.made == {"Sink0", "Sink1"}


def test_connections_of_what_is_not_there(make, world):
    profile = make.profile(
        make.component("Source0", required=False),
        make.component("Sink0", required=False),
        make.data("w", "Source0.out", "Sink0.in"),
        make.data("v", "Source0.other", "Sink0.in"),
    )
    system, live = make.live(profile, world)
    assert blocked(wiring_plan(system, live))[0] == (
        "Source component missing: /localhost/Source0.rtc"
    )
    world.perform(act.Create("Source?instance_name=Source0"))
    live = LiveIndex(world.snapshot(), system)
    assert blocked(wiring_plan(system, live)) == [
        "Destination component missing: /localhost/Sink0.rtc",
        "Source port missing: /localhost/Source0.rtc:other",
    ]
    world.perform(act.Create("Sink?instance_name=Sink0", ("localhost/Sink0.rtc",)))
    assert blocked(wiring_plan(system, LiveIndex(world.snapshot(), system))) == [
        "Source port missing: /localhost/Source0.rtc:other"
    ]


def test_unknown_parameters_and_sets(make, world):
    world.perform(act.Create("Sink?instance_name=Sink0"))
    sets = {"default": {"no": "1"}, "nowhere": {"none": "1"}, "__widget__": {"gain": "text"}}
    system, live = make.live(make.profile(make.component("Sink0", sets=sets)), world)
    plan = wiring_plan(system, live)
    assert blocked(plan) == [
        "No such configuration parameter: no (on /localhost/Sink0.rtc)",
        "No such configuration parameter: none (on /localhost/Sink0.rtc)",
    ]
    assert plan.steps[2].holds


def test_a_set_that_a_component_has_not_is_added(make, world):
    world.perform(act.Create("Sink?instance_name=Sink0"))
    sets = {"default": {"gain": "1"}, "race": {"gain": "7"}}
    system, live = make.live(make.profile(make.component("Sink0", sets=sets)), world)
    todo = [step.action for step in wiring_plan(system, live).steps if step.action]
    wanted = act.SetParameters("Sink0", "race", {"gain": "7"}, act.MISSING)
    assert todo[-1] == wanted
    assert world.perform(wanted).ok
    assert all(
        step.holds for step in wiring_plan(system, LiveIndex(world.snapshot(), system)).steps[1:]
    )


def test_start_goes_in_the_order_of_the_profile(make, world):
    two = (("0", "PERIODIC", 10.0), ("1", "PERIODIC", 10.0))
    profile = make.profile(
        make.component("Source0"), make.component("Sink0", required=False, contexts=two)
    )
    for name in ("Source0", "Sink0"):
        world.perform(act.Create(f"{name[:-1]}?instance_name={name}"))
    plan = start_plan(*make.live(profile, world))
    assert [*plan.lines()][1:] == [
        "{1} Activate /localhost/Source0.rtc in execution context 0 (Required)",
        "{2} Activate /localhost/Sink0.rtc in execution context 0",
        "{3} Activate /localhost/Sink0.rtc in execution context 1",
    ]
    assert plan.steps[0].action == act.ChangeState("Source0", "0", Transition.ACTIVATE)
    assert plan.steps[2].blocked == (
        "No execution context 1 on component at path /localhost/Sink0.rtc"
    )


def test_a_context_is_found_by_id_else_by_number(make, world):
    named = make.component("Sink0", contexts=(("Ec1", "PERIODIC", 10.0),))
    world.perform(act.Create("Sink?instance_name=Sink0"))
    plan = start_plan(*make.live(make.profile(named), world), wait=False)
    assert plan.steps[0].action == act.ChangeState("Sink0", "0", Transition.ACTIVATE, wait=False)
    assert plan.steps[0].text.endswith("in execution context Ec1")


def test_no_two_contexts_of_a_profile_mean_the_same_live_one(make, world):
    live = tuple(ContextPattern(id) for id in ("0", "1"))
    world.types["Sink"] = replace(world.types["Sink"], contexts=live)
    world.perform(act.Create("Sink?instance_name=Sink0"))
    other = ExecutionContextProfile("Other/0", ExecutionKind.PERIODIC, 1.0, "Other")
    world.update("Sink0", contexts=(*world.components["Sink0"].contexts, other))

    def meant(*ids):
        contexts = tuple((id, "PERIODIC", 10.0) for id in ids)
        profile = make.profile(make.component("Sink0", contexts=contexts))
        plan = start_plan(*make.live(profile, world))
        return [step.action and step.action.context for step in plan.steps]

    assert meant("Ec1", "0") == ["1", "0"]
    assert meant("1", "Ec1") == ["1", "0"]
    assert meant("Ec1", "Ec2", "Ec3") == ["0", "1", None]
    assert meant("Ec1", "Other/0") == ["0", "Other/0"]


def test_stop_goes_backwards_and_needs_nothing(make, world):
    profile = make.profile(make.component("Source0"), make.component("Sink0"))
    world.perform(act.Create("Source?instance_name=Source0"))
    plan = stop_plan(*make.live(profile, world))
    assert [*plan.lines()] == [
        "{1} Deactivate /localhost/Sink0.rtc in execution context 0",
        "{2} Deactivate /localhost/Source0.rtc in execution context 0",
    ]
    assert blocked(plan) == ["Component missing: /localhost/Sink0.rtc"]


def test_start_needs_required_components(make, world):
    plan = start_plan(*make.live(make.profile(make.component("Sink0")), world))
    assert failures(plan) == ["Required component missing: /localhost/Sink0.rtc"]


def test_teardown_disconnects_by_id_and_ends_in_reverse(make, world):
    system = bring_up(make, world, make.pair())
    plan = teardown_plan(system, LiveIndex(world.snapshot(), system), ends_components=True)
    assert [*plan.lines()] == [
        "Disconnect /localhost/Source0.rtc:out from /localhost/Sink0.rtc:in with ID wire",
        'Exit component "RTC:Me:test:Sink:1.0", "Sink0" at path /localhost/Sink0.rtc',
        'Exit component "RTC:Me:test:Source:1.0", "Source0" at path /localhost/Source0.rtc',
    ]
    assert [step.action for step in plan.steps] == [
        act.Disconnect("wire"),
        act.Delete("Sink0"),
        act.Delete("Source0"),
    ]


def test_teardown_tells_what_is_missing(make, world):
    system, live = make.live(make.pair(), world)
    assert blocked(teardown_plan(system, live)) == [
        "Source component missing: /localhost/Source0.rtc"
    ]
    bring_up(make, world, make.pair())
    world.perform(act.Disconnect("wire"))
    live = LiveIndex(world.snapshot(), system)
    assert blocked(teardown_plan(system, live)) == [
        "No connection from /localhost/Source0.rtc:out with ID wire"
    ]


def test_what_is_gone_already_is_as_wanted_where_the_components_end(make, world):
    system, live = make.live(make.pair(), world)
    assert teardown_plan(system, live, ends_components=True).is_done
    bring_up(make, world, make.pair())
    world.perform(act.Disconnect("wire"))
    world.perform(act.Delete("Sink0"))
    plan = teardown_plan(system, LiveIndex(world.snapshot(), system), ends_components=True)
    assert blocked(plan) == []
    assert [step.action for step in plan.steps if step.action] == [act.Delete("Source0")]


def test_teardown_ends_zombies_but_no_strangers(make, world):
    system = bring_up(make, world, make.pair())
    world.kill("slaveSink0")
    live = LiveIndex(world.snapshot(), system)
    assert act.Delete("Sink0") in [
        step.action for step in teardown_plan(system, live, ends_components=True).steps
    ]
    stranger = make.profile(make.component("Source0", id="RTC:X:test:Source:1.0"))
    plan = teardown_plan(*make.live(stranger, world), ends_components=True)
    assert plan.is_done
    assert blocked(plan)[0].startswith("ID of component at /localhost/Source0.rtc is")


def test_state_does_not_matter_to_a_plan(make, world):
    system = bring_up(make, world, make.pair())
    world.set_state("Sink0", LifeCycleState.ERROR)
    assert wiring_plan(system, LiveIndex(world.snapshot(), system)).is_done
    assert wanted(make.pair(), world.host) == system
