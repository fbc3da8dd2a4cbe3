"""A specimen as a solid, its way through the milestones, and the dataset of it."""
