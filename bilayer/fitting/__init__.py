"""From a test in a tensile machine to the constants of a law."""
