"""What the FlexBE App (noetic) reads of a state's construction, and writes for it.

Recorded from the App, for a state `LogState(text, severity=Logger.REPORT_HINT)`: what stands
between the parentheses, and the values of both parameters that it reads, checks and writes. It
refuses to save an empty value. One form it does not open at all.
"""

import pytest
from app_judge import judge, saved_by_app

from flexbe_testing.core.app_behavior import AppLoadError, Known, read_state

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
STATE = """
class LogState(EventState):
    def __init__(self, text, severity=Logger.REPORT_HINT):
        super(LogState, self).__init__(outcomes=['done'])
"""
BEHAVIOR = """\
from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, \
PriorityContainer, Logger
from flexbe_states.log_state import LogState
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on Sun Nov 29 2026
@author: An author
'''
class GreetSM(Behavior):
    '''
    Greets.
    '''


    def __init__(self):
        super(GreetSM, self).__init__()
        self.name = 'Greet'

        # parameters of this behavior

        # references to used behaviors

        # [MANUAL_INIT]

        # [/MANUAL_INIT]

        # Behavior comments:



    def create(self):
        # x:400 y:40
        _state_machine = OperatableStateMachine(outcomes=['finished'])

        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        with _state_machine:
            # x:100 y:40
            OperatableStateMachine.add('Say hello',
                                        {call},
                                        transitions={{'done': 'finished'}},
                                        autonomy={{'done': Autonomy.Off}})


        return _state_machine


    # [MANUAL_FUNC]

    # [/MANUAL_FUNC]
"""


def behavior(inside):
    return BEHAVIOR.format(call=f"LogState({inside})")


@pytest.fixture(scope="module")
def known():
    return Known([read_state(STATE, "flexbe_states.log_state")], [])


def test_a_form_is_read_checked_and_written_as_the_app_does(known):
    different = []
    for inside, text, severity in READ:
        written = f"LogState(text={text}, severity={severity}),"
        saved = saved_by_app(behavior(inside), known)
        found = judge(behavior(inside), known)
        refused = ["is empty" in complaint for complaint in found]
        if written not in saved or refused != [True] * (text == ""):
            different.append(f"{inside}: {found}, saved: {saved}")
    assert not different, "\n".join(different)


def test_a_string_with_an_escaped_quote_is_not_opened(known):
    with pytest.raises(AppLoadError, match="choose the other quotation mark"):
        saved_by_app(behavior(NOT_OPENED), known)
    assert judge(behavior(NOT_OPENED), known)[0].startswith("the App cannot load it")
    assert judge(behavior(NOT_OPENED.replace("\\'", "\\\\")), known) == []
