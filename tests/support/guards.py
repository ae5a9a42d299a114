"""Guards that keep promises true: the fault tests must fail when one is taken away.

Each guard is some text of one file, and the text in its place when the guard is removed.
"""

from __future__ import annotations

from typing import NamedTuple


class Guard(NamedTuple):
    """One guard.

    Attributes:
        test: Below ``tests/``, ``system/test_x.py::test_y``; what is in brackets may be left out.
        file: From the root of the project.
    """

    test: str
    file: str
    old: str
    new: str

    def __str__(self) -> str:
        return f"{self.test.rpartition('::')[2]}-{self.file.rpartition('/')[2]}"


GUARDS = (
    Guard(
        "system/test_faults.py::test_a_slave_that_a_component_ends",
        "rtkit/manager/core/core.py",
        """                self.state.update(instance, zombie=process.reason, trouble="", since=at)
""",
        "",
    ),
    Guard(
        "system/test_faults.py::test_a_component_that_raises_does_not_end_its_slave",
        "rtkit/component/contexts/callbacks.py",
        "    except BaseException as error:\n        return Failure(describe",
        "    except Exception as error:\n        return Failure(describe",
    ),
    Guard(
        "system/test_stuck.py::test_a_stuck_callback_is_named_with_its_line",
        "rtkit/manager/slaves/watchdog.py",
        "        return age_ns > bound_s * 1e9",
        "        return False",
    ),
    Guard(
        "system/test_faults.py::test_a_creation_that_hangs_is_given_up_in_time_and_cleaned_away",
        "rtkit/manager/slaves/watchdog.py",
        "            bound_s = min(bound_s, watched.age_s)",
        "            bound_s = 1e6",
    ),
    Guard(
        "system/test_supervision.py::test_who_is_not_well_is_shown_or_made_again",
        "rtkit/manager/core/health_monitor.py",
        "        if rule.reaction is Reaction.RESTART:",
        "        if False:",
    ),
    Guard(
        "system/test_supervision.py::test_a_killed_slave_is_back_as_it_was",
        "rtkit/manager/core/recovery.py",
        "    yield Gather((*configures, *_connects(state, ready, bonds, failed)))",
        "    yield Gather(tuple(configures))",
    ),
    Guard(
        "laws/test_restarts.py::test_after_restarts_there_is_nothing_to_plan",
        "rtkit/manager/core/recovery.py",
        """    if desired.active_set not in ("", facts.active_set, asked.active_set):""",
        "    if False:",
    ),
    Guard(
        "unit/manager/test_core_restart_status.py::"
        "test_who_dies_at_every_start_is_not_made_again_more_often_by_many_managers",
        "rtkit/manager/core/durable_replies.py",
        "        elif kept.is_urgent:",
        "        elif False:",
    ),
    Guard(
        "system/test_desired_state.py::test_a_store_that_is_removed_under_a_living_manager_is_written_anew",
        "rtkit/manager/core/durable_replies.py",
        "        if stored.is_lost and not self._is_forgetting:",
        "        if False:",
    ),
    Guard(
        "system/test_supervision.py::test_error_is_answered_in_place_and_who_fails_always_is_given_up",
        "rtkit/deployment/supervision.py",
        "    if len(recent) >= policy.limit:",
        "    if False:",
    ),
    Guard(
        "system/test_faults.py::test_what_a_component_started_ends_with_its_slave",
        "rtkit/manager/slaves/slave_supervisor.py",
        "            end_sessions(over, is_ancestor=is_all_ours)",
        "            pass",
    ),
    Guard(
        "system/test_faults.py::test_two_hundred_children_end_with_their_slave",
        "rtkit/manager/slaves/slave_supervisor.py",
        "            end_sessions(over, is_ancestor=is_all_ours)",
        "            pass",
    ),
    Guard(
        "system/test_faults.py::test_memory_that_is_used_up_is_an_error_of_who_wants_more",
        "rtkit/component/contexts/callbacks.py",
        "    except BaseException as error:\n        return Failure(describe",
        "    except ValueError as error:\n        return Failure(describe",
    ),
    Guard(
        "system/test_faults.py::test_a_killed_slave_costs_nobody_else_a_message",
        "rtkit/manager/core/core.py",
        """                self._cut(connector)
            if (process.is_wanted or process.verdict) and not process.is_guest:
                self.state.drop_connectors(instance)
""",
        """                pass
            if (process.is_wanted or process.verdict) and not process.is_guest:
""",
    ),
    Guard(
        "system/test_faults.py::test_a_stopped_slave_is_answered_for_at_once_and_hears_of_it_later",
        "rtkit/manager/core/core.py",
        "            ev.SlaveStopped: lambda event: self._halted(event.key, event.is_halted),",
        "            ev.SlaveStopped: lambda _event: None,",
    ),
    Guard(
        "system/test_restart.py::test_manager_and_zygote_killed",
        "rtkit/manager/process_monitor.py",
        "list(self._slave_supervisor.halts())",
        "()",
    ),
    Guard(
        "system/test_faults.py::test_a_killed_zygote_is_replaced_and_its_slaves_run_on",
        "rtkit/manager/slaves/slave_connections.py",
        "        self._slave_supervisor.restart()\n",
        "        return\n",
    ),
    Guard(
        "system/test_faults.py::test_a_stopped_zygote_costs_only_new_slaves",
        "rtkit/manager/slaves/slave_supervisor.py",
        '(f"the zygote is stopped (pid {report.si_pid})" * is_stopped)',
        '("")',
    ),
    Guard(
        "system/test_restart.py::test_a_killed_manager_stops_no_component_and_loses_no_message",
        "rtkit/container/manager_connection.py",
        "            channel = None if self._is_over else self._seek(report_all)",
        "            channel = None",
    ),
    Guard(
        "system/test_restart.py::test_the_end_of_a_found_slave_is_told_with_its_reason",
        "rtkit/manager/slaves/zygote.py",
        "            self._selector.register(self._listener, selectors.EVENT_READ, self._accept)",
        "            self._children.clear()",
    ),
    Guard(
        "system/test_desired_state.py::"
        "test_a_manager_killed_in_its_commit_or_while_it_restores_leaves_nothing_half",
        "rtkit/manager/core/core.py",
        "        adoption.believe(self.state, process, holding)\n",
        "",
    ),
    Guard(
        "system/test_desired_state.py::test_a_killed_manager_finds_the_living_and_makes_its_own_again",
        "rtkit/manager/core/recovery.py",
        "    awaited = {*kept.zombies, *state.returning}",
        "    awaited = kept.components",
    ),
    Guard(
        "system/test_desired_state.py::test_all_is_back_after_a_loss_of_power",
        "rtkit/manager/store/store.py",
        """                db.execute("commit")""",
        """                db.execute("rollback")""",
    ),
    Guard(
        "system/test_fault_points.py::test_killed_at_points[connect]",
        "rtkit/manager/core/wiring.py",
        "        yield from _abandon(ends, connector_id)\n        raise",
        "        raise",
    ),
    Guard(
        "system/test_system_calls.py::test_calls_here_and_there[cryo]",
        "rtkit/link/atomic.py",
        "    os.fsync(stream.fileno())\n",
        "",
    ),
    Guard(
        "system/test_desired_state.py::test_a_damaged_store_is_put_aside_and_made_anew_from_what_lives",
        "rtkit/manager/store/store.py",
        """            return StoredRows([], f"{self.set_aside('damaged')} ({error})")""",
        """            return StoredRows([], "")""",
    ),
    Guard(
        "system/test_desired_state.py::test_what_cannot_be_recorded_is_refused_and_nothing_runs_worse",
        "rtkit/manager/core/durable_replies.py",
        "                self._take_back(done, why)",
        "                done.send(done.results)",
    ),
    Guard(
        "unit/manager/test_logfile.py::test_a_full_file_is_begun_anew_and_the_older_ones_are_bounded",
        "rtkit/logs/logfile.py",
        "        for number in range(self._files - 1, 0, -1):",
        "        for number in ():",
    ),
    Guard(
        "system/test_clock_jumps.py::test_only_stamps_follow_a_clock_that_jumps",
        "rtkit/manager/loop.py",
        "now = time.monotonic()\n        self._ring",
        "now = time.time()\n        self._ring",
    ),
    Guard(
        "system/test_duties.py::test_a_fault_in_each_duty_leaves_the_daemon_alive_and_a_dump",
        "rtkit/manager/fault_guard.py",
        "            self.note(work, error)\n            return None",
        "            raise",
    ),
    Guard(
        "system/test_manager.py::test_a_manager_without_descriptors_refuses_the_new_and_keeps_the_old",
        "rtkit/link/spare_descriptor.py",
        "            os.close(self._descriptor)\n",
        "            pass\n",
    ),
    Guard(
        "system/test_manager.py::test_of_several_starts_at_once_exactly_one_of_each_name_serves",
        "rtkit/manager/claim.py",
        "            fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)",
        "            pass",
    ),
    Guard(
        "system/test_manager.py::test_what_is_no_socket_is_not_removed",
        "rtkit/manager/claim.py",
        "if is_own and beside == path and not stat.S_ISSOCK(os.lstat(path).st_mode):",
        "if False:",
    ),
    Guard(
        "laws/test_supervision.py",
        "rtkit/deployment/supervision.py",
        "    if len(recent) >= policy.limit:",
        "    if False:",
    ),
    Guard(
        "laws/test_deployment_planning.py",
        "rtkit/deployment/planning/operators.py",
        """            *(f"con:{connector}" for connector in model.connectors_of[name]),
            *(f"cfg:{key}" for key in model.keys_of[name]),
""",
        "",
    ),
    Guard(
        "laws/test_deployment_applying.py",
        "rtkit/deployment/applying.py",
        "            if rolls_back:\n",
        "            if False:\n",
    ),
    Guard(
        "system/test_campaign.py::test_every_kind_of_fault",
        "rtkit/manager/core/recovery.py",
        "        if connector.connector_id not in state.connectors\n",
        "        if connector.connector_id not in {*state.connectors, 'Cell3-Cell4'}\n",
    ),
    Guard(
        "integration/test_far_peers.py::test_a_peer_is_awaited_as_long_as_who_asks_has_time",
        "rtkit/manager/peers/far_peers.py",
        "            until = time.monotonic() + _PART * asked.timeout_s",
        "            until = time.monotonic()",
    ),
    Guard(
        "integration/test_between_hosts.py::test_a_far_host_asks_and_answers_for_nobody_else",
        "rtkit/hosts/link_process.py",
        '            "default_permission": "deny",',
        '            "default_permission": "allow",',
    ),
    Guard(
        "integration/test_tls.py::test_who_is_revoked_is_cut_and_comes_in_no_more",
        "rtkit/wires/secure.py",
        "        elif self.trust.refusal(self.peer):",
        "        elif False:",
    ),
    Guard(
        "system/test_ssh.py::test_a_revoked_key_is_refused",
        "rtkit/hosts/known_hosts.py",
        "            if line.marker == _REVOKED and line.data == data:",
        "            if False:",
    ),
    Guard(
        "system/test_ssh.py::test_somebody_in_between_is_refused_and_learns_nothing",
        "rtkit/hosts/known_hosts.py",
        "        if any(line.data == data for line in known):\n",
        "        if True:\n",
    ),
    Guard(
        "system/test_connected_hosts.py::test_nobody_is_connected_who_does_not_expect_it",
        "rtkit/manager/core/meetings.py",
        "                check_expected(self._state, connector)",
        "                pass",
    ),
    Guard(
        "system/test_logs_over_hosts.py::test_causes_come_before_their_effects_whatever_the_clocks_say",
        "rtkit/tree/far_logs.py",
        "timedelta(seconds=self.clock.offset_s)",
        "timedelta(0)",
    ),
)
