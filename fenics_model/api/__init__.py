"""The differences between the versions of dolfinx, and the options of the compiler."""
