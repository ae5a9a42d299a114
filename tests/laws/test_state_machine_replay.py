"""Laws of state machines: what the log says is what a reference interpreter makes of its inputs."""

from __future__ import annotations

from typing import Any

from hypothesis import assume, given, settings
from hypothesis import strategies as st
from state_machine_reference import Reference

from rtkit.services.statemachine.expressions import Expression
from rtkit.services.statemachine.interpreter import Interpreter, MachineEvent
from rtkit.services.statemachine.model import (
    GuardedTransition,
    Machine,
    MachineAction,
    MachineState,
)
from rtkit.services.statemachine.rdf import read_machine, write_machine
from rtkit.services.statemachine.scxml import read_scxml, write_scxml

PATHS = ["a", "a.x", "a.x.u", "a.x.v", "a.y", "b", "b.x", "b.y", "c", "d"]
EVENTS = ["go", "gone", "go.far", "done.a", "done.a.x"]
small = st.integers(-2, 3)
comparisons = st.builds(
    "{} {} {}".format,
    st.sampled_from(["r.x", "l.on", "variables.n", "variables.m"]),
    st.sampled_from(["<", "<=", ">", ">=", "=", "!="]),
    small,
)
guards = st.one_of(
    comparisons,
    st.builds("not {}".format, comparisons),
    st.builds("{} {} {}".format, comparisons, st.sampled_from(["and", "or"]), comparisons),
)
actions = st.lists(
    st.one_of(
        st.tuples(st.just("set"), st.sampled_from(["r.v", "l.on"]), small.map(str)),
        st.tuples(st.just("raise"), st.sampled_from(EVENTS)),
        st.tuples(st.just("assign"), st.sampled_from("nm"), small.map(str)),
        st.builds(
            lambda name, sign: ("assign", name, "", Expression(f"variables.{name} {sign} 1")),
            st.sampled_from("nm"),
            st.sampled_from("+-"),
        ),
    ),
    max_size=2,
).map(lambda made: tuple(MachineAction(*each) for each in made))


@st.composite
def machines(draw: Any) -> Machine:
    """Any machine with two variables, three levels, no do actions."""
    chosen = draw(
        st.sampled_from([PATHS[:5], PATHS[:8], PATHS]) | st.sets(st.sampled_from(PATHS), min_size=1)
    )
    paths = [p for p in PATHS if any(c == p or c.startswith(f"{p}.") for c in chosen)]

    def inside(path: str) -> list[str]:
        return [each for each in paths if each.rpartition(".")[0] == path]

    ways = st.tuples(
        st.sampled_from([*paths, *paths, ""]),
        st.sampled_from(["go", "", *EVENTS, "*"]),
        st.sampled_from([None, None]) | guards.map(Expression),
        st.sampled_from([None, None, None, 1.0, 3.0]),
        actions,
    ).map(
        lambda way: (
            GuardedTransition(*way)
            if any(way[1:4]) and (way[0] or way[1] or way[4])
            else GuardedTransition(way[0], "go")
        )
    )
    states = {}
    for path in paths:
        initial = draw(st.sampled_from(inside(path))) if inside(path) else ""
        is_final = not initial and draw(st.integers(0, 5)) == 0
        done = () if is_final else draw(st.lists(ways, min_size=1, max_size=3).map(tuple))
        entry, leaving = ((), ()) if is_final else draw(st.tuples(actions, actions))
        states[path] = MachineState(path, initial, is_final, entry, leaving, (), done)
    return Machine("m", draw(st.sampled_from(inside(""))), states, {"n": 0, "m": 1}).check()


inputs = st.lists(
    st.one_of(
        st.tuples(st.just("event"), st.sampled_from(EVENTS)),
        st.tuples(st.just("event"), st.sampled_from(EVENTS)),
        st.tuples(st.just("value"), st.sampled_from(["r.x", "l.on"]), st.none() | small),
        st.tuples(st.just("assign"), st.sampled_from("nm"), small),
        st.tuples(st.just("wait"), st.integers(0, 3)),
        st.tuples(st.just("run"), st.sampled_from(["start", "stop", "pause", "step", "step"])),
        st.tuples(st.just("edit"), machines(), st.sampled_from(PATHS)),
    ),
    min_size=3,
    max_size=30,
)


