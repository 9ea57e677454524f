"""Userdata, and the detection of changed inputs."""
