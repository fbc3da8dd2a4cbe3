"""From a specimen to what a cutter needs: the parts to cut, what cannot be made of them, files."""