def fed(interpreter: Interpreter, asked: list[Any]) -> int:
    """Feed inputs; return how many events the machine was to take."""
    now, count = 1.0, 0
    interpreter.command("start", now)
    for kind, *args in asked:
        now += args[0] if kind == "wait" else 0
        try:
            if kind in ("event", "value"):
                count += interpreter.run in ("running", "paused")
                value = args[1] if kind == "value" else None
                interpreter.take(MachineEvent(args[0], value, kind == "value"), now)
            elif kind == "assign":
                interpreter.assign(*args, now)
            elif kind == "wait":
                interpreter.tick(now)
            elif kind == "run":
                interpreter.command(args[0], now)
            else:
                interpreter.edit(args[0], now, args[1])
        except ValueError:
            continue  # refused: then nothing may have happened, as the replay shows
    return count


@settings(max_examples=120)
@given(machines(), inputs)
def test_the_log_replayed_gives_what_the_machine_did(machine: Machine, asked: list[Any]) -> None:
    interpreter = Interpreter(machine, 1_000_000, logs_all=True)
    fed(interpreter, asked)
    assume(not any(each.text.startswith("paused:") for each in interpreter.log))
    reference = Reference(machine)
    reference.replay(list(interpreter.log))
    logged = [
        (e.kind, e.text) for e in interpreter.log if e.kind in ("transition", "set", "assign")
    ]
    assert reference.outputs == logged
    assert (reference.leaf, reference.variables) == (interpreter.state, interpreter.variables)
    assert [each.number for each in interpreter.log] == [*range(1, len(interpreter.log) + 1)]


@settings(max_examples=60)
@given(machines(), inputs)
def test_no_event_is_lost_while_it_is_edited_paused_and_stepped(
    machine: Machine, asked: list[Any]
) -> None:
    interpreter = Interpreter(machine, 1_000_000, logs_all=True)
    count = fed(interpreter, [each for each in asked if each[1:] != ("stop",)])
    if interpreter.run == "paused":
        interpreter.command("start", 1e6)
    assume(interpreter.run == "running")
    assume(not any(each.text in ("done", "start") for each in list(interpreter.log)[1:]))
    taken = sum(each.kind in ("event", "value") for each in interpreter.log)
    assert taken == count


@settings(max_examples=40)
@given(machines())
def test_a_machine_is_read_as_it_was_written(machine: Machine) -> None:
    read = read_machine(write_machine(machine))
    assert (read, machine.difference(read)) == (machine, "nothing")


@settings(max_examples=40)
@given(machines(), st.sampled_from(["d", "e", "b.new", "a"]))
def test_a_state_with_all_inside_it_can_be_put_elsewhere(machine: Machine, at: str) -> None:
    assume("b" in machine.states and "a" in machine.states)
    text = write_machine(machine, "a")
    made = read_machine(text, machine, at)
    moved = {p.replace("a", at, 1): s for p, s in machine.states.items() if p[0] == "a"}
    assert {p for p in made.states if p == at or p.startswith(f"{at}.")} == set(moved)

    def event(name: str) -> str:
        ended = name.removeprefix("done.")
        inside = ended != name and ended in machine.states and ended[0] == "a"
        return f"done.{ended.replace('a', at, 1)}" if inside else name

    for path, state in moved.items():
        entered = [each.target for each in made.states[path].entry]
        assert entered == [event(each.target) for each in state.entry]
        heard = [each.on for each in made.states[path].transitions]
        assert heard == [event(each.on) for each in state.transitions]
        went = [e.to.replace("a", at, 1) if e.to[:1] == "a" else e.to for e in state.transitions]
        assert [each.to for each in made.states[path].transitions] == went


@settings(max_examples=40)
@given(machines())
def test_what_scxml_can_say_is_read_back(machine: Machine) -> None:
    states = {
        path: state._replace(
            transitions=tuple(
                each._replace(on="", when=None) if each.after else each
                for each in state.transitions
                if each.to or each.actions or not each.after
            )
        )
        for path, state in machine.states.items()
    }
    plain = machine._replace(states=states)
    again = read_scxml(write_scxml(plain))
    assert again.states.keys() == plain.states.keys()
    assert write_scxml(again) == write_scxml(plain)
