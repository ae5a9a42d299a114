"""Configuration values of a component as keys of a model: wanted, kept, checked for validity."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rtkit.component.configuration.constraint_check import (
    Declared,
    misfit,
    misfit_of,
    no_parameter,
    parameter_names,
)
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.planning.component_settings import ACTIVE_SET, DEFAULT, ComponentSetting
from rtkit.deployment.planning.model import UNKNOWN, ParameterVariable
from rtkit.deployment.system import HIDDEN, WantedComponent

Declarations = Mapping[str, Declared]
"""The parameters of a component type, by name."""


class Values:
    """The configuration of one component.

    Attributes:
        settings: Its parameters, and its active set.
        missing: Parameters and sets of the profile that it does not have, one text each.
        misfits: Values of the profile that it would not take, one text each.
    """

    def __init__(
        self,
        component: WantedComponent,
        facts: ComponentFacts | None,
        was: ComponentFacts | None,
        declared: Declarations | None,
    ) -> None:
        """Compare what is wanted with what lives.

        Args:
            component: The wanted component.
            facts: As it lives, if it does.
            was: As it lived when a plan began, if it did; who moves keeps its values.
            declared: Knowledge of its type, if it does not live.
        """
        self._component = component
        self._facts = facts
        self._declared = declared
        sets = (component.sets, was.sets if was is not None else {})
        # A set without parameters is added by none of the steps.
        self._added = {
            set_id
            for each in sets
            for set_id, values in each.items()
            if any(self._can_add(set_id, parameter) for parameter in values)
        }
        self.missing: list[str] = []
        self.misfits: list[str] = []
        now_active = facts.active_set if facts is not None else ""
        self._used = component.active_set or now_active
        self._seen = (self._used, now_active)
        # A component that lived at the beginning keeps the values that lead it from state to state.
        self._free = component.kept if was is not None and not was.zombie else frozenset()
        found = {each.parameter: each for each in self._wanted()}
        if was is not None and not was.zombie:
            kept = self._kept(was)
            found.update((each.parameter, each) for each in kept if each.parameter not in found)
        self.settings = list(found.values())
        chosen = component.active_set or (was.active_set if was is not None else "")
        if chosen:
            self._choose(chosen)

    def _wanted(self) -> Iterator[ComponentSetting]:
        component, facts = self._component, self._facts
        for set_id, values in component.sets.items():
            for parameter, value in () if set_id.startswith(HIDDEN) else values.items():
                present = facts.sets.get(set_id, {}).get(parameter) if facts is not None else None
                if self._is_missing(set_id, parameter):
                    continue
                if (set_id, parameter) in self._free:
                    continue
                why = "" if present == value else self._misfit(parameter, value)
                if why:
                    message = f"{component.path}: {set_id}.{parameter} cannot be {value!r}: {why}"
                    self.misfits.append(message)
                    continue
                is_hot = set_id not in self._seen or self._is_hot(parameter)
                default = value if component.pattern is not None else UNKNOWN
                key = ParameterVariable(default, is_hot, self._text(set_id, parameter))
                if present is None and facts is not None:
                    present = UNKNOWN
                yield ComponentSetting(f"{set_id}.{parameter}", key, value, present)

    def _is_missing(self, set_id: str, parameter: str) -> bool:
        """Note a parameter that is not there, or will not be."""
        facts = self._facts
        if facts is not None:
            there = facts.sets.get(set_id, {})
            is_missing = parameter not in there and not self._can_add(set_id, parameter)
            known: Iterable[str] = there or parameter_names(facts.sets)
        else:
            known = self._declared or ()
            is_missing = self._declared is not None and parameter not in known
        if is_missing:
            self.missing.append(no_parameter(parameter, known, self._component.path))
        return is_missing

    def _misfit(self, parameter: str, value: str) -> str:
        if self._facts is not None:
            return misfit(self._facts.sets, parameter, value)
        declared = self._declared.get(parameter) if self._declared is not None else None
        return misfit_of(declared, value) if declared is not None else ""

    def _kept(self, was: ComponentFacts) -> Iterator[ComponentSetting]:
        """Have what the profile does not name keep its value, also when the component moves."""
        facts = self._facts
        has_stayed = facts is not None and facts.process == was.process
        for set_id, values in was.sets.items():
            named = self._component.sets.get(set_id, {})
            for parameter, value in () if set_id.startswith(HIDDEN) else values.items():
                present = facts.sets.get(set_id, {}).get(parameter) if facts is not None else None
                is_wanted = parameter in named and (set_id, parameter) not in self._free
                is_lost = facts is not None and present is None
                if is_wanted or (is_lost and (has_stayed or not self._can_add(set_id, parameter))):
                    continue
                key = ParameterVariable(text=self._text(set_id, parameter))
                wanted = present if has_stayed and present is not None else value
                yield ComponentSetting(f"{set_id}.{parameter}", key, wanted, present)

    def _can_add(self, set_id: str, parameter: str) -> bool:
        """Return whether a set that the component has not can be added with this parameter."""
        sets = self._facts.sets if self._facts is not None else {}
        return set_id not in sets and parameter in parameter_names(sets)

    def _choose(self, wanted: str) -> None:
        facts, component = self._facts, self._component
        before = facts.sets.get(facts.active_set, {}) if facts is not None else {}
        after = facts.sets.get(wanted, {}) if facts is not None else {}
        if facts is not None and wanted not in {*facts.sets, *self._added}:
            self.missing.append(f"No such configuration set: {wanted} (on {component.path})")
            return
        changed = [p for p in after if after[p] != before.get(p)]
        default = wanted if component.pattern is not None else DEFAULT
        is_hot = all(self._is_hot(parameter) for parameter in changed)
        key = ParameterVariable(default, is_hot, f"use set of {component.instance}: ")
        live = facts.active_set if facts is not None else None
        self.settings.append(ComponentSetting(ACTIVE_SET, key, wanted, live))

    def _text(self, set_id: str, parameter: str) -> str:
        name = parameter if set_id == self._used else f"{set_id}.{parameter}"
        return f"set {self._component.instance}.{name}="

    def _is_hot(self, parameter: str) -> bool:
        return "*" in self._component.hot or parameter in self._component.hot
