"""What differs between the versions of dolfinx, and how forms are compiled."""
