"""Each property has a place: in the documentation, and where it has an effect, in a test of it."""

from __future__ import annotations

import runpy
from pathlib import Path

from rtkit.settings.properties import NONE, properties

ROOT = Path(__file__).parents[3]
PROPERTIES, SETTINGS = "test_properties.py", "test_configuration.py"
CONTEXTS = "test_context_settings.py"
_APPLIED = "test_settings_are_those_of_the_thread_and_end_with_it"
SHOWN_BY = {
    "config.version": (PROPERTIES, "test_names_of_the_manager"),
    "openrtm.name": (PROPERTIES, "test_an_identity_is_read_only"),
    "openrtm.version": (PROPERTIES, "test_an_identity_is_read_only"),
    "manager.name": (PROPERTIES, "test_an_id_in_direct_addresses"),
    "manager.instance_name": (SETTINGS, "test_where_properties_come_from_and_who_wins"),
    "manager.naming_formats": (PROPERTIES, "test_names_of_the_manager"),
    "manager.is_master": (
        "test_manager_endpoints.py",
        "test_a_slave_manager_registers_with_its_master",
    ),
    "manager.net_servant": (PROPERTIES, "test_no_door"),
    "manager.update_master_manager.enable": (
        PROPERTIES,
        "test_a_slave_manager_registers_again_and_again_or_once",
    ),
    "manager.update_master_manager.interval": (
        PROPERTIES,
        "test_a_slave_manager_registers_again_and_again_or_once",
    ),
    "manager.components.naming_policy": (PROPERTIES, "test_chosen_names_are_new_on_the_node"),
    "manager.components.precreate": (SETTINGS, "test_a_whole_system_comes_up_with_its_manager"),
    "manager.components.preconnect": (SETTINGS, "test_a_whole_system_comes_up_with_its_manager"),
    "manager.components.preactivation": (SETTINGS, "test_a_whole_system_comes_up_with_its_manager"),
    "manager.modules.load_path": ("test_modules.py", "test_load_paths_are_properties"),
    "manager.modules.Python.load_paths": (PROPERTIES, "test_modules_before_others"),
    "manager.modules.preload": (
        SETTINGS,
        "test_what_fails_at_the_start_is_told_and_the_manager_runs",
    ),
    "manager.preload.modules": (PROPERTIES, "test_modules_before_others"),
    "manager.modules.abs_path_allowed": (
        "test_modules.py",
        "test_absolute_paths_only_where_they_are_allowed",
    ),
    "manager.modules.search_auto": (
        "test_modules.py",
        "test_without_search_types_have_to_be_loaded",
    ),
    "manager.supported_languages": (PROPERTIES, "test_an_identity_is_read_only"),
    "manager.cpu_affinity": (SETTINGS, "test_processors_are_those_of_all_threads_and_slaves"),
    "manager.shutdown_on_nortcs": (SETTINGS, "test_slaves_stay_if_the_properties_say_so"),
    "manager.shutdown_auto": (PROPERTIES, "test_a_slave_in_which_nothing_is_made_ends"),
    "manager.auto_shutdown_duration": (PROPERTIES, "test_a_slave_in_which_nothing_is_made_ends"),
    "manager.termination_waittime": (
        PROPERTIES,
        "test_a_slave_that_does_not_hear_is_killed_after_a_grace",
    ),
    "net.endpoints": ("test_manager_endpoints.py", "test_a_free_port_is_found_and_told"),
    "net.tls": ("test_managers_over_tls.py", "test_without_keys_or_port_no_manager_starts"),
    "net.master_manager": (
        "test_manager_endpoints.py",
        "test_a_slave_manager_registers_with_its_master",
    ),
    "naming.enable": (SETTINGS, "test_properties_change_while_it_runs"),
    "naming.formats": (SETTINGS, "test_properties_change_while_it_runs"),
    "exec_cxt.periodic.type": (PROPERTIES, "test_contexts_of_components"),
    "exec_cxt.periodic.rate": (SETTINGS, "test_a_whole_system_comes_up_with_its_manager"),
    "exec_cxt.sync_transition": (PROPERTIES, "test_transitions_are_not_waited_for"),
    "exec_cxt.sync_activation": (PROPERTIES, "test_transitions_are_not_waited_for"),
    "exec_cxt.sync_deactivation": (PROPERTIES, "test_transitions_are_not_waited_for"),
    "exec_cxt.sync_reset": (PROPERTIES, "test_transitions_are_not_waited_for"),
    "exec_cxt.transition_timeout": (PROPERTIES, "test_transitions_are_waited_for_so_long"),
    "exec_cxt.activation_timeout": (PROPERTIES, "test_transitions_are_waited_for_so_long"),
    "exec_cxt.deactivation_timeout": (PROPERTIES, "test_transitions_are_waited_for_so_long"),
    "exec_cxt.reset_timeout": (PROPERTIES, "test_transitions_are_waited_for_so_long"),
    "exec_cxt.cpu_affinity": (PROPERTIES, "test_processors_of_contexts"),
    "exec_cxt.sched_policy": (CONTEXTS, _APPLIED),
    "exec_cxt.priority": (CONTEXTS, _APPLIED),
    "exec_cxt.memory_lock": (CONTEXTS, _APPLIED),
    "exec_cxt.garbage_collector": (CONTEXTS, _APPLIED),
    "execution_contexts": (PROPERTIES, "test_contexts_of_components"),
    "logger.enable": (PROPERTIES, "test_nothing_is_logged"),
    "logger.file_name": (PROPERTIES, "test_how_a_further_log_looks"),
    "logger.log_level": (SETTINGS, "test_what_is_logged_and_where"),
    "logger.date_format": (PROPERTIES, "test_how_a_further_log_looks"),
    "logger.escape_sequence_enable": (PROPERTIES, "test_how_a_further_log_looks"),
    "rtkit.start.strict": (SETTINGS, "test_a_strict_start_leaves_nothing"),
    "manager.restart": ("test_supervision.py", "test_what_the_manager_says_holds_for_all"),
    "manager.restart.*": ("test_supervision.py", "test_what_the_manager_says_holds_for_all"),
    "rtkit.restore": ("test_desired_state.py", "test_restoring_can_be_declined"),
    "rtkit.tags": ("test_placement_here.py", "test_tags_of_a_manager_are_those_of_its_host"),
    "rtkit.allow_faults": ("test_fault_points.py", "test_who_may_be_broken_off"),
    "ec.*": (PROPERTIES, "test_contexts_of_components"),
    "port.*": (PROPERTIES, "test_ports_have_defaults"),
    "os.*": (PROPERTIES, "test_an_identity_is_read_only"),
    "*.*.config_file": (SETTINGS, "test_a_component_has_files_of_its_own"),
    "*.*.conf.*": (SETTINGS, "test_a_component_has_files_of_its_own"),
    "*.*.exec_cxt.*": (SETTINGS, "test_a_component_has_files_of_its_own"),
}


def test_every_effect_is_shown_on_a_real_manager() -> None:
    assert {each.key for each in properties() if each.when != NONE} == SHOWN_BY.keys()
    texts = {
        name: (ROOT / "tests" / "system" / name).read_text(encoding="utf-8")
        for name in {file for file, _ in SHOWN_BY.values()}
    }
    missing = [
        (key, test) for key, (file, test) in SHOWN_BY.items() if f"def {test}(" not in texts[file]
    ]
    assert missing == []


def test_what_has_no_effect_tells_why() -> None:
    assert [each.key for each in properties() if not each.meaning] == []


def test_the_documentation_is_not_stale() -> None:
    made = runpy.run_path(str(ROOT / "tools" / "make_property_table.py"))["table"]()
    file = ROOT / "docs" / "manager-properties.md"
    stale = "stale, write it anew with: python tools/make_property_table.py"
    assert file.read_text(encoding="utf-8") == made, stale
