"""What is read of state classes, behaviors and manifests, from text alone."""

import textwrap

import pytest

from flexbe_synthesizer.core.library.signature import (
    Effect,
    FromParameter,
    Parameter,
    Port,
    StateClass,
    Unreadable,
    documented_type,
    fits,
    is_type,
)
from flexbe_synthesizer.core.library.sources import (
    Manifest,
    read_behavior_class,
    read_manifest,
    read_state_class,
    write_manifest,
)

MANIFEST = Manifest("Clean", "pkg", "clean_sm", "CleanSM")


def state(text):
    return read_state_class(textwrap.dedent(text), "pkg", "pkg.some_state")


WRITING = """
    class SomeState(EventState):
        '''Do it.

        #> seen       boolean  whether
        #> code       int  why not
        <= done       it is [writes seen]
        <= done late  [writes seen,
            code]
            it is, late
        <= failed     [writes {keys}]
        <= left       it was left
        '''
        def __init__(self):
            super().__init__(outcomes=['done', 'done late', 'failed', 'left'],
                output_keys=['seen', 'code'])
"""


def test_a_state_class_is_read_with_what_its_outcomes_write():
    both = frozenset({"seen", "code"})
    done, nothing = frozenset({"seen"}), frozenset()
    assert state(WRITING.format(keys="nothing")).effects == (
        Effect("done", done, done),
        Effect("done late", both, both),
        Effect("failed", nothing, nothing),
    )


LIMITED = """
    class SomeState(EventState):
        '''Do it.

        -- name       string  of what
        -- timeout_s  float   [s] ROS time that it gets;
            its server ends later [{grace}]
        <= done       it is
        '''
        def __init__(self, name, timeout_s=5.0):
            super().__init__(outcomes=['done'])
"""


@pytest.mark.parametrize(("grace", "grace_s"), [("grace 2 s", 2.0), ("grace 0.5 s", 0.5), ("s", 0)])
def test_a_time_limit_is_read_with_the_time_beyond_it(grace, grace_s):
    name, limit = state(LIMITED.format(grace=grace)).parameters
    assert (name.grace_s, limit.grace_s) == (0.0, grace_s)


@pytest.mark.parametrize("grace", ["grace two s", "grace 2", "grace -1 s"])
def test_a_time_beyond_a_limit_that_is_no_time_is_refused(grace):
    reason = state(LIMITED.format(grace=grace)).reason
    assert f"its docstring has '[{grace}]' at '-- timeout_s'; allowed: seconds" in reason


def test_a_state_class_that_documents_what_it_lacks_is_refused():
    assert "lets 'failed' write 'cod'" in state(WRITING.format(keys="cod")).reason
    text = WRITING.format(keys="code").replace("<= failed", "<= fails")
    assert "no outcome of its own at '<= fails" in state(text).reason


def test_a_state_class_is_read_with_types_from_its_docstring():
    found = state(
        """
        class Helper: pass
        class SomeState(EventState):
            '''Do it.

            -- speed_m_s  float64  how fast,
                          in metres
            -- names      string[] which
            -- count
            ># pose       geometry_msgs/Pose  where
            #> seen       boolean  whether
            <= done       done it
            '''
            def __init__(self, speed_m_s, names, count=3, *, flag: bool, other="x"):
                '''Set up.'''
                super(SomeState, self).__init__(outcomes=['done', 'not done'],
                    input_keys=['pose'], output_keys=['seen'], io_keys=['both'])
        class OtherState(EventState): pass
        """
    )
    assert found == StateClass(
        "SomeState",
        "pkg",
        module="pkg.some_state",
        parameters=(
            Parameter("speed_m_s", "float"),
            Parameter("names", "list"),
            Parameter("count", None, required=False, default=3, default_source="3"),
            Parameter("flag", "bool"),
            Parameter("other", "string", required=False, default_source="'x'"),
        ),
        outcomes=("done", "not done"),
        inputs=(Port("pose", "geometry_msgs/Pose"), Port("both")),
        outputs=(Port("seen", "bool"), Port("both")),
    )


def test_lists_can_come_from_a_constructor_argument():
    found = state(
        """
        class S(EventState):
            def __init__(self, outcomes, keys=()):
                super().__init__(outcomes=outcomes, input_keys=keys)
        """
    )
    assert (found.outcomes, found.inputs) == (FromParameter("outcomes"), FromParameter("keys"))


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("pass", "no __init__"),
        ("def __init__(self): pass", "does not call super"),
        ("def __init__(self): super().__init__()", "no outcomes"),
        ("def __init__(self): super().__init__(outcomes=[])", "needs one, too, which it never"),
        ("def __init__(self): super().__init__(outcomes=X)", "outcomes are X"),
        ("def __init__(self): super().__init__(outcomes=['a', b])", "outcomes are"),
        ("def __init__(self): super().__init__(outcomes=['a'] + ['b'])", "outcomes are"),
        ("def __init__(self): super().__init__(outcomes=['a(b)'])", "cannot read"),
        (
            "def __init__(self, k): super().__init__(outcomes=['a'], input_keys=k, io_keys=['b'])",
            "beside keys",
        ),
    ],
)
def test_a_state_class_that_cannot_be_read_from_text_is_kept_with_the_reason(body, reason):
    found = state(f"class S(EventState):\n    {body}\n")
    assert isinstance(found, Unreadable)
    assert reason in found.reason


def test_only_a_class_that_extends_event_state_and_nothing_else_is_a_state():
    assert state("class S(EventState, Mixin): pass") is None
    assert state("class S(core.EventState): pass") is None
    assert state("x = 1") is None
    with pytest.raises(SyntaxError):
        state("class S(EventState:")


