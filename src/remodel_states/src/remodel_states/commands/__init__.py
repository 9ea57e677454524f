"""The commands of this package, each with a `main` that returns an exit code."""
