"""Services of the machine to a run: whole files, ranks, progress, signals, versions."""
