"""Behaviors as the FlexBE App loads, checks and saves them."""

import pytest
from app_judge import alias, judge, judge_manifest, load, saved_by_app, walk

from flexbe_testing.core.app_behavior import AppLoadError, Known, read_state
from flexbe_testing.core.app_load import define_behavior

STATE = """
class {name}(EventState):
    def __init__(self{parameters}):
        super().__init__(outcomes={outcomes}, input_keys={reads}, output_keys={writes})
"""
BEHAVIOR = """\
#!/usr/bin/env python3
from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, \
PriorityContainer, Logger
from my_behaviors.clean_up_sm import CleanUpSM
from my_states.ask_state import AskState
from my_states.move_state import MoveState
from my_states.see_state import SeeState
# Guide.
# [MANUAL_IMPORT]
import math  # def mine
# [/MANUAL_IMPORT]


'''
Created on Tue Nov 03 2026
@author: Somebody
'''
class FetchPartSM(Behavior):
    '''
    Fetches a part.
    '''


    def __init__(self):
        super(FetchPartSM, self).__init__()
        self.name = 'Fetch Part'

        # parameters of this behavior
        self.add_parameter('speed', 0.5)

        # references to used behaviors
        self.add_behavior(CleanUpSM, 'Box/Clean')

        # [MANUAL_INIT]
        self.x = {'a': (1)}
        # [/MANUAL_INIT]

        # Behavior comments:

        # O 10 20 /Box
        # a note|nof two lines



    def create(self):
        limit = 3
        # x:700 y:40, x:700 y:140
        _state_machine = OperatableStateMachine(outcomes=['finished', 'failed'], \
input_keys=['part'], output_keys=['pose'])
        _state_machine.userdata.part = 'P1'
        _state_machine.userdata.pose = None

        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        # x:500 y:40, x:500 y:140, x:500 y:240
        _sm_look_0 = ConcurrencyContainer(outcomes=['seen', 'lost'], input_keys=['part'], \
output_keys=['pose'], conditions=[
                                        ('seen', [('Left', 'seen'), ('Right', 'seen')]),
                                        ('lost', [('Left', 'unseen')]),
                                        ('lost', [('Right', 'unseen')])
                                        ])

        with _sm_look_0:
            # x:30 y:40
            OperatableStateMachine.add('Left',
                                        SeeState(camera=self.names[0], hint="a, (b)"),
                                        transitions={'seen': 'seen', 'unseen': 'lost'},
                                        autonomy={'seen': Autonomy.Off, 'unseen': Autonomy.Off},
                                        remapping={'part': 'part', 'pose': 'pose'})

            # x:30 y:140
            OperatableStateMachine.add('Right',
                                        SeeState(camera='right', hint=''),
                                        transitions={'seen': 'seen', 'unseen': 'lost'},
                                        autonomy={'seen': Autonomy.Off, 'unseen': Autonomy.Low},
                                        remapping={'part': 'part', 'pose': 'right_pose'})


        # x:500 y:40
        _sm_box_1 = PriorityContainer(outcomes=['done'])

        with _sm_box_1:
            # x:30 y:40
            OperatableStateMachine.add('Clean',
                                        self.use_behavior(CleanUpSM, 'Box/Clean', \
default_keys=['how'], parameters={'speed': self.speed}),
                                        transitions={'cleaned': 'done'},
                                        autonomy={'cleaned': Autonomy.Inherit})


        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('Look',
                                        _sm_look_0,
                                        transitions={'seen': 'Move', 'lost': 'Ask'},
                                        autonomy={'seen': Autonomy.Inherit, \
'lost': Autonomy.Inherit},
                                        remapping={'part': 'part', 'pose': 'pose'})

            # x:300 y:140
            OperatableStateMachine.add('Box',
                                        _sm_box_1,
                                        transitions={'done': 'failed'},
                                        autonomy={'done': Autonomy.Inherit})

            # x:300 y:40
            OperatableStateMachine.add('Move',
                                        MoveState(speed=self.speed),
                                        transitions={'done': 'finished'},
                                        autonomy={'done': Autonomy.High},
                                        remapping={'pose': 'pose'})

            # x:300 y:240
            OperatableStateMachine.add('Ask',
                                        AskState(answers=['again', 'clean_up']),
                                        transitions={'again': 'Look', 'clean_up': 'Box'},
                                        autonomy={'again': Autonomy.Off, 'clean_up': Autonomy.Full})


        return _state_machine


    # [MANUAL_FUNC]
    def mine(self):
        return 1
    # [/MANUAL_FUNC]
"""
CLEAN_UP = """\
class CleanUpSM(Behavior):
    def __init__(self):
        self.name = 'Clean Up'
        self.add_parameter('speed', 1)
    def create(self):
        _state_machine = OperatableStateMachine(outcomes=['cleaned'], input_keys=['how'])
        return _state_machine
"""
MANIFEST = """\
<?xml version="1.0" encoding="UTF-8"?>
<behavior name="Fetch Part">
  <executable package_path="my_behaviors.fetch_part_sm" class="FetchPartSM"/>
  <author>Somebody</author>
  <description>Fetches a part.</description>
  <contains name="Clean Up"/>
</behavior>
"""


