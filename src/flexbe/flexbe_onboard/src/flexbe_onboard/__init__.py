"""The node that runs behaviors when it is asked to."""
