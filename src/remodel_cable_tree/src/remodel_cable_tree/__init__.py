"""Cable Tree Wiring: in which order the ends of a harness's cables are inserted."""
