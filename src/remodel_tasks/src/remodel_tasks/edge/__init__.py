"""The rooms that touch the disk, the kernel's library, and the clock of a search."""
