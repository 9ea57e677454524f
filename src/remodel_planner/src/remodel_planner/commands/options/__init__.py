"""What several commands read: options, files of problems, signals to stop."""
