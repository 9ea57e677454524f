"""What a conformance scenario is, how messages are compared, and how findings are printed."""
