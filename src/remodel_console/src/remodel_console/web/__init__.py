"""The pages, and who may open them; the only room that knows NiceGUI."""
