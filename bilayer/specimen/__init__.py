"""What is released: outline, pattern, layers, materials, prestretch, and their file."""
