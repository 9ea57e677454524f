"""From-to lists: tables with a wire a line, and what their columns mean."""
