#!/usr/bin/env python3
# -*- coding: utf-8 -*-
###########################################################
#        Generated from a state chart: do not edit        #
#                                                         #
#  Change the chart and synthesize it again.              #
#  Only the code between [MANUAL] tags is kept then.      #
###########################################################

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, PriorityContainer, Logger
from cell_behaviors.clean_up_sm import CleanUpSM
from cell_states.insert_cable_state import InsertCableState as cell_states__InsertCableState
from cell_states.locate_component_state import LocateComponentState as cell_states__LocateComponentState
# Imports of your own belong between these tags.
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on undated
@author: REMODEL planner developers
'''
class plain_chartSM(Behavior):
    '''
    A chart of Deliverable 5.1 alone, with each element of its chapter 6. The cell’s own words.
    '''


    def __init__(self):
        super(plain_chartSM, self).__init__()
        self.name = 'plain_chart'

        # parameters of this behavior

        # references to used behaviors
        self.add_behavior(CleanUpSM, 'Clean Up')

        # Initialization of your own belongs between these tags.
        # [MANUAL_INIT]

        # [/MANUAL_INIT]

        # Behavior comments:



    def create(self):
        # x:780 y:40, x:780 y:140
        _state_machine = OperatableStateMachine(outcomes=['PlacePin finished normally', 'failed'], input_keys=['component_id', 'cable_id'], output_keys=['where', 'force'])
        _state_machine.userdata.component_id = None
        _state_machine.userdata.cable_id = None
        _state_machine.userdata.where = None
        _state_machine.userdata.force = None

        # Creation code of your own belongs between these tags.
        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('Locate',
                                        cell_states__LocateComponentState(timeout_s=2, topic='cell_2/locate'),
                                        transitions={'located': 'Insert', 'failed': 'failed'},
                                        autonomy={'located': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'component_id': 'component_id', 'pose': 'where', 'error_code': 'locate_error_code', 'error_message': 'locate_error_message'})

            # x:330 y:40
            OperatableStateMachine.add('Insert',
                                        cell_states__InsertCableState(force_limit_n=-15.0),
                                        transitions={'inserted': 'Clean Up', 'failed': 'failed'},
                                        autonomy={'inserted': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'pose': 'where', 'force': 'force', 'error_code': 'insert_error_code', 'error_message': 'insert_error_message'})

            # x:580 y:40
            OperatableStateMachine.add('Clean Up',
                                        self.use_behavior(CleanUpSM, 'Clean Up', default_keys=['thoroughness'], parameters={'speed': 1, 'places': ['here \x28left\x29', 'there']}),
                                        transitions={'cleaned': 'PlacePin finished normally', 'failed': 'failed'},
                                        autonomy={'cleaned': Autonomy.Inherit, 'failed': Autonomy.Inherit},
                                        remapping={'cable_id': 'cable_id', 'left_over': 'clean_up_left_over'})


        return _state_machine


    # Functions of your own belong between these tags.
    # [MANUAL_FUNC]

    # [/MANUAL_FUNC]
