"""The load path of the shell: from milestone to milestone."""
