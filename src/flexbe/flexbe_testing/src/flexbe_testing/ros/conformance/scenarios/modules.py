"""Modules of the behaviors in the conformance package."""

CHAIN = "conformance_chain_sm"
NEST = "conformance_nest_sm"
PAIR = "conformance_pair_sm"
PRIORITY = "conformance_priority_sm"
VALUES = "conformance_values_sm"
FAULT = "conformance_fault_sm"
