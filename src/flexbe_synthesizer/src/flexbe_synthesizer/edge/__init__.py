"""The disk and the Graphviz process."""
