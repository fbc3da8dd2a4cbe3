"""What a run needs of its machine: whole files, ranks, progress, signals, versions."""
