"""The topics of commands; relative names, as all of FlexBE's."""

COMMAND = "flexbe/uicommand"  # flexbe_msgs/UICommand
NOTIFICATION = "flexbe/uinotification"  # std_msgs/String: the command done, empty if refused
ANSWER = "flexbe/uianswer"  # std_msgs/String: in words, see core/answer.py
FEEDBACK = "flexbe/command_feedback"  # flexbe_msgs/CommandFeedback, from the engine
UPDATE = "flexbe/behavior_update"  # std_msgs/String: path of the state that is active
STATUS = "flexbe/status"  # flexbe_msgs/BEStatus, from the engine
ATTACH = "flexbe/command/attach"  # std_msgs/UInt8
LOCK = "flexbe/command/lock"  # std_msgs/String
UNLOCK = "flexbe/command/unlock"  # std_msgs/String
REQUEST = "flexbe/outcome_request"  # flexbe_msgs/OutcomeRequest
LOG = "flexbe/log"  # flexbe_msgs/BehaviorLog
HEARTBEAT = "flexbe/heartbeat"  # std_msgs/Empty, once a second
STRUCTURE = "flexbe/mirror/structure"  # flexbe_msgs/ContainerStructure
START = "flexbe/start_behavior"  # flexbe_msgs/BehaviorSelection
AUTONOMY = "flexbe/command/autonomy"  # std_msgs/UInt8
TRANSITION = "flexbe/command/transition"  # flexbe_msgs/OutcomeRequest: index, label of the state
PAUSE = "flexbe/command/pause"  # std_msgs/Bool
REPEAT = "flexbe/command/repeat"  # std_msgs/Empty
PREEMPT = "flexbe/command/preempt"  # std_msgs/Empty
SHOW_STRUCTURE = "flexbe/request_mirror_structure"  # std_msgs/Int32
USERDATA = "flexbe/get_userdata"  # flexbe_msgs/GetUserdata, a service of the engine
LEFT = "flexbe/debug/current_state"  # std_msgs/String: path > outcome, of what is supervised
USE_CASE = "remodel/use_case/state"  # remodel_msgs/UseCaseState, latched
RUN_USE_CASE = "remodel/run_use_case"  # remodel_msgs/RunUseCase, an action
RUN_COMMANDS = "remodel/use_case"  # its services: pause, resume, stop, skip, retry, answer
CELL = "cell"  # in whose namespace a cell's cameras are
