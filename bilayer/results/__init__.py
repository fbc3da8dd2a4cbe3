"""The dataset of a run: made, written, read, compared, converted, reported."""
