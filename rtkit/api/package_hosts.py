"""Asks the hosts of a system which packages they have; one that need not be asked is left alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rtkit.errors import RtkitError
from rtkit.modules.package_folders import FOLDER, folders
from rtkit.rtc.names import LOCAL, split_manager

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import Snapshot
    from rtkit.packages.records import Question, Survey
    from rtkit.packages.wheel_target import WheelTarget
    from rtkit.profile.rts_model import ComponentInstance


class PackageHosts:
    """The hosts on which components of a system are to be.

    Attributes:
        session, document, snapshot: As given.
        names: All of them, this one first; this one is `LOCAL`.
        managers: What is known of the manager of each component, by its name.
        far: The components that are to be on other hosts.
        targets: What packages are chosen for on the other hosts that were surveyed.
    """

    def __init__(self, session: Session, document: SystemProfile, snapshot: Snapshot) -> None:
        """Find them; those for which another one stands are none."""
        from rtkit.api.gathering import Managers
        from rtkit.deployment.extension import stated_id

        self.session, self.document, self.snapshot = session, document, snapshot
        alive = (each for each in snapshot.components if not each.zombie)
        self._alive = {each.instance: stated_id(each) for each in alive}
        known = {each.manager: each for each in (snapshot, *snapshot.others)}
        managers = Managers(document.profile, session.usual_manager, document.mapped)
        # What belongs to none of these is made by the first, and counts as here.
        self.managers = {name: known.get(home, snapshot) for name, home in managers.homes.items()}
        hosts = (self.host_of(name) for name in self.managers)
        self.names = tuple(dict.fromkeys([LOCAL, *hosts]))
        self.far = {name for name in self.managers if self.host_of(name) != LOCAL}
        self.targets: dict[str, WheelTarget] = {}

    def host_of(self, component: str) -> str:
        """Return the host on which a component of the system is to be."""
        return split_manager(self.managers[component].manager)[1] or LOCAL

    def components_on(self, host: str) -> list[ComponentInstance]:
        """Return the components that are to be on a host."""
        all = self.document.profile.components
        return [each for each in all if self.host_of(each.instance_name) == host]

    def types_on(self, host: str) -> dict[str, str]:
        """Return the ids of the types of the same, by their names."""
        from rtkit.deployment.described import type_of

        return {each.instance_name: type_of(each.id).id for each in self.components_on(host)}

    def is_up(self, host: str) -> bool:
        """Return whether a manager that the system needs runs on a host."""
        return any(each.pid for each in self._on(host))

    def _on(self, host: str) -> Iterator[Snapshot]:
        for each in (self.snapshot, *self.snapshot.others):
            if (split_manager(each.manager)[1] or LOCAL) == host:
                yield each

    def survey(self, host: str, *, notes: bool) -> Survey:
        """Return what the packages of a host are to the system; `notes` that it needs some.

        Of another host nothing is known while it need not be asked, or cannot be.

        Raises:
            RtkitError: It cannot be, and is to be started.
        """
        from rtkit.packages.records import Survey

        if host == LOCAL and next(folders(), None) is None:
            return Survey()
        types = tuple(dict.fromkeys(self.types_on(host).values()))
        if host == LOCAL:
            from rtkit.packages.needing import survey

            found = survey(self._question(host, types, notes=notes), self.session.timeout_s)
            if found.unknown:
                text = f"packages that nothing uses are not removed: {found.unknown}"
                self.session.verbose(text)
            return found
        is_lost = any(each.manager in self.snapshot.unreachable for each in self._on(host))
        # One that is to be started is to answer before anything is done.
        is_asked = notes and not self.is_up(host)
        if is_lost or not (is_asked or self._is_worth_it(host, types)):
            return Survey()
        try:
            return self._far(host, self._question(host, types, notes=notes))
        except RtkitError as error:
            if is_asked:
                raise
            notify = self.session.verbose if self.is_up(host) else self.session.fail
            notify(f"which packages {host} has is not known: {error}")
            return Survey()

    def leftovers(self, host: str) -> Survey:
        """Return what the packages of a host are to the system when it needs none any more.

        Raises:
            RtkitError: The host cannot be asked.
        """
        asked = self._question(host, (), notes=False)
        if host != LOCAL:
            return self._far(host, asked)
        from rtkit.packages.needing import survey

        return survey(asked, self.session.timeout_s)

    def _question(self, host: str, types: tuple[str, ...], *, notes: bool) -> Question:
        from rtkit.packages.records import Question

        managers = tuple(split_manager(each.manager)[0] for each in self._on(host))
        return Question(self.document.profile.id, types, managers, notes)

    def _is_worth_it(self, host: str, types: Sequence[str]) -> bool:
        """Return whether something is to be made that rtkit lacks, or a package may be surplus."""
        from rtkit.packages.precheck import is_built_in

        if any(not is_built_in(each) for each in self.components_on(host) if self.is_fresh(each)):
            return True
        modules = (each for known in self._on(host) for each in known.modules)
        packaged = (each for each in modules if f"/{FOLDER}/" in each.file)
        return any({*types}.isdisjoint(type.id for type in each.types) for each in packaged)

    def is_fresh(self, component: ComponentInstance) -> bool:
        """Return whether a component is to be made by the code of a type: it does not live."""
        from rtkit.deployment.described import is_same_id
        from rtkit.deployment.extension import STAND_IN

        is_there = is_same_id(self._alive.get(component.instance_name, ""), component.id)
        return not is_there and all(each.name != STAND_IN for each in component.properties)

    def _far(self, host: str, asked: Question) -> Survey:
        from rtkit.hosts import far_packages, far_side, inventory
        from rtkit.hosts.connection import connect
        from rtkit.hosts.host import named
        from rtkit.hosts.wheels import target_of
        from rtkit.packages.records import Survey

        known = inventory.host(host)
        with connect(known, self.session.timeout_s) as connection:
            look, is_bare = far_side.look(connection), not self.is_up(host)
            if asked.types:
                with named(host):
                    self.targets[host] = target_of(look, known.extras, is_bare=is_bare)
            if is_bare and not look.current:
                return Survey()  # there is no rtkit yet, so no package
            return far_packages.surveyed(connection, asked)
