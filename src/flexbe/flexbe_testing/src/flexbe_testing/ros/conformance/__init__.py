"""Play the conformance scenarios against an engine, by ROS only; nothing of flexbe_core."""