def state(name, outcomes, parameters="", reads=(), writes=(), package="my_states"):
    text = STATE.format(
        name=name, parameters=parameters, outcomes=outcomes, reads=[*reads], writes=[*writes]
    )
    return read_state(text, f"{package}.{name.lower().replace('state', '_state')}")


@pytest.fixture(scope="module")
def known():
    states = [
        state("SeeState", ["seen", "unseen"], ", camera, hint=''", ["part"], writes=["pose"]),
        state("MoveState", ["done"], ", speed=1", ["pose"]),
        state("AskState", "answers", ", answers"),
    ]
    return Known(states, [define_behavior(CLEAN_UP, "my_behaviors.clean_up_sm")])


def test_a_behavior_is_saved_as_it_was_loaded(known):
    assert judge(BEHAVIOR, known) == []
    kept = [line for line in saved_by_app(BEHAVIOR, known).splitlines() if line.strip()]
    lines = [line for line in BEHAVIOR.splitlines() if line.strip()]
    guides = [line for line in lines if line not in kept]
    assert all(line.lstrip().startswith("#") for line in guides)
    assert kept[2:] == [line for line in lines[1:] if line not in guides]  # after the head


def test_what_is_loaded_is_what_the_file_holds(known):
    behavior = load(BEHAVIOR, known)
    children = dict(walk(behavior.root))
    assert list(children) == [
        "/Look",
        "/Look/Left",
        "/Look/Right",
        "/Box",
        "/Box/Clean",
        "/Move",
        "/Ask",
    ]
    left = children["/Look/Left"]
    assert left.content.given == {"camera": "self.names[0]", "hint": '"a, (b)"'}
    assert (left.place, left.remapping) == ((30, 40), {"part": "part", "pose": "pose"})
    look = children["/Look"].content
    assert look.conditions[0] == ("seen", (("Left", "seen"), ("Right", "seen")))
    clean = children["/Box/Clean"].content
    assert (clean.keys_by_default, clean.given) == (("how",), {"speed": "self.speed"})
    assert children["/Ask"].content.outcomes == ("again", "clean_up")
    assert (behavior.parameters, behavior.private) == ({"speed": "0.5"}, {"limit": "3"})
    assert behavior.userdata == {"part": "'P1'", "pose": "None"}
    assert behavior.notes == "# O 10 20 /Box\n# a note|nof two lines"
    assert behavior.manual["IMPORT"] == "\nimport math  # def mine\n"


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        (
            "class FetchPartSM(Behavior)",
            "class FetchPartSM(Behavior, Mine)",
            "not exactly one class",
        ),
        ("FetchPartSM", "FetchPart", "saves it as class FetchPartSM"),
        ("# [/MANUAL_INIT]", "", "is not followed by exactly one"),
        ("Fetches a part.", "It's fetched.", "no docstring"),
        ("'''\nCreated", "'''\nIt's created", "no block with date and author"),
        ("self.name = 'Fetch", "self.name = 'Fetch\\'s", "no self.name"),
        ("# Behavior comments:", "# a def b\n        # Behavior comments:", "__init__ ends early"),
        ("import SeeState", "import (SeeState)", "an import in another form"),
        ("return _state_machine", "return (_state_machine)", "does not return a variable"),
        ("outcomes=['done']", "['done']", "an argument that is not a list"),
        ("                                        ])\n", "        ])  # no\n", "is not read"),
        ("('lost', [('Left', 'unseen')])", "('lost', [('Left', x)])", "a condition that is not"),
        ("# x:500 y:40\n", "\n", "positions of the outcomes"),
        ("# x:300 y:40\n", "# x:300.5 y:40\n", "the position of '/Move'"),
        ("_state_machine.userdata.part", "_state_machine.userdata.p", "for the key 'part'"),
        ("{'done': 'finished'", "{'done': 'gone'", "'done' of '/Move' to 'gone'"),
        ("['again', 'clean_up']", "['again', 'clean up']", "drops the blanks|not connected"),
        (
            "{'again': 'Look', 'clean_up': 'Box'}",
            "{'again': 'Look'}",
            "'clean_up' of '/Ask' is not",
        ),
        ("'pose': 'right_pose'", "'pose': 'right pose'", "is not an identifier"),
        ("remapping={'pose': 'pose'}", "remapping={'pose': 'p'}", "nothing before it writes 'p'"),
        ("remapping={'pose': 'pose'}", "remapping={'p': 'pose'}", "which it does not have"),
        ("[('Right', 'unseen')]", "[('Left', 'unseen')]", "is in two conditions"),
        ("[('Left', 'unseen')]", "[('Left', 'unseen'), ('Left', 'seen')]", "two outcomes of one"),
        ("'Right', 'unseen')", "'Right', 'unsaid')", "and its condition to 'None'"),
        ("MoveState(speed=", "MoveState(sped=", "which MoveState hides"),
        ("MoveState(", "NoState(", "class NoState, which the App does not know"),
        ("self.use_behavior(CleanUpSM", "self.use_behavior(NoSM", "behavior that the App does not"),
        ("{'speed': self.speed}", "{'speed': max(1, 2)}", "parameters of '/Box/Clean'"),
        ("speed=self.speed)", "speed=(1)", "cannot load|is empty"),
        ("camera='right'", "", "parameter 'camera' of '/Look/Right' is empty"),
        ("'Box',\n", "'B-x',\n", "variable '_sm_b-x_0' after container '/B-x'"),
        ("_state_machine:\n", "_sm_box_1:\n", "has no states"),
        ("OperatableStateMachine.add('Ask'", "PriorityContainer.add('Ask'", "is not Operatable"),
        ("High}", "higher()}", "saving changes the code"),
        ("                                        _sm_box_1,", "_sm_box_2,", "neither a state"),
    ],
)
def test_what_the_app_loses_or_refuses_is_reported(old, new, complaint, known):
    assert old in BEHAVIOR
    text = BEHAVIOR.replace(old, new)
    found = "\n".join(judge(text, known))
    assert any(part in found for part in complaint.split("|")), found


