"""Drawings and images of cuts, read into closed contours in metres."""
