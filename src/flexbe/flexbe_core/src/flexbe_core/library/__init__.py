"""Where behaviors are: packages, manifests, source files."""