def test_a_class_name_of_two_packages_is_distinguished_by_the_package():
    here, there = state("A", ["x"], package="a"), state("A", ["y"], package="b")
    both = Known([here, there])
    assert both.state("b__A", []) is there
    assert both.state("A", ["y"]) is there
    assert both.state("A", ["z"]) is None
    assert (alias(both, here), alias(Known([here]), here)) == ("a__A", "A")


def test_a_manifest_names_the_file_and_the_class_that_the_app_writes(known):
    assert judge_manifest(MANIFEST, BEHAVIOR, known) == []


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("fetch_part_sm", "fetch_sm", "saves 'Fetch Part' as my_behaviors.fetch_part_sm"),
        ("my_behaviors.", "my_behaviors.deep.", "saves 'Fetch Part' as"),
        ("Somebody", " ", "no author"),
        ('name="Clean Up"', 'name="Clean"', "it contains ['Clean'], the code uses ['Clean Up']"),
        ("</behavior>", "<executable/></behavior>", "not exactly one <behavior>"),
        ("</behavior>", "", "cannot read it"),
    ],
)
def test_what_is_wrong_with_a_manifest_is_reported(old, new, complaint, known):
    found = "\n".join(judge_manifest(MANIFEST.replace(old, new), BEHAVIOR, known))
    assert complaint in found, found


def test_what_the_user_has_filled_in_for_a_computed_list_is_kept(known):
    computed = state("AskState", "list('ab')")
    others = [s for s in known.states if s.class_name != "AskState"]
    with_computed = Known([*others, computed], known.behaviors)
    text = BEHAVIOR.replace("AskState(answers=['again', 'clean_up'])", "AskState()")
    assert "has no outcomes that the App can read" in "\n".join(judge(text, with_computed))
    filled = text.replace("# x:300 y:240", "# x:300 y:240 {?outcomes = ['again', 'clean_up']}")
    assert judge(filled, with_computed) == []
    assert "# x:300 y:240 {?outcomes = ['again', 'clean_up']}" in saved_by_app(
        filled, with_computed
    )


