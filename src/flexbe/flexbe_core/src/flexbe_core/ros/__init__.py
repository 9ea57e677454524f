"""The shell around the engine: time, threads, topics."""
