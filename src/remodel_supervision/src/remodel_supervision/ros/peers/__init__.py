"""The processes beside the supervisor, as its ports: cell, engine, synthesizer, cameras."""
