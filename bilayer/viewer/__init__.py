"""Results as a page that shows them in three dimensions, in any browser and without a network."""