def test_reading_a_state_runs_nothing(tmp_path):
    touched = tmp_path / "touched"
    state(
        f"""
        open({str(touched)!r}, "w")
        class S(EventState):
            def __init__(self, x=open({str(touched)!r}, "w")):
                super().__init__(outcomes=["done"])
        """
    )
    assert not touched.exists()


def behavior(create, init="self.name = 'Clean'"):
    text = f"class CleanSM(Behavior):\n def __init__(self):\n  {init}\n def create(self):\n"
    text += textwrap.indent(textwrap.dedent(create).strip(), "  ")
    return read_behavior_class(text, MANIFEST)


def test_a_behavior_is_read_as_the_app_writes_it():
    found = behavior(
        """
        sm = OperatableStateMachine(outcomes=['done'], input_keys=['a', 'b'], output_keys=['c'])
        sm.userdata.a = None
        sm.userdata.b = 5
        return sm
        """,
        init="self.add_parameter('speed', 1)",
    )
    assert found.outcomes == ("done",)
    assert found.inputs == (Port("a"), Port("b", optional=True))
    assert found.outputs == (Port("c"),)
    assert found.parameters == (Parameter("speed", None, required=False),)
    assert (found.module, found.class_name) == ("pkg.clean_sm", "CleanSM")


@pytest.mark.parametrize(
    ("create", "reason"),
    [
        ("pass", "does not end by returning"),
        ("return None", "does not end by returning"),
        ("return sm", "does not assign a container to sm"),
        ("sm = make()\nreturn sm", "does not assign a container"),
        ("sm = OperatableStateMachine(outcomes=x)\nreturn sm", "malformed"),
        ("sm = (", "never closed"),
        ("sm = OperatableStateMachine(outcomes=5)\nreturn sm", "5 is no list of names"),
        ("sm = OperatableStateMachine(outcomes={[]: 1})\nreturn sm", "unhashable"),
        ("x = " + "-" * 100_000 + "1", "nested too deeply"),
    ],
)
def test_a_behavior_that_cannot_be_read_from_text_is_kept_with_the_reason(create, reason):
    found = behavior(create)
    assert isinstance(found, Unreadable)
    assert reason in found.reason


@pytest.mark.parametrize("module", ["pick-cable_state", "deep.class.a_state", "2nd_state"])
def test_what_python_cannot_import_is_kept_with_the_reason(module):
    text = "class S(EventState):\n def __init__(self):\n  super().__init__(outcomes=['done'])\n"
    found = read_state_class(text, "pkg", f"pkg.{module}")
    assert f"Python cannot import its module pkg.{module}" in found.reason
    manifest = Manifest("Clean", "pkg", module, "CleanSM")
    assert "Python cannot import" in read_behavior_class("class CleanSM: pass", manifest).reason


def test_a_parameter_that_is_not_named_first_is_reported():
    create = "sm = OperatableStateMachine(outcomes=['done'])\nreturn sm"
    found = behavior(create, init="self.add_parameter(name='speed', default=1)")
    assert "does not begin with the parameter's name" in found.reason


@pytest.mark.parametrize("default", ["1e999", "-1e999", "1" + "0" * 400, "True", "'x'"])
def test_a_default_that_bounds_no_time_is_none(default):
    text = f"class S(EventState):\n def __init__(self, timeout_s={default}):\n"
    (limit,) = state(text + "  super().__init__(outcomes=['done'])").parameters
    assert limit.default is None


def test_a_behavior_file_without_its_class_is_kept_with_the_reason():
    assert "no class CleanSM" in read_behavior_class("x = 1", MANIFEST).reason
    assert "lacks" in read_behavior_class("class CleanSM(Behavior): pass", MANIFEST).reason


def test_a_manifest_is_read_as_it_is_written():
    manifest = Manifest('A "b" & <c>', "pkg", "deep.a_sm", "ASM", contains=("Clean & Up", "Other"))
    text = write_manifest(manifest, "<do> & 'say'")
    assert read_manifest(text, "a.xml") == manifest
    assert not text.endswith("\n")


def test_a_manifest_of_the_app_is_read(golden):
    path = golden / "packages" / "cell_behaviors" / "manifest" / "clean_up.xml"
    manifest = read_manifest(path.read_bytes(), "clean_up.xml")
    assert [(p.name, p.kind) for p in manifest.parameters] == [
        ("speed", "numeric"),
        ("places", "yaml"),
    ]


@pytest.mark.parametrize(
    "text",
    [
        "<package/>",
        "<behavior/>",
        "<behavior>",
        '<behavior name="a"><executable package_path="one"/></behavior>',
        '<behavior name="a"><executable class="A"/></behavior>',
        '<behavior name="a"><executable package_path="p../" class="A"/></behavior>',
    ],
)
def test_other_xml_is_no_manifest(text):
    assert read_manifest(text, "x.xml") is None


def test_types_are_those_of_the_language():
    for name in ("bool", "int", "float", "string", "list", "dict", "geometry_msgs/PoseStamped"):
        assert is_type(name)
    for name in ("str", "Int", "Pose", "geometry_msgs/", "a/b", ""):
        assert not is_type(name)
    assert documented_type("uint8") == "int"
    assert documented_type("`str`") == "string"
    assert documented_type("Pose[]") == "list"
    assert documented_type("PoseStamped") is None


def test_an_integer_fits_where_a_float_is_wanted_and_not_the_other_way():
    assert fits("int", "float")
    assert not fits("float", "int")
    assert not fits("string", "int")
    assert fits(None, "int")
    assert fits("int", None)
