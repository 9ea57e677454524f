"""Every definition equals stock FlexBE's 1.4.1: peers compare these sums before they talk."""

from pathlib import Path

from flexbe_msgs import msg, srv

PACKAGE = Path(__file__).parents[2]

SUMS = {
    "BEStatus": "467355de4ad406f864268f41621cb885",
    "BehaviorLog": "03d7689372c7e2617b8d61fbf552e694",
    "BehaviorModification": "ac997193d826b145a432b8e3e528f6b4",
    "BehaviorRequest": "0b55949502d4c602376ee00a64d0d294",
    "BehaviorSelection": "514f1b101295bdbd417ee6cc46e3823c",
    "BehaviorSync": "118d64f48696509906c4cf4a228608b1",
    "CommandFeedback": "0c984ea7f8fc562a9c04a778877e1a03",
    "Container": "627eacc0f462c8ee83d7105e17cf4119",
    "ContainerStructure": "9cd26d15621063b90279d87117694328",
    "OutcomeCondition": "3f00d7f2d34167712ca29ef288547863",
    "OutcomeRequest": "b057cf075cb943bf0dbb3443419a61ed",
    "StateInstantiation": "1c6026e288cfff7ab6c8308ee1db66f1",
    "SynthesisErrorCodes": "64e05da1f86a12ce44b1cca74395bd4e",
    "SynthesisRequest": "99257dbfe8a196d006a75837dcabf3f6",
    "UICommand": "88f45469138737816fa9cd59fbf3c084",
    "UserdataInfo": "1772a03af66e5ec2ab7e8c44750f6721",
    "BehaviorExecutionAction": "5137e5877c4ee9dbe6ca4796ad090f1a",
    "BehaviorExecutionActionGoal": "60d736806adccc368a03e4e8d2e6f4e7",
    "BehaviorExecutionGoal": "448c2298fe3c13b6fd73cfc07e865a14",
    "BehaviorExecutionActionResult": "76e505f84da88685989704705a0d9846",
    "BehaviorExecutionResult": "2b95071cca675b3d5b80ad0bdaf20389",
    "BehaviorExecutionActionFeedback": "b767b030e0462dae1168f66f2dd64853",
    "BehaviorExecutionFeedback": "6b3c1b68b57cc9263bf79fc4ad6ec8c7",
    "BehaviorInputAction": "409aeef36c5fba868c3b1f845c52f119",
    "BehaviorInputActionGoal": "b2de1aae6b5512cca522fa05361cfdab",
    "BehaviorInputGoal": "724150348fd57a5ebc07765871d3f316",
    "BehaviorInputActionResult": "fbfb06b1b74139caf57e6c1834fe58bc",
    "BehaviorInputResult": "e0509f159e7c7bb2268efbc625f63b3f",
    "BehaviorInputActionFeedback": "aae20e09065c3809e8a8e87c4c8953fd",
    "BehaviorInputFeedback": "d41d8cd98f00b204e9800998ecf8427e",
    "BehaviorSynthesisAction": "3f70602e7ef6378d09fa82dd8284fb29",
    "BehaviorSynthesisActionGoal": "ef3bccd0f7dc68c4fe76a2cb791126b0",
    "BehaviorSynthesisGoal": "64ccf8fdad6091a950ca099bc67e6595",
    "BehaviorSynthesisActionResult": "d13a1c24e611f3c8aae59d09829d044b",
    "BehaviorSynthesisResult": "088bd6aee1c7ee2902db2babfd6af1c2",
    "BehaviorSynthesisActionFeedback": "74b2c8a9bddfff7e1b57abd9d9fb5b18",
    "BehaviorSynthesisFeedback": "ce404b6cabcba81b67a4c8bac81c05d3",
}


def test_messages_have_stocks_sums():
    assert {name: getattr(msg, name)._md5sum for name in SUMS} == SUMS


def test_the_service_has_stocks_sum():
    assert srv.GetUserdata._md5sum == "cf480fa533a0ed079b4f74ca618d3d84"


def test_every_definition_of_the_package_is_compared():
    defined = {path.stem for path in PACKAGE.glob("msg/*.msg")}
    parts = ("Action", "ActionGoal", "Goal", "ActionResult", "Result", "ActionFeedback", "Feedback")
    for path in PACKAGE.glob("action/*.action"):
        defined |= {path.stem + part for part in parts}
    assert defined == set(SUMS)
    assert [path.stem for path in PACKAGE.glob("srv/*.srv")] == ["GetUserdata"]
