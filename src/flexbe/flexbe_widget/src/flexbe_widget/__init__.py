"""Start behaviors: from the command line, from launch files, by topic, and as an action."""
