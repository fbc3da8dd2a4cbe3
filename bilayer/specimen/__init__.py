"""The specimen: outline, pattern, layers, materials, prestretch, and their file."""
