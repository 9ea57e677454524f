"""What a cell works on: panels, wires, frames, arms, cameras. Pure."""
