"""The models of the shell: which energies, in which natural state."""
