"""Measures of a released shape: its own frame, spans, best sphere, hemisphere."""