def test_other_spellings_are_read_as_the_same_and_saved_in_the_apps_own(known):
    text = BEHAVIOR.replace("MoveState(speed=self.speed)", "MoveState(self.speed)")
    text = text.replace("Autonomy.High", "2").replace("'Move',\n", '"Move" ,\n')
    saved = saved_by_app(text, known)
    assert "MoveState(speed=self.speed)" in saved
    assert "OperatableStateMachine.add('Move',\n" in saved
    assert "autonomy={'done': 2}" in saved
    assert judge(saved, known) == judge(text, known) == []


def test_states_of_one_name_are_imported_under_the_names_of_their_packages(known):
    other = state("MoveState", ["moved"], package="other_states")
    both = Known([*known.states, other], known.behaviors)
    assert judge(BEHAVIOR, both) == []
    saved = saved_by_app(BEHAVIOR, both)
    line = "from my_states.move_state import MoveState as my_states__MoveState"
    assert line in saved.splitlines()
    assert "my_states__MoveState(speed=self.speed)" in saved
    assert judge(saved, both) == []


# Recorded from the App (noetic) for a state with the parameters of LogState: what stands between
# the parentheses, and the values of `text` and `severity` that the App reads, checks and writes.
# It refuses to save an empty value. One form it does not open at all.
DEFAULT = "Logger.REPORT_HINT"
READ = [
    ("", "", DEFAULT),
    ("text='a'", "'a'", DEFAULT),
    ("'a'", "'a'", DEFAULT),
    ("text = 'a'", "'a'", DEFAULT),
    (" text='a' ", "'a'", DEFAULT),
    ("text='a', severity=2", "'a'", "2"),
    ("severity=2, text='a'", "'a'", "2"),
    ("'a', severity=2", "'a'", "2"),
    ("'a', 2", "'a'", "2"),
    ("text='a',", "", DEFAULT),
    ("text='a, b'", "'a, b'", DEFAULT),
    ("text='f(x)'", "'f(x)'", DEFAULT),
    ("text='a=b'", "'a=b'", DEFAULT),
    ("text='# a'", "'# a'", DEFAULT),
    ('text="a"', '"a"', DEFAULT),
    ("text=[1, 2, 'c, d']", "[1, 2, 'c, d']", DEFAULT),
    ("text={'a': 1, 'b': 2}", "{'a': 1, 'b': 2}", DEFAULT),
    ("text=(1, 2)", "(1, 2)", DEFAULT),
    ("text=self.name", "self.name", DEFAULT),
    ("text=-1.5e-3", "-1.5e-3", DEFAULT),
    ("text=None", "None", DEFAULT),
    ("text=''", "''", DEFAULT),
    ("text='a', severity=Logger.REPORT_HINT", "'a'", DEFAULT),
    ("text=lambda x: x", "lambda x: x", DEFAULT),
    ("text='a' 'b'", "'a' 'b'", DEFAULT),
    ("text=str(1)", "str(1)", DEFAULT),
    ("text='a',\n                                                 severity=2", "'a'", "2"),
    ("text='ä€'", "'ä€'", DEFAULT),
    ("text='a]b['", "'a]b['", DEFAULT),
    ("text='a)'", "'a)'", DEFAULT),
    ("text=' a '", "' a '", DEFAULT),
]
NOT_OPENED = "text='it\\'s'"


@pytest.fixture(scope="module")
def known_as_log(known):
    """Return what is known, MoveState with the parameters of LogState."""
    move = state("MoveState", ["done"], f", text, severity={DEFAULT}", ["pose"])
    others = [s for s in known.states if s.class_name != "MoveState"]
    return Known([*others, move], known.behaviors)


def constructed(inside):
    return BEHAVIOR.replace("MoveState(speed=self.speed)", f"MoveState({inside})")


def test_a_form_is_read_checked_and_written_as_the_app_does(known_as_log):
    different = []
    for inside, text, severity in READ:
        written = f"MoveState(text={text}, severity={severity}),"
        saved = saved_by_app(constructed(inside), known_as_log)
        found = judge(constructed(inside), known_as_log)
        refused = ["is empty" in complaint for complaint in found]
        if written not in saved or refused != [True] * (text == ""):
            different.append(f"{inside}: {found}, saved: {saved}")
    assert not different, "\n".join(different)


def test_a_string_with_an_escaped_quote_is_not_opened(known_as_log):
    with pytest.raises(AppLoadError, match="choose the other quotation mark"):
        saved_by_app(constructed(NOT_OPENED), known_as_log)
    assert judge(constructed(NOT_OPENED), known_as_log)[0].startswith("the App cannot load it")
    mended = NOT_OPENED.replace("\\'", "\\\\")
    assert judge(constructed(mended), known_as_log) == []
