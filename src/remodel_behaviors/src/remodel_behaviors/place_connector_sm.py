#!/usr/bin/env python3
# -*- coding: utf-8 -*-
###########################################################
#        Generated from a state chart: do not edit        #
#                                                         #
#  Change the chart and synthesize it again.              #
#  Only the code between [MANUAL] tags is kept then.      #
###########################################################

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, PriorityContainer, Logger
from flexbe_states.decision_state import DecisionState
from remodel_states.count_attempts_state import CountAttemptsState
from remodel_states.extract_cable_state import ExtractCableState
from remodel_states.fix_cable_state import FixCableState
from remodel_states.insert_cable_state import InsertCableState
from remodel_states.locate_gearbox_component_state import LocateGearboxComponentState
# Imports of your own belong between these tags.
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on undated
@author: REMODEL planner developers
'''
class PlaceConnectorSM(Behavior):
    '''
    Places one end of a wire in a terminal: Figure 3 of Deliverable 5.1. A failed insertion or fixing pulls the end
    out and locates the component again, at most three times. What neither action nor behavior is to handle first
    (remodel_msgs/config/faults.yaml) fails at once. A push that jams, or needs more force (301, 304, 308), is not
    repeated here: the end is withdrawn, and the supervisor decides.
    '''


    def __init__(self):
        super(PlaceConnectorSM, self).__init__()
        self.name = 'Place Connector'

        # parameters of this behavior

        # references to used behaviors

        # Initialization of your own belongs between these tags.
        # [MANUAL_INIT]

        # [/MANUAL_INIT]

        # Behavior comments:



    def create(self):
        # x:1580 y:40, x:1580 y:140
        _state_machine = OperatableStateMachine(outcomes=['finished', 'failed'], input_keys=['cable_id', 'cable_end', 'component_id', 'terminal_id'], output_keys=['error_code', 'error_message'])
        _state_machine.userdata.cable_id = 'W1'
        _state_machine.userdata.cable_end = 'a'
        _state_machine.userdata.component_id = 'X1'
        _state_machine.userdata.terminal_id = '1'
        _state_machine.userdata.error_code = None
        _state_machine.userdata.error_message = None
        _state_machine.userdata.locate_gearbox_component_attempts = 0

        # Creation code of your own belongs between these tags.
        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('LocateGearboxComponent_attempts',
                                        CountAttemptsState(attempts=3),
                                        transitions={'counted': 'LocateGearboxComponent', 'exhausted': 'failed'},
                                        autonomy={'counted': Autonomy.Off, 'exhausted': Autonomy.Off},
                                        remapping={'attempt': 'locate_gearbox_component_attempts'})

            # x:1080 y:40
            OperatableStateMachine.add('FixCable',
                                        FixCableState(timeout_s=20.0),
                                        transitions={'fixed': 'finished', 'failed': 'FixCable_error', 'command_error': 'failed'},
                                        autonomy={'fixed': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'component_id': 'component_id', 'terminal_id': 'terminal_id', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:1330 y:40
            OperatableStateMachine.add('FixCable_error',
                                        DecisionState(outcomes=['failed_3_5', 'failed_7_10', 'failed_203_204', 'failed_304', 'failed_306_307', 'failed_308', 'failed_400_403', 'failed_405', 'other'], conditions=lambda code: 'failed_3_5' if code in range(3, 6) else 'failed_7_10' if code in range(7, 11) else 'failed_203_204' if code in range(203, 205) else 'failed_304' if code in range(304, 305) else 'failed_306_307' if code in range(306, 308) else 'failed_308' if code in range(308, 309) else 'failed_400_403' if code in range(400, 404) else 'failed_405' if code in range(405, 406) else 'other'),
                                        transitions={'failed_3_5': 'failed', 'failed_7_10': 'failed', 'failed_203_204': 'failed', 'failed_304': 'WithdrawCable', 'failed_306_307': 'failed', 'failed_308': 'WithdrawCable', 'failed_400_403': 'failed', 'failed_405': 'failed', 'other': 'ExtractCable'},
                                        autonomy={'failed_3_5': Autonomy.Off, 'failed_7_10': Autonomy.Off, 'failed_203_204': Autonomy.Off, 'failed_304': Autonomy.Off, 'failed_306_307': Autonomy.Off, 'failed_308': Autonomy.Off, 'failed_400_403': Autonomy.Off, 'failed_405': Autonomy.Off, 'other': Autonomy.Off},
                                        remapping={'input_value': 'error_code'})

            # x:730 y:40
            OperatableStateMachine.add('InsertCable',
                                        InsertCableState(timeout_s=60.0),
                                        transitions={'inserted': 'FixCable', 'failed': 'InsertCable_error', 'command_error': 'failed'},
                                        autonomy={'inserted': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'cable_end': 'cable_end', 'component_id': 'component_id', 'terminal_id': 'terminal_id', 'socket_pose': 'locate_gearbox_component_socket_pose', 'depth': 'insert_cable_depth', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:1080 y:140
            OperatableStateMachine.add('InsertCable_error',
                                        DecisionState(outcomes=['failed_3_5', 'failed_7_10', 'failed_110_111', 'failed_115', 'failed_203_204', 'failed_301', 'failed_304', 'failed_306_307', 'failed_308', 'failed_400_403', 'failed_405', 'other'], conditions=lambda code: 'failed_3_5' if code in range(3, 6) else 'failed_7_10' if code in range(7, 11) else 'failed_110_111' if code in range(110, 112) else 'failed_115' if code in range(115, 116) else 'failed_203_204' if code in range(203, 205) else 'failed_301' if code in range(301, 302) else 'failed_304' if code in range(304, 305) else 'failed_306_307' if code in range(306, 308) else 'failed_308' if code in range(308, 309) else 'failed_400_403' if code in range(400, 404) else 'failed_405' if code in range(405, 406) else 'other'),
                                        transitions={'failed_3_5': 'failed', 'failed_7_10': 'failed', 'failed_110_111': 'failed', 'failed_115': 'failed', 'failed_203_204': 'failed', 'failed_301': 'WithdrawCable', 'failed_304': 'WithdrawCable', 'failed_306_307': 'failed', 'failed_308': 'WithdrawCable', 'failed_400_403': 'failed', 'failed_405': 'failed', 'other': 'ExtractCable'},
                                        autonomy={'failed_3_5': Autonomy.Off, 'failed_7_10': Autonomy.Off, 'failed_110_111': Autonomy.Off, 'failed_115': Autonomy.Off, 'failed_203_204': Autonomy.Off, 'failed_301': Autonomy.Off, 'failed_304': Autonomy.Off, 'failed_306_307': Autonomy.Off, 'failed_308': Autonomy.Off, 'failed_400_403': Autonomy.Off, 'failed_405': Autonomy.Off, 'other': Autonomy.Off},
                                        remapping={'input_value': 'error_code'})

            # x:380 y:40
            OperatableStateMachine.add('LocateGearboxComponent',
                                        LocateGearboxComponentState(timeout_s=30.0),
                                        transitions={'located': 'InsertCable', 'failed': 'LocateGearboxComponent_error', 'command_error': 'failed'},
                                        autonomy={'located': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'component_id': 'component_id', 'terminal_id': 'terminal_id', 'component_pose': 'locate_gearbox_component_component_pose', 'socket_pose': 'locate_gearbox_component_socket_pose', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:730 y:140
            OperatableStateMachine.add('LocateGearboxComponent_error',
                                        DecisionState(outcomes=['failed_3_5', 'failed_7_10', 'failed_102_103', 'failed_306_307', 'failed_400_403', 'failed_405', 'other'], conditions=lambda code: 'failed_3_5' if code in range(3, 6) else 'failed_7_10' if code in range(7, 11) else 'failed_102_103' if code in range(102, 104) else 'failed_306_307' if code in range(306, 308) else 'failed_400_403' if code in range(400, 404) else 'failed_405' if code in range(405, 406) else 'other'),
                                        transitions={'failed_3_5': 'failed', 'failed_7_10': 'failed', 'failed_102_103': 'failed', 'failed_306_307': 'failed', 'failed_400_403': 'failed', 'failed_405': 'failed', 'other': 'LocateGearboxComponent_attempts'},
                                        autonomy={'failed_3_5': Autonomy.Off, 'failed_7_10': Autonomy.Off, 'failed_102_103': Autonomy.Off, 'failed_306_307': Autonomy.Off, 'failed_400_403': Autonomy.Off, 'failed_405': Autonomy.Off, 'other': Autonomy.Off},
                                        remapping={'input_value': 'error_code'})

            # x:1330 y:140
            OperatableStateMachine.add('WithdrawCable',
                                        ExtractCableState(timeout_s=30.0),
                                        transitions={'extracted': 'failed', 'failed': 'failed', 'command_error': 'failed'},
                                        autonomy={'extracted': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'component_id': 'component_id', 'terminal_id': 'terminal_id', 'socket_pose': 'locate_gearbox_component_socket_pose', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:1330 y:240
            OperatableStateMachine.add('ExtractCable',
                                        ExtractCableState(timeout_s=30.0),
                                        transitions={'extracted': 'LocateGearboxComponent_attempts', 'failed': 'failed', 'command_error': 'failed'},
                                        autonomy={'extracted': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'component_id': 'component_id', 'terminal_id': 'terminal_id', 'socket_pose': 'locate_gearbox_component_socket_pose', 'error_code': 'error_code', 'error_message': 'error_message'})


        return _state_machine


    # Functions of your own belong between these tags.
    # [MANUAL_FUNC]

    # [/MANUAL_FUNC]
