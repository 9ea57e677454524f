"""Where behaviors are on disk: packages, manifests, source files."""
