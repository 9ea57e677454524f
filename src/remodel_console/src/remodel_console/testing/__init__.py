"""What browser tests of the console need; other packages' tests use it too."""
