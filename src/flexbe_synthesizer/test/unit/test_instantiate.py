from flexbe_synthesizer.core.export.layout import (
    Instantiation,
    instantiate,
    lay_out,
    presets,
    with_presets_written,
)


def states(root):
    return {state.state_path: state for state in instantiate(root, lay_out(root))}


def test_the_first_entry_is_the_container_itself(machine):
    root = machine("plain.xml").root
    assert instantiate(root, lay_out(root))[0] == Instantiation(
        state_path="/",
        state_class=":STATEMACHINE",
        initial_state_name="Locate",
        input_keys=("component_id", "cable_id"),
        output_keys=("where", "force"),
        outcomes=("PlacePin finished normally", "failed"),
    )


def test_a_state_carries_its_class_parameters_and_keys(machine):
    assert states(machine("plain.xml").root)["/Locate"] == Instantiation(
        state_path="/Locate",
        state_class="cell_states__LocateComponentState",
        parameter_names=("timeout_s", "topic"),
        parameter_values=("2", "'cell_2/locate'"),
        outcomes=("located", "failed"),
        transitions=("Insert", "failed"),
        autonomy=(0, 0),
        userdata_keys=("component_id", "pose", "error_code", "error_message"),
        userdata_remapping=("component_id", "where", "locate_error_code", "locate_error_message"),
    )


def test_a_behavior_is_named_by_its_display_name(machine):
    clean = states(machine("plain.xml").root)["/Clean Up"]
    assert (clean.state_class, clean.behavior_class) == (":BEHAVIOR", "Clean Up")
    assert clean.parameter_names == ("speed", "places")
    assert clean.autonomy == (-1, -1)


def test_a_concurrency_container_lists_its_conditions(machine):
    box = states(machine("place_connector.xml").root)["/Fix"]
    assert box.state_class == ":CONCURRENCY"
    assert box.initial_state_name == "run"
    assert box.cond_outcome == ("fixed", "failed", "timed_out")
    assert box.cond_transition == ((("run", "fixed"),), (("run", "failed"),), (("timer", "done"),))
    assert box.outcomes == ("fixed", "failed", "timed_out")
    assert box.transitions == ("finished", "Extract", "Extract")


def test_every_container_names_its_initial_state(machine):
    for chart in ("plain.xml", "place_connector.xml", "wire_task.xml"):
        found = states(machine(chart).root)
        for path, state in found.items():
            if state.state_class in (":STATEMACHINE", ":CONCURRENCY"):
                assert path.rstrip("/") + "/" + state.initial_state_name in found


def test_counts_are_written_by_states_since_a_list_carries_no_default_userdata(machine, library):
    root = machine("place_connector.xml").root
    assert [pair.name for pair in presets(root)] == ["insert_attempts", "locate_attempts"]
    (writer,) = library.find_states("flexbe_states/UserDataState")
    found = states(with_presets_written(root, writer))
    assert found["/"].initial_state_name == "Set locate_attempts"
    first, second = found["/Set locate_attempts"], found["/Set insert_attempts"]
    assert (first.parameter_values, first.userdata_remapping) == (("0",), ("locate_attempts",))
    assert (first.transitions, second.transitions) == (
        ("Set insert_attempts",),
        ("Locate_attempts",),
    )
