"""For the test of flexbe_doctor; each line with a finding names its rule."""
