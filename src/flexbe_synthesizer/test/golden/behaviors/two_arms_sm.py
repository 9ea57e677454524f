#!/usr/bin/env python3
# -*- coding: utf-8 -*-
###########################################################
#        Generated from a state chart: do not edit        #
#                                                         #
#  Change the chart and synthesize it again.              #
#  Only the code between [MANUAL] tags is kept then.      #
###########################################################

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, PriorityContainer, Logger
from cell_states.extract_cable_state import ExtractCableState
from cell_states.insert_cable_state import InsertCableState
from cell_states.locate_component_state import LocateComponentState
from flexbe_states.check_condition_state import CheckConditionState
from flexbe_states.decision_state import DecisionState
from flexbe_states.wait_state import WaitState
from remodel_states.count_attempts_state import CountAttemptsState
# Imports of your own belong between these tags.
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on undated
@author: REMODEL planner developers
'''
class TwoArmsSM(Behavior):
    '''
    All that the extension adds: containers of the three kinds, routes by error code, limits inside them, a predicate.
    '''


    def __init__(self):
        super(TwoArmsSM, self).__init__()
        self.name = 'Two Arms'

        # parameters of this behavior

        # references to used behaviors

        # Initialization of your own belongs between these tags.
        # [MANUAL_INIT]

        # [/MANUAL_INIT]

        # Behavior comments:



    def create(self):
        # x:880 y:40, x:880 y:140
        _state_machine = OperatableStateMachine(outcomes=['done', 'failed'], input_keys=['component_id', 'cable_id', 'is_urgent'], output_keys=['error_code', 'force'])
        _state_machine.userdata.component_id = None
        _state_machine.userdata.cable_id = None
        _state_machine.userdata.is_urgent = False
        _state_machine.userdata.error_code = None
        _state_machine.userdata.force = None
        _state_machine.userdata.look_attempts = 0
        _state_machine.userdata.place_insert_attempts = 0

        # Creation code of your own belongs between these tags.
        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        # x:280 y:40, x:280 y:140
        _sm_recover_0 = PriorityContainer(outcomes=['free', 'stuck'], input_keys=['cable_id'])

        with _sm_recover_0:
            # x:30 y:40
            OperatableStateMachine.add('Pull',
                                        ExtractCableState(timeout_s=3.0),
                                        transitions={'extracted': 'free', 'failed': 'stuck'},
                                        autonomy={'extracted': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'error_code': 'pull_error_code', 'error_message': 'pull_error_message'})


        # x:1030 y:40, x:1030 y:140
        _sm_place_1 = OperatableStateMachine(outcomes=['placed', 'given up'], input_keys=['cable_id', 'where', 'place_insert_attempts'], output_keys=['error_code', 'force', 'place_insert_attempts'])

        with _sm_place_1:
            # x:30 y:40
            OperatableStateMachine.add('Insert_attempts',
                                        CountAttemptsState(attempts=3),
                                        transitions={'counted': 'Insert', 'exhausted': 'given up'},
                                        autonomy={'counted': Autonomy.Off, 'exhausted': Autonomy.Off},
                                        remapping={'attempt': 'place_insert_attempts'})

            # x:280 y:40
            OperatableStateMachine.add('Insert',
                                        InsertCableState(force_limit_n=20.0),
                                        transitions={'inserted': 'placed', 'failed': 'Insert_error'},
                                        autonomy={'inserted': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'pose': 'where', 'force': 'force', 'error_code': 'error_code', 'error_message': 'insert_error_message'})

            # x:530 y:40
            OperatableStateMachine.add('Insert_error',
                                        DecisionState(outcomes=['failed_100_199', 'failed_305', 'failed_310_320', 'failed_JAMMED', 'failed_above_behavior', 'other'], conditions=lambda code: 'failed_100_199' if code in range(100, 200) else 'failed_305' if code in range(305, 306) else 'failed_310_320' if code in range(310, 321) else 'failed_JAMMED' if code in range(301, 302) else 'failed_above_behavior' if code in (4, 5, 401) else 'other'),
                                        transitions={'failed_100_199': 'given up', 'failed_305': 'Insert_attempts', 'failed_310_320': 'Extract', 'failed_JAMMED': 'Extract', 'failed_above_behavior': 'given up', 'other': 'Extract'},
                                        autonomy={'failed_100_199': Autonomy.Off, 'failed_305': Autonomy.Off, 'failed_310_320': Autonomy.Off, 'failed_JAMMED': Autonomy.Off, 'failed_above_behavior': Autonomy.Off, 'other': Autonomy.Low},
                                        remapping={'input_value': 'error_code'})

            # x:780 y:40
            OperatableStateMachine.add('Extract',
                                        ExtractCableState(timeout_s=20.0),
                                        transitions={'extracted': 'Insert_attempts', 'failed': 'given up'},
                                        autonomy={'extracted': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'error_code': 'error_code', 'error_message': 'extract_error_message'})


        # x:330 y:40, x:330 y:140, x:330 y:140, x:330 y:140
        _sm_run_2 = ConcurrencyContainer(outcomes=['seen', 'missing'], input_keys=['component_id'], output_keys=['left_pose', 'error_code'], conditions=[
                                        ('seen', [('Left', 'located'), ('Right', 'located')]),
                                        ('missing', [('Left', 'failed')]),
                                        ('missing', [('Right', 'failed')])
                                        ])

        with _sm_run_2:
            # x:30 y:40
            OperatableStateMachine.add('Left',
                                        LocateComponentState(timeout_s=10.0),
                                        transitions={'located': 'seen', 'failed': 'missing'},
                                        autonomy={'located': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'component_id': 'component_id', 'pose': 'left_pose', 'error_code': 'error_code', 'error_message': 'left_error_message'})

            # x:30 y:140
            OperatableStateMachine.add('Right',
                                        LocateComponentState(view='side'),
                                        transitions={'located': 'seen', 'failed': 'missing'},
                                        autonomy={'located': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'component_id': 'component_id', 'pose': 'right_pose', 'error_code': 'error_code', 'error_message': 'right_error_message'})


        # x:230 y:40, x:230 y:140, x:230 y:240, x:230 y:240
        _sm_look_3 = ConcurrencyContainer(outcomes=['seen', 'missing', 'timed_out'], input_keys=['component_id'], output_keys=['left_pose', 'error_code'], conditions=[
                                        ('seen', [('run', 'seen')]),
                                        ('missing', [('run', 'missing')]),
                                        ('timed_out', [('timer', 'done')])
                                        ])

        with _sm_look_3:
            # x:30 y:40
            OperatableStateMachine.add('run',
                                        _sm_run_2,
                                        transitions={'seen': 'seen', 'missing': 'missing'},
                                        autonomy={'seen': Autonomy.Inherit, 'missing': Autonomy.Inherit},
                                        remapping={'component_id': 'component_id', 'left_pose': 'left_pose', 'error_code': 'error_code'})

            # x:30 y:140
            OperatableStateMachine.add('timer',
                                        WaitState(wait_time=40.0),
                                        transitions={'done': 'timed_out'},
                                        autonomy={'done': Autonomy.Off})


        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('Look_attempts',
                                        CountAttemptsState(attempts=2),
                                        transitions={'counted': 'Look', 'exhausted': 'failed'},
                                        autonomy={'counted': Autonomy.Off, 'exhausted': Autonomy.Full},
                                        remapping={'attempt': 'look_attempts'})

            # x:430 y:40
            OperatableStateMachine.add('Place',
                                        _sm_place_1,
                                        transitions={'placed': 'Urgent', 'given up': 'Recover'},
                                        autonomy={'placed': Autonomy.Inherit, 'given up': Autonomy.Inherit},
                                        remapping={'cable_id': 'cable_id', 'where': 'look_left_pose', 'place_insert_attempts': 'place_insert_attempts', 'error_code': 'error_code', 'force': 'force'})

            # x:580 y:140
            OperatableStateMachine.add('Recover',
                                        _sm_recover_0,
                                        transitions={'free': 'failed', 'stuck': 'failed'},
                                        autonomy={'free': Autonomy.Inherit, 'stuck': Autonomy.Inherit},
                                        remapping={'cable_id': 'cable_id'})

            # x:580 y:40
            OperatableStateMachine.add('Urgent',
                                        CheckConditionState(predicate=lambda value: bool(value)),
                                        transitions={'true': 'done', 'false': 'done'},
                                        autonomy={'true': Autonomy.Off, 'false': Autonomy.Off},
                                        remapping={'input_value': 'is_urgent'})

            # x:280 y:40
            OperatableStateMachine.add('Look',
                                        _sm_look_3,
                                        transitions={'seen': 'Place', 'missing': 'Look_attempts', 'timed_out': 'failed'},
                                        autonomy={'seen': Autonomy.Inherit, 'missing': Autonomy.Inherit, 'timed_out': Autonomy.Inherit},
                                        remapping={'component_id': 'component_id', 'left_pose': 'look_left_pose', 'error_code': 'error_code'})


        return _state_machine


    # Functions of your own belong between these tags.
    # [MANUAL_FUNC]

    # [/MANUAL_FUNC]
