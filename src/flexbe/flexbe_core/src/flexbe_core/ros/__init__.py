"""The shell around the engine: time, threads, commands in, facts out."""
