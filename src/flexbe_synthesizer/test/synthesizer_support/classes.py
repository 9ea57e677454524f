"""State classes of libraries that tests make up."""

from flexbe_synthesizer.core.library.signature import Parameter, Port, StateClass


def state_class(name, outcomes, inputs=(), outputs=(), package="p", parameters=(), **more):
    """Return a state class with the names given."""
    ports = (tuple(map(Port, inputs)), tuple(map(Port, outputs)))
    module = f"{package}.{name.lower()}"
    return StateClass(name, package, module, parameters, outcomes, *ports, **more)


COUNTER = state_class(
    "CountAttemptsState",
    ("counted", "exhausted"),
    inputs=["attempt"],
    outputs=["attempt"],
    package="remodel_states",
    parameters=(Parameter("attempts", "int"),),
)
